//! Which flag takes the place of which key of a scene, or is which argument of the library.

/// Keys and arguments, each with its flag.
const FLAGS: [(&str, &str); 28] = [
    ("preset", "--preset"),
    ("sun.elevation", "--sun-elevation"),
    ("sun.azimuth", "--sun-azimuth"),
    ("sun.place", "--place"),
    ("sun.time", "--time"),
    ("sun.disc", "--sun-disc"),
    ("observer.altitude", "--altitude"),
    ("camera.projection", "--projection"),
    ("camera.size", "--size"),
    ("camera.fov", "--fov"),
    ("camera.look_azimuth", "--look-azimuth"),
    ("camera.look_elevation", "--look-elevation"),
    ("render.fit", "--fit"),
    ("render.bands", "--bands"),
    ("render.color", "--color"),
    ("render.steps", "--steps"),
    ("render.path", "--path"),
    ("render.exposure", "--exposure"),
    ("render.exr", "--exr"),
    ("render.rgb", "--rgb"),
    ("render.observer", "--observer"),
    ("render.white_balance", "--white-balance"),
    ("spectral", "--spectral"),
    ("wavelengths", "--wavelengths"),
    ("view_elevation", "--view-elevation"),
    ("view_azimuth", "--view-azimuth"),
    ("count", "--count"),
    ("sun_elevations", "--sun-elevations"),
];

/// The flag of a key or an argument.
pub fn flag(key: &str) -> Option<&'static str> {
    FLAGS.iter().find(|(name, _)| *name == key).map(|(_, flag)| *flag)
}
