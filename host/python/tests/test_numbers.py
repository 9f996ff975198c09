"""The numbers: those of the command, of an integral by hand, and of other people's programs."""

import json

import colour
import numpy as np
import OpenEXR
import pytest
import sorairo
from conftest import WAVELENGTHS

SCENES = [
    (dict(sun_elevation=20, sun_azimuth=70), ["--sun-elevation=20", "--sun-azimuth=70"]),
    (dict(preset="hazy", sun_elevation=-2, albedo="snow"), ["--preset=hazy", "--sun-elevation=-2", "--albedo=snow"]),
    (
        dict(place=(43.06, 141.35), time="2026-06-21T08:30:00+09:00", keys={"observer.altitude": 3, "render.fit": "cubic"}),
        ["--place=43.06,141.35", "--time=2026-06-21T08:30:00+09:00", "--altitude=3", "--fit=cubic"],
    ),
]


@pytest.mark.parametrize(("parameters", "flags"), SCENES)
def test_radiance_is_that_of_the_command_bit_for_bit(command, parameters, flags):
    sky = sorairo.Sky(**parameters)
    for elevation, azimuth in [(30, 90), (-5, 10), (90, 0)]:
        view = [f"--view-elevation={elevation}", f"--view-azimuth={azimuth}", "--wavelengths=380:780:50", "--format=json"]
        said = json.loads(command("spectrum", *view, *flags))
        at = [sample["wavelength_nm"] for sample in said]
        assert list(sky.radiance(elevation, azimuth, at)) == [sample["radiance"] for sample in said]
        assert list(sky.radiance(elevation, azimuth, at, method="dense")) == [sample["dense"] for sample in said]


@pytest.mark.parametrize(("parameters", "flags"), SCENES)
def test_the_air_before_a_point_is_that_of_the_command(command, parameters, flags):
    sky = sorairo.Sky(**parameters)
    at = [450, 550, 650]
    transmittance, radiance = sky.between(2, [90, 10], [[0], [20], [np.inf]], at)
    assert transmittance.shape == radiance.shape == (3, 2, 3)
    assert (transmittance[0] == 1).all() and (radiance[0] == 0).all()
    assert (np.diff(transmittance, axis=0) < 0).all() and (np.diff(radiance, axis=0) > 0).all()
    view = ["--view-elevation=2", "--view-azimuth=10", "--distance=20", "--wavelengths=450,550,650", "--format=json"]
    said = json.loads(command("between", *view, *flags))
    assert list(transmittance[1, 1]) == [sample["transmittance"] for sample in said]
    assert list(radiance[1, 1]) == [sample["radiance"] for sample in said]


def test_the_air_before_a_point_as_rgb_is_that_of_the_command(command):
    sky = sorairo.Sky(sun_elevation=20, sun_azimuth=0)
    transmittance, radiance = sky.between(2, [90, 10], [[0], [20]], rgb=True)
    assert transmittance.shape == radiance.shape == (2, 2, 3)
    assert (transmittance[0] == 1).all() and (radiance[0] == 0).all()
    # Air takes blue and gives blue.
    assert (np.diff(transmittance[1]) < 0).all() and (radiance[1, 0, 2] > radiance[1, 0, 0]).all()
    view = ["--view-elevation=2", "--view-azimuth=10", "--distance=20", "--rgb", "--format=json"]
    said = json.loads(command("between", *view, "--sun-elevation=20", "--sun-azimuth=0"))
    assert list(transmittance[1, 1]) == said["transmittance"] and list(radiance[1, 1]) == said["radiance"]


