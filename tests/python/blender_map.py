"""Takes a sky as the world of Blender's Cycles, as docs/environment-maps.md says: a white plane under it, and a picture of all of it.

Usage: blender_map.py, in a folder with sky.exr, equirectangular; sky.png; and sky.json, what `sorairo render --json` said of both.
"""

import json
import os
from math import pi, radians, sin
from pathlib import Path

import bpy
import numpy as np

report = json.load(open("sky.json"))
page = (Path(__file__).parent / "../../docs/environment-maps.md").read_text()
lines = page.split("## Blender")[1].split("```python\n")[1].split("```")[0]


def lit():
    """A scene with nothing in it but the world and the sun of the page."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    exec(lines, {})
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    # As many samples everywhere, each time the same, and no filter that invents.
    scene.cycles.device, scene.cycles.seed = "CPU", 1
    scene.cycles.use_adaptive_sampling = scene.cycles.use_denoising = False
    return scene


def camera(scene, position, rotation, **settings):
    data = bpy.data.cameras.new("camera")
    for name, value in settings.items():
        setattr(data, name, value)
    scene.camera = bpy.data.objects.new("camera", data)
    scene.camera.location, scene.camera.rotation_euler = position, rotation
    scene.collection.objects.link(scene.camera)


def rendered(scene, name, width, height, samples, file_format, depth):
    """The values of a picture, from its lower left."""
    scene.render.resolution_x, scene.render.resolution_y = width, height
    scene.cycles.samples = samples
    settings = scene.render.image_settings
    settings.file_format, settings.color_depth = file_format, depth
    scene.render.filepath = os.path.abspath(name)
    bpy.ops.render.render(write_still=True)
    return values(scene.render.filepath)


def values(path):
    loaded = bpy.data.images.load(path)
    loaded.colorspace_settings.name = "Non-Color"
    width, height = loaded.size
    return np.array(loaded.pixels[:]).reshape(height, width, 4)[..., :3]


def irradiance():
    """Irradiance of a level white plane: π times the radiance that it reflects."""
    scene = lit()
    mesh = bpy.data.meshes.new("plane")
    mesh.from_pydata([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], [], [(0, 1, 2, 3)])
    white = bpy.data.materials.new("white")
    white.use_nodes = True
    nodes = white.node_tree.nodes
    nodes.clear()
    diffuse, surface = nodes.new("ShaderNodeBsdfDiffuse"), nodes.new("ShaderNodeOutputMaterial")
    diffuse.inputs["Color"].default_value = (1, 1, 1, 1)
    white.node_tree.links.new(diffuse.outputs["BSDF"], surface.inputs["Surface"])
    mesh.materials.append(white)
    scene.collection.objects.link(bpy.data.objects.new("plane", mesh))
    camera(scene, (0, 0, 1), (0, 0, 0), type="ORTHO", ortho_scale=1)
    return pi * rendered(scene, "plane.exr", 8, 8, 2048, "OPEN_EXR", "32").mean(axis=(0, 1))


measured = irradiance()
said = np.array(report["irradiance_rgb"]) + sin(radians(report["sun_elevation"])) * np.array(report["sun_irradiance_rgb"])
error = np.abs(measured / said - 1).max()
print(f"irradiance {measured} W/m2, sorairo says {said}: {error:.1e}")
# Chance leaves 3e-5 of 64 pixels with 2048 samples, and what lies between the map's pixels is Blender's to say.
assert error < 1e-3, error

# The whole sky by a camera that looks north, x, with z up: what it sees is the map itself, and with its exposure the PNG.
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
