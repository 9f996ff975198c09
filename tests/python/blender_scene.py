"""What the tests in Blender share: a scene for Cycles, a camera, pictures as numbers, and a white plane."""

import os
from math import pi

import bpy
import numpy as np


def empty():
    """A scene with nothing in it, which Cycles renders each time the same."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    # As many samples everywhere, and no filter that invents.
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


def irradiance(scene):
    """Irradiance of a level white plane in a scene that lights it: π times the radiance that it reflects."""
    if "plane" not in bpy.data.objects:
        white_plane(scene)
    return pi * rendered(scene, "plane.exr", 8, 8, 2048, "OPEN_EXR", "32").mean(axis=(0, 1))


def white_plane(scene):
    """Adds a plane that reflects all light, and a camera above it."""
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