def test_stokes_vectors_are_those_of_the_command(command):
    sky = sorairo.Sky("earth", sun_elevation=20, sun_azimuth=0, keys={"render.polarisation": "on"})
    at = [400, 550]
    found = sky.stokes([30, 90], [[90], [-90]], at)
    assert found.shape == (2, 2, 2, 3)
    # Both sides of the sun are each other's mirror image.
    assert np.allclose(found[0, 0] * [1, 1, -1], found[1, 0], rtol=1e-9)
    flags = ["--preset=earth", "--sun-elevation=20", "--sun-azimuth=0", "--polarisation=on", "--view-elevation=30", "--view-azimuth=90"]
    said = json.loads(command("spectrum", "--stokes", "--wavelengths=400,550", "--format=json", *flags))
    assert [list(of) for of in found[0, 0]] == [[sample[f"stokes_{part}"] for part in "iqu"] for sample in said]
    degree = np.hypot(found[0, 0, :, 1], found[0, 0, :, 2]) / found[0, 0, :, 0]
    assert np.allclose(degree, [sample["degree_of_polarisation"] for sample in said]) and (degree > 0.3).all()


@pytest.mark.parametrize(("parameters", "flags"), SCENES)
@pytest.mark.parametrize("device", ["cpu", "gpu"])
def test_an_image_is_that_of_the_command_bit_for_bit(command, tmp_path, parameters, flags, device):
    command("render", "--size=64x32", f"--device={device}", "-osky.exr", *flags)
    said = OpenEXR.File(str(tmp_path / "sky.exr")).channels()["RGB"].pixels
    found = sorairo.Sky(**parameters).render(size=(64, 32), device=device)
    assert found.shape == (32, 64, 3) and found.dtype == np.float32 and found.max() > 0
    assert np.array_equal(found, said)


def test_a_spectral_image_holds_the_radiance_of_its_directions():
    sky = sorairo.Sky(sun_elevation=25, sun_azimuth=0)
    at = [400, 500, 700]
    image = sky.render(size=(36, 18), wavelengths=at, device="cpu")
    elevations, azimuths = 90 - (np.arange(18) + 0.5) * 10, (np.arange(36) + 0.5) * 10 - 180
    expected = sky.radiance(elevations[:, None], azimuths[None, :], at)
    # The image is computed in single precision.
    assert np.abs(image / expected - 1).max() < 1e-3


def test_directions_are_broadcast_and_wavelengths_come_last():
    sky = sorairo.Sky()
    assert sky.radiance(45, 0, 550).shape == ()
    assert sky.radiance([[10], [20]], [0, 90, 180], [450, 550, 650, 750]).shape == (2, 3, 4)
    assert sky.luminance([10, 20, 30], 0).shape == (3,)
    assert sky.xyz(10, [0, 90]).shape == (2, 3)
    one = sky.radiance(20, 180, [450, 550, 650, 750])
    assert np.array_equal(sky.radiance([[10], [20]], [0, 90, 180], [450, 550, 650, 750])[1, 2], one)


def cosines(size, tilt, azimuth):
    """The cosine to a surface's normal, times the solid angle, of each pixel of an equirectangular image."""
    width, height = size
    e = np.radians(90 - (np.arange(height) + 0.5) * 180 / height)[:, None]
    a = np.radians((np.arange(width) + 0.5) * 360 / width - 180)[None, :]
    t, s = np.radians(tilt), np.radians(azimuth)
    cosine = np.cos(t) * np.sin(e) + np.sin(t) * np.cos(e) * np.cos(a - s)
    return np.maximum(cosine, 0) * np.cos(e) * (2 * np.pi / width) * (np.pi / height)


@pytest.mark.parametrize(("tilt", "azimuth"), [(0, 180), (90, 100), (40, 180), (130, 20)])
@pytest.mark.parametrize("sun", [35, 4])
def test_irradiance_is_the_integral_of_an_image(sun, tilt, azimuth):
    at, size = [400, 550, 700], (720, 360)
    sky = sorairo.Sky(sun_elevation=sun, sun_azimuth=120)
    fallen = sky.irradiance(at, surface_tilt=tilt, surface_azimuth=azimuth)
    lit = sky.render(size, at, device="cpu").astype(np.float64) * cosines(size, tilt, azimuth)[..., None]
    above, below = lit[:180].sum(axis=(0, 1)), lit[180:].sum(axis=(0, 1))
    errors = np.abs([fallen["diffuse"] - above, fallen["ground"] - below]) / (above + below)
    print(f"sun {sun}, tilt {tilt}: {errors.max():.1e}")
    assert errors.max() < 5e-3
    assert np.allclose(fallen["global"], fallen["direct"] + fallen["diffuse"] + fallen["ground"], rtol=1e-12)


