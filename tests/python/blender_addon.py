"""Registers the add-on of docs/blender in Blender and lights scenes by it.

Usage: blender_addon.py PROGRAM: the command sorairo.
"""

import sys
from math import degrees, radians, sin
from pathlib import Path

import bpy
import numpy as np
from blender_scene import camera, empty, irradiance, rendered
from mathutils import Vector

sys.path.insert(0, str(Path(__file__).parent / "../../docs/blender"))
import sorairo

sorairo.register()
# A pixel of the map (degrees).
WIDTH = 1024
PIXEL = 360 / WIDTH


def lit(**settings):
    """A scene that the add-on lights, and what sorairo says of its sky."""
    scene = empty()
    settings = {"program": sys.argv[1], "width": WIDTH, **settings}
    for name, value in settings.items():
        setattr(scene.sorairo, name, value)
    said = {}
    told = sorairo.update

    def update(scene):
        said.update(told(scene))
        return said

    sorairo.update = update
    assert bpy.ops.sorairo.update() == {"FINISHED"}
    sorairo.update = told
    return scene, said


def towards_sun():
    """Where the lamp's light comes from."""
    bpy.context.view_layer.update()
    return bpy.data.objects[sorairo.SUN].matrix_world.to_3x3() @ Vector((0, 0, 1))


for settings in [
    {"elevation": 40, "azimuth": 60, "north": 90},
    {"elevation": 12, "azimuth": 215, "north": 20, "visibility": 30, "exposure": "adapt"},
    {"by": "PLACE", "latitude": 38.72, "longitude": -9.14, "time": "2026-09-22T17:00:00+01:00", "north": 0},
]:
    scene, said = lit(**settings)
    elevation = radians(said["sun_elevation"])
    measured = irradiance(scene)
    expected = np.array(said["irradiance_rgb"]) + sin(elevation) * np.array(said["sun_irradiance_rgb"])
    error = np.abs(measured / expected - 1).max()
    print(f"irradiance {measured} W/m2, sorairo says {expected}: {error:.1e}")
    # Chance leaves 3e-5 of 64 pixels with 2048 samples, and what lies between the map's pixels is Blender's to say.
    assert error < 1e-3, error

    # The sky alone in lux: 683 lm/W of the luminance of linear Rec. 709.
    bpy.data.objects[sorairo.SUN].hide_render = True
    sky = 683 * irradiance(scene) @ [0.2126, 0.7152, 0.0722]
    error = abs(sky / said["illuminance_lux"] - 1)
    print(f"the sky gives {sky:.0f} lx, sorairo says {said['illuminance_lux']:.0f}: {error:.1e}")
    assert error < 1e-3, error

    # The lamp stands where the bearings say.
    to_sun = towards_sun()
    bearing = degrees(np.arctan2(to_sun.y, to_sun.x))
    off = (settings["north"] - said["sun_azimuth"] - bearing + 180) % 360 - 180
    assert abs(off) < 1e-3 and abs(degrees(np.arcsin(to_sun.z)) - said["sun_elevation"]) < 1e-3, (off, to_sun)
    lamp = bpy.data.lights[sorairo.SUN]
    assert 0.523 < degrees(lamp.angle) < 0.543

    # A camera that looks towards the lamp sees the disc of the map in the middle of its picture.
    side, fov = 81, radians(8)
    camera(scene, (0, 0, 0), to_sun.to_track_quat("-Z", "Y").to_euler(), lens_unit="FOV", angle=fov)
    scene.render.filter_size = 0.01
    seen = rendered(scene, "sun.exr", side, side, 1, "OPEN_EXR", "32")[..., 1]
    rows, columns = np.nonzero(seen > 0.5 * seen.max())
    middle = np.array([rows.mean(), columns.mean()]) - (side - 1) / 2
    away = degrees(fov) / side * np.hypot(*middle)
    print(f"the disc is {away:.2f} degrees off the lamp")
    # The disc is wider than a pixel, which shows it averaged over its own part of the sky.
    assert away < PIXEL and seen.max() > 50 * np.median(seen), (away, seen.max(), np.median(seen))
    if settings.get("exposure", "auto") == "auto":
        assert abs(scene.view_settings.exposure - said["exposure_ev"]) < 1e-5
    assert scene.view_settings.view_transform == "AgX"

# Another sky takes the place of the last: one world, one lamp, the maps of now.
before = {kind: len(getattr(bpy.data, kind)) for kind in ["worlds", "lights", "images", "objects"]}
scene.sorairo.by, scene.sorairo.elevation = "ANGLES", -3
bpy.ops.sorairo.update()
assert {kind: len(getattr(bpy.data, kind)) for kind in before} == before
assert bpy.data.lights[sorairo.SUN].energy == 0

# What is refused is told in the program's sentence, and by the operator.
for name, value, words in [("time", "noon", "a time is written as"), ("program", "no-such-program", "does not start")]:
    scene.sorairo.by = "PLACE"
    setattr(scene.sorairo, name, value)
    try:
        bpy.ops.sorairo.update()
        raise AssertionError("it was not refused")
    except RuntimeError as error:
        assert words in str(error), error
    assert words in scene.sorairo.trouble

sorairo.unregister()
print("the add-on is well")
