"""Takes a sky as the world of Blender's Cycles, as docs/environment-maps.md says: a white plane under it, and a picture
of all of it.

Usage: blender_map.py, in a folder with sky.exr, equirectangular; sky.png; and sky.json, what `sorairo render --json`
said of both.
"""

import json
import os
from math import radians, sin
from pathlib import Path

import numpy as np
from blender_scene import camera, empty, irradiance, rendered, values

report = json.load(open("sky.json"))
page = (Path(__file__).parent / "../../docs/environment-maps.md").read_text()
lines = page.split("## Blender")[1].split("```python\n")[1].split("```")[0]


def lit():
    """A scene with nothing in it but the world and the sun of the page."""
    scene = empty()
    exec(lines, {})
    return scene


measured = irradiance(lit())
said = np.array(report["irradiance_rgb"]) + sin(radians(report["sun_elevation"])) * np.array(report["sun_irradiance_rgb"])
error = np.abs(measured / said - 1).max()
print(f"irradiance {measured} W/m2, sorairo says {said}: {error:.1e}")
# Chance leaves 3e-5 of 64 pixels with 2048 samples, and what lies between the map's pixels is Blender's to say.
assert error < 1e-3, error

# The whole sky by a camera that looks north, x, with z up: what it sees is the map itself, and with its exposure the
# PNG.
scene = lit()
camera(scene, (0, 0, 0), (radians(90), 0, radians(-90)), type="PANO", panorama_type="EQUIRECTANGULAR")
# One ray through the middle of each pixel, and no noise over the steps of 8 bits.
scene.render.filter_size, scene.render.dither_intensity = 0.01, 0
theirs = 255 * rendered(scene, "blender.png", report["width"], report["height"], 1, "PNG", "8")
ours = 255 * values(os.path.abspath("sky.png"))


def apart(theirs):
    return np.abs(theirs - ours).max()


difference, mirrored, moved = apart(theirs), apart(theirs[:, ::-1]), apart(np.roll(theirs, 1, axis=1))
print(f"{difference:.2f} of 255 apart; mirrored {mirrored:.0f}, turned by a pixel {moved:.0f}")
# One step of rounding, and one of Blender's table, which is straight between its colours.
assert difference <= 2 < min(mirrored, moved), (difference, mirrored, moved)