def test_the_suns_light_is_its_transmittance_times_the_cosine():
    straight = {"atmosphere.profile": "exponential"}
    sky = sorairo.Sky(sun_elevation=30, sun_azimuth=120, keys=straight)
    facing = sky.irradiance(WAVELENGTHS, surface_tilt=60, surface_azimuth=120)["direct"]
    level = sky.irradiance(WAVELENGTHS)["direct"]
    # The disc is half a degree wide.
    assert np.allclose(level, facing * np.sin(np.radians(30)), rtol=1e-4)
    assert np.all(sky.irradiance(WAVELENGTHS, surface_tilt=90, surface_azimuth=300)["direct"] == 0)
    transmittance = sky.sun_transmittance(WAVELENGTHS)
    # Above the atmosphere nothing is in the way.
    in_space = sorairo.Sky(sun_elevation=30, sun_azimuth=120, keys=straight | {"observer.altitude": 1000})
    # What single precision leaves of the nodes of the sum over the disc.
    assert np.allclose(in_space.sun_transmittance(WAVELENGTHS), 1, atol=5e-5)
    measured = sorairo.Sky(sun_elevation=40, keys={"atmosphere.profile": "us-standard", "atmosphere.water.column": 1.4})
    blue, water, oxygen = measured.sun_transmittance([450, 1380, 760.5])
    assert water < 1e-3 < oxygen < 0.5 < blue
    above = in_space.irradiance(WAVELENGTHS, surface_tilt=60, surface_azimuth=120)["direct"]
    assert np.allclose(facing / above, transmittance, rtol=5e-5)
    assert 0.1 < transmittance[0] < transmittance[-1] < 1


def test_totals_are_those_of_the_command(report):
    said = report("--preset=earth", "--sun-elevation=12")
    sky = sorairo.Sky("earth", sun_elevation=12)
    fallen = {name: np.trapezoid(part, WAVELENGTHS) for name, part in sky.irradiance(WAVELENGTHS).items()}
    # Sums take the mean of the sun over each 5 nm, spectra what it is at the wavelength: the lines between are half a
    # per cent.
    assert fallen["diffuse"] == pytest.approx(said["irradiance_w_m2"], rel=0.01)
    assert fallen["direct"] == pytest.approx(said["direct_irradiance_w_m2"], rel=0.01)
    assert fallen["ground"] == 0
    assert sky.illuminance()["diffuse"] == pytest.approx(said["illuminance_lux"], rel=1e-9)
    # The zenith as an angle is rounded to single precision.
    assert sky.luminance(90, 0) == pytest.approx(said["luminance_zenith_cd_m2"], rel=1e-6)
    below = {name: np.trapezoid(part, WAVELENGTHS) for name, part in sky.irradiance(WAVELENGTHS, surface_tilt=180).items()}
    assert below["ground"] == pytest.approx(said["ground_irradiance_w_m2"], rel=0.01)


def test_colour_science_sees_the_same_colours():
    # Without the lines of a sun and of gases, over which colours take means, a sum of 5 nm is theirs too.
    sky = sorairo.Sky("earth", sun_elevation=8, sun_azimuth=90, keys={"sun.spectrum": "flat"})
    shape = colour.SpectralShape(380, 780, 5)
    functions = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"].copy().align(shape)
    for elevation, azimuth in [(60, 0), (10, 90), (5, 270)]:
        spectrum = sky.radiance(elevation, azimuth, WAVELENGTHS)
        theirs = spectrum @ functions.values * 5
        assert np.abs(theirs / sky.xyz(elevation, azimuth) - 1).max() < 1e-6
        assert sky.luminance(elevation, azimuth) == pytest.approx(683 * theirs[1], rel=1e-6)


