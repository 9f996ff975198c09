"""Lights three spheres on a plane by a sky of sorairo and by its sun, in Mitsuba 3.

Usage: lit_scene.py SKY REPORT PICTURE: an equirectangular EXR, what `sorairo render --json` said of it, and the picture
to write.
"""

import json
import sys

import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")

sky_file, report_file, picture = sys.argv[1:]
report = json.load(open(report_file))

# x north, y west, z up.
elevation, azimuth = np.radians([report["sun_elevation"], report["sun_azimuth"]])
to_sun = [np.cos(elevation) * np.cos(azimuth), -np.cos(elevation) * np.sin(azimuth), np.sin(elevation)]

T = mi.ScalarTransform4f


def sphere(x, y, radius, bsdf):
    return {"type": "sphere", "center": [x, y, radius], "radius": radius, "bsdf": bsdf}


def matte(*reflectance):
    return {"type": "diffuse", "reflectance": {"type": "rgb", "value": list(reflectance)}}


# Where the map has no disc in it the sun is a light of its own, through the same air. With a disc it must not be
# counted twice.
sun = {
    "type": "directional",
    "direction": [-c for c in to_sun],
    "irradiance": {"type": "rgb", "value": report["sun_irradiance_rgb"]},
}
suns = {} if report["sun_disc"] else {"sun": sun}

scene = mi.load_dict(
    {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": 4},
        # Mitsuba's envmap has y up: x to y, y to z, z to x.
        "sky": {"type": "envmap", "filename": sky_file, "to_world": T([[0, 0, 1, 0], [1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 1]])},
        **suns,
        "ground": {"type": "disk", "to_world": T().scale([5000, 5000, 1]), "bsdf": matte(0.25, 0.25, 0.25)},
        "white": sphere(0, 1.2, 1.0, matte(0.8, 0.8, 0.8)),
        "mirror": sphere(0, -1.2, 1.0, {"type": "conductor", "material": "none"}),
        "orange": sphere(-2.2, 0, 0.6, matte(0.7, 0.3, 0.1)),
        "camera": {
            "type": "perspective",
            "fov": 40,
            "to_world": T().look_at(origin=[-9, 0, 2.2], target=[0, 0, 1.1], up=[0, 0, 1]),
            "film": {"type": "hdrfilm", "width": 480, "height": 270, "pixel_format": "rgb", "component_format": "float32"},
            "sampler": {"type": "independent"},
        },
    }
)
image = np.array(mi.render(scene, spp=64, seed=1))
# One exposure for the whole picture, as a camera has it.
image *= 0.6 / np.percentile(image, 90)
mi.util.write_bitmap(picture, mi.Bitmap(image.astype(np.float32)))
print(f"wrote {picture}")