def test_a_night_is_black():
    sky = sorairo.Sky(sun_elevation=-40)
    assert not sky.render((8, 4), device="cpu").any()
    assert not sky.irradiance([450, 550])["global"].any()


def test_a_scene_gives_its_sky_again(tmp_path, command):
    sky = sorairo.Sky("hazy", sun_elevation=7, keys={"atmosphere.aerosol.optical_depth": 0.2})
    (tmp_path / "sky.toml").write_text(sky.scene)
    again = sorairo.Sky(scene=tmp_path / "sky.toml")
    assert np.array_equal(sky.radiance(20, [0, 90], WAVELENGTHS), again.radiance(20, [0, 90], WAVELENGTHS))
    assert "ok" in command("scene", "check", "sky.toml")


def test_surfaces_are_broadcast_and_wavelengths_come_last():
    sky = sorairo.Sky(sun_elevation=25, sun_azimuth=120)
    tilts, azimuths = np.array([[0.0], [60.0], [90.0]]), np.array([90.0, 200.0])
    fallen, lux, opic = sky.irradiance([450, 600], tilts, azimuths), sky.illuminance(tilts, azimuths), sky.alpha_opic(tilts, azimuths)
    assert fallen["global"].shape == (3, 2, 2) and lux["direct"].shape == opic["rhodopic"].edi["direct"].shape == (3, 2)
    for i, j in np.ndindex(3, 2):
        surface = tilts[i, 0], azimuths[j]
        for name, part in sky.irradiance([450, 600], *surface).items():
            assert np.array_equal(fallen[name][i, j], part)
            assert lux[name][i, j] == sky.illuminance(*surface)[name]
            assert opic["melanopic"].edi[name][i, j] == sky.alpha_opic(*surface)["melanopic"].edi[name]
    assert isinstance(sky.illuminance()["global"], float) and isinstance(sky.alpha_opic()["melanopic"].edi["global"], float)


# Efficacies of luminous radiation of daylight D65 (mW/lm), as CIE S 026:2018 states them.
OF_D65 = {"s_cone_opic": 0.8173, "m_cone_opic": 1.4558, "l_cone_opic": 1.6289, "rhodopic": 1.4497, "melanopic": 1.3262}


@pytest.fixture
def daylight(tmp_path):
    """A table of D65 as a sun, W·m⁻²·nm⁻¹."""
    d65 = colour.SDS_ILLUMINANTS["D65"]
    rows = [f"{nm:g},{value / 100}" for nm, value in zip(d65.wavelengths, d65.values)]
    (tmp_path / "d65.csv").write_text("\n".join(["nm,value", *rows]))
    return tmp_path / "d65.csv"


def test_the_equivalent_of_daylight_is_daylight_itself(daylight):
    # Above the atmosphere, towards the sun, there is nothing but its light.
    sky = sorairo.Sky(sun_elevation=90, keys={"observer.altitude": 1000, "sun.spectrum": str(daylight)})
    lux, found = sky.illuminance()["direct"], sky.alpha_opic()
    assert list(found) == list(OF_D65)
    for name, efficacy in OF_D65.items():
        # Half a unit of the standard's last digit is 6e-5 of the smallest; sums by 5 nm in the place of 1 leave 1e-4 of
        # the lux.
        assert found[name].irradiance["direct"] / lux == pytest.approx(efficacy / 1000, rel=3e-4), name
        assert found[name].edi["direct"] == pytest.approx(lux, rel=3e-4), name


def test_alpha_opic_irradiance_is_the_sum_with_the_action_spectrum():
    sky = sorairo.Sky(sun_elevation=10, sun_azimuth=90)
    found = sky.alpha_opic(90, 180)
    at = np.arange(380, 781)
    rods = colour.colorimetry.SDS_LEFS_SCOTOPIC["CIE 1951 Scotopic Standard Observer"].copy().align(colour.SpectralShape(380, 780, 1)).values
    for name, part in sky.irradiance(at, 90, 180).items():
        # The rods' action spectrum is that of scotopic vision, which colour-science has from elsewhere. What differs is
        # the order of the sum.
        assert found["rhodopic"].irradiance[name] == pytest.approx(part @ rods, rel=1e-9)
        assert found["rhodopic"].edi[name] == pytest.approx(found["rhodopic"].irradiance[name] / 1.4497e-3, rel=1e-12)


def test_a_bluer_light_has_more_of_the_shorter_wavelengths():
    sky = sorairo.Sky(sun_elevation=20, sun_azimuth=90)
    lux = sky.illuminance(90, 270)["diffuse"]
    ratio = {name: of.edi["diffuse"] / lux for name, of in sky.alpha_opic(90, 270).items()}
    assert ratio["s_cone_opic"] > ratio["melanopic"] > ratio["m_cone_opic"] > ratio["l_cone_opic"] and ratio["melanopic"] > 1.1


def test_several_aerosols_are_those_of_a_scene_file(tmp_path):
    table = tmp_path / "extinction.csv"
    table.write_text("wavelength_nm,extinction\n440,0.5\n870,0.2\n")
    modes = [
        {"kind": "continental-average", "optical_depth": 0.1, "profile": 1.5},
        {"optical_depth": np.float64(0.05), "reference_wavelength": 440, "extinction": table, "profile": [8, 12]},
    ]
    scene = tmp_path / "scene.toml"
    scene.write_text(
        "[[atmosphere.aerosol]]\nkind = 'continental-average'\noptical_depth = 0.1\nprofile = 1.5\n"
        "[[atmosphere.aerosol]]\noptical_depth = 0.05\nreference_wavelength = 440\nextinction = 'extinction.csv'\nprofile = [8, 12]\n"
    )
    given, read = sorairo.Sky(keys={"atmosphere.aerosol": modes}), sorairo.Sky(scene=scene)
    assert given.radiance(20, 40, [450, 600]).tolist() == read.radiance(20, 40, [450, 600]).tolist()
    assert given.radiance(20, 40, 450) != sorairo.Sky().radiance(20, 40, 450)
    with pytest.raises(ValueError, match="unknown field `colour`"):
        sorairo.Sky(keys={"atmosphere.aerosol": [{"colour": 1}]})
    with pytest.raises(ValueError, match="the scene lists its aerosols"):
        sorairo.Sky(scene=scene, keys={"atmosphere.aerosol.optical_depth": 0.1})


def test_the_sky_is_known_through_lines_to_2500_nm(command):
    at = [320, 550, 762.5, 1380, 2200]
    view = ["--sun-elevation=20", "--view-elevation=30", "--view-azimuth=90", f"--wavelengths={','.join(map(str, at))}", "--format=json"]
    said = json.loads(command("spectrum", *view))
    sky = sorairo.Sky(sun_elevation=20)
    assert list(sky.radiance(30, 90, at)) == [sample["radiance"] for sample in said]
    fallen = sky.irradiance(np.arange(280.5, 2500))
    light = json.loads(command("render", "--sun-elevation=20", "--size=8x4", "-osky.png", "--json"))
    # The command computes half as many wavelengths.
    assert fallen["global"].sum() == pytest.approx(light["ghi_w_m2"], rel=1e-3)
    assert fallen["diffuse"].sum() == pytest.approx(light["dhi_w_m2"], rel=2e-3)
    assert light["ghi_w_m2"] == pytest.approx(light["dhi_w_m2"] + light["dni_w_m2"] * np.sin(np.radians(20.04)), rel=1e-3)
