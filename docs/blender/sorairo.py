"""The clear sky of sorairo as the world of a scene, and its sun as a lamp: a panel in the properties of the world.

SPDX-License-Identifier: MIT OR Apache-2.0
"""

import json
import re
import subprocess
from math import pi, radians
from pathlib import Path

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty, StringProperty

bl_info = {
    "name": "sorairo",
    "description": "The clear sky in full spectrum, with its sun",
    "blender": (4, 2, 0),
    "version": (0, 1, 0),
    "location": "Properties > World > sorairo",
    "category": "Lighting",
}

#: Names of the world and of the lamp that the add-on owns.
WORLD, SUN = "sorairo", "sorairo sun"
#: A hand that moves a slider waits so long for the sky (s).
PAUSE = 0.4


class Refused(Exception):
    """Why there is no sky, in a sentence."""


def changed(settings, _context):
    settings.trouble = ""
    if not settings.automatic:
        return
    if bpy.app.timers.is_registered(later):
        bpy.app.timers.unregister(later)
    bpy.app.timers.register(later, first_interval=PAUSE)


def later():
    """The update that follows a change by itself."""
    scene = bpy.context.scene
    try:
        update(scene)
    except Refused as refused:
        scene.sorairo.trouble = str(refused)


class Settings(bpy.types.PropertyGroup):
    """What is asked of sorairo for a scene."""

    program: StringProperty(name="Program", description="The command sorairo", default="sorairo", subtype="FILE_PATH")
    file: StringProperty(
        name="Scene file", description="Scene of sorairo (TOML); empty: the standard air", subtype="FILE_PATH",
        update=changed,
    )
    by: EnumProperty(
        name="Sun",
        items=[
            ("ANGLES", "Angles", "By elevation and azimuth"),
            ("PLACE", "Place and time", "By a place and a time"),
            ("FILE", "Scene file", "As the scene file says"),
        ],
        update=changed,
    )
    elevation: FloatProperty(
        name="Elevation", description="Of the sun above the horizon (degrees)", default=30, min=-90, max=90,
        update=changed,
    )
    azimuth: FloatProperty(
        name="Azimuth", description="Of the sun, clockwise from north (degrees)", default=120, min=-360, max=360,
        update=changed,
    )
    latitude: FloatProperty(
        name="Latitude", description="Degrees north", default=35.68, min=-90, max=90, update=changed,
    )
    longitude: FloatProperty(
        name="Longitude", description="Degrees east", default=139.77, min=-180, max=180, update=changed,
    )
    time: StringProperty(
        name="Time", description="With its offset from UTC", default="2026-06-21T17:30:00+09:00", update=changed,
    )
    visibility: FloatProperty(
        name="Visibility", description="How far one sees (km), which says the haze; 0: as the scene file says",
        default=0, min=0, max=300, update=changed,
    )
    north: FloatProperty(
        name="North", description="Where north lies, counter-clockwise from +X (degrees): 90 is +Y", default=90,
        min=-360, max=360, update=changed,
    )
    width: IntProperty(
        name="Width", description="Of the map (pixels); it is half as high", default=2048, min=64, max=16384,
        update=changed,
    )
    exposure: EnumProperty(
        name="Exposure",
        items=[
            ("auto", "Metered", "As a camera meters the sky"),
            ("adapt", "Adapted", "As an eye adapts: dusk falls"),
            ("none", "My own", "As the scene has it"),
        ],
        update=changed,
    )
    folder: StringProperty(name="Folder", description="Where the maps go; empty: a temporary one", subtype="DIR_PATH")
    automatic: BoolProperty(
        name="Update by itself", description="Make the sky anew after each change", default=False, update=changed,
    )
    trouble: StringProperty()


def flags(settings, maps):
    """The command that renders the maps of a scene."""
    program = settings.program if "/" not in settings.program else bpy.path.abspath(settings.program)
    command = [program, "render", "--json", "--split-sun", "--force"]
    command += [f"--output={path}" for path in maps]
    command += [f"--size={settings.width}x{settings.width // 2}", "--projection=equirectangular", "--look-azimuth=0", "--look-elevation=0"]
    command += ["--rgb=srgb", "--exr=f32", "--exr-exposure=0"]
    if settings.exposure != "none":
        command.append(f"--exposure={settings.exposure}")
    if settings.file:
        command.append(f"--scene={bpy.path.abspath(settings.file)}")
    if settings.by == "ANGLES":
        command += [f"--sun-elevation={settings.elevation:.6g}", f"--sun-azimuth={settings.azimuth:.6g}"]
    elif settings.by == "PLACE":
        command += [f"--place={settings.latitude:.6g},{settings.longitude:.6g}", f"--time={settings.time}"]
    if settings.visibility > 0:
        command.append(f"--visibility={settings.visibility:.6g}")
    return command


def render(settings):
    """Renders the maps: that without the sun's disc, that with it, what sorairo says of them, and the disc's angle
    (degrees)."""
    folder = Path(bpy.path.abspath(settings.folder) if settings.folder else bpy.app.tempdir)
    light, usd = folder / "sorairo.exr", folder / "sorairo.usda"
    try:
        done = subprocess.run(flags(settings, [light, usd]), capture_output=True, text=True)
    except OSError as error:
        raise Refused(f"{settings.program} does not start: {error.strerror}") from error
    if done.returncode != 0:
        told = [line for line in done.stderr.splitlines() if line.startswith("error")]
        raise Refused(told[0].removeprefix("error: ") if told else f"{settings.program} ended with {done.returncode}")
    angle = re.search(r"float inputs:angle = ([\d.]+)", usd.read_text())
    return light, folder / "sorairo.sun.exr", json.loads(done.stdout), float(angle[1]) if angle else 0


def image(path):
    made = bpy.data.images.load(str(path), check_existing=True)
    made.reload()
    made.colorspace_settings.name = "Linear Rec.709"
    return made


def world(north, light, seen):
    """A world that lights by one map and shows the other. A map unturned has north at +X."""
    made = bpy.data.worlds.get(WORLD) or bpy.data.worlds.new(WORLD)
    made.use_nodes = True
    nodes, links = made.node_tree.nodes, made.node_tree.links
    nodes.clear()

    def node(kind, x, y=0):
        added = nodes.new(f"ShaderNode{kind}")
        added.location = x, y
        return added

    places, turn = node("TexCoord", -900), node("Mapping", -700)
    turn.inputs["Rotation"].default_value[2] = -radians(north)
    links.new(places.outputs["Generated"], turn.inputs["Vector"])
    mix, path, output = node("MixShader", 200), node("LightPath", 0, 350), node("OutputWorld", 400)
    links.new(path.outputs["Is Camera Ray"], mix.inputs["Fac"])
    for i, picture in enumerate([light, seen]):
        texture, background = node("TexEnvironment", -400, -300 * i), node("Background", 0, -150 * i)
        texture.image = picture
        links.new(turn.outputs["Vector"], texture.inputs["Vector"])
        links.new(texture.outputs["Color"], background.inputs["Color"])
        links.new(background.outputs["Background"], mix.inputs[1 + i])
    links.new(mix.outputs["Shader"], output.inputs["Surface"])
    return made


def sun(scene, north, report, angle):
    """The lamp: a surface that faces it gets what sorairo says."""
    lamp = bpy.data.lights.get(SUN) or bpy.data.lights.new(SUN, "SUN")
    rgb = report["sun_irradiance_rgb"]
    lamp.energy = max(rgb)
    lamp.color = [value / (lamp.energy or 1) for value in rgb]
    lamp.angle = radians(angle)
    made = bpy.data.objects.get(SUN) or bpy.data.objects.new(SUN, lamp)
    made.rotation_euler = pi / 2 - radians(report["sun_elevation"]), 0, pi / 2 + radians(north - report["sun_azimuth"])
    if made.name not in scene.collection.all_objects:
        scene.collection.objects.link(made)


def update(scene):
    """Renders the sky that a scene asks for and lights the scene by it; what sorairo says of it."""
    settings = scene.sorairo
    light, seen, report, angle = render(settings)
    scene.world = world(settings.north, image(light), image(seen))
    sun(scene, settings.north, report, angle)
    if settings.exposure != "none":
        scene.view_settings.view_transform, scene.view_settings.exposure = "AgX", report["exposure_ev"]
    settings.trouble = ""
    return report


class SORAIRO_OT_update(bpy.types.Operator):
    """Render the sky and its sun, and light the scene by them"""

    bl_idname, bl_label, bl_options = "sorairo.update", "Update the sky", {"REGISTER", "UNDO"}

    def execute(self, context):
        try:
            report = update(context.scene)
        except Refused as refused:
            context.scene.sorairo.trouble = str(refused)
            self.report({"ERROR"}, str(refused))
            return {"CANCELLED"}
        self.report({"INFO"}, f"The sun stands {report['sun_elevation']:.1f}° high; the sky gives {report['illuminance_lux']:.0f} lx")
        return {"FINISHED"}


class SORAIRO_PT_world(bpy.types.Panel):
    bl_label, bl_space_type, bl_region_type, bl_context = "sorairo", "PROPERTIES", "WINDOW", "world"

    def draw(self, context):
        settings, layout = context.scene.sorairo, self.layout
        layout.use_property_split = True
        of_sun = {"ANGLES": ["elevation", "azimuth"], "PLACE": ["latitude", "longitude", "time"], "FILE": []}
        for name in ["file", "by", *of_sun[settings.by], "visibility", "north", "exposure", "width", "folder", "program"]:
            layout.prop(settings, name)
        layout.prop(settings, "automatic")
        layout.operator("sorairo.update")
        if settings.trouble:
            layout.label(text=settings.trouble, icon="ERROR")


CLASSES = [Settings, SORAIRO_OT_update, SORAIRO_PT_world]


def register():
    for each in CLASSES:
        bpy.utils.register_class(each)
    bpy.types.Scene.sorairo = PointerProperty(type=Settings)


def unregister():
    if bpy.app.timers.is_registered(later):
        bpy.app.timers.unregister(later)
    del bpy.types.Scene.sorairo
    for each in reversed(CLASSES):
        bpy.utils.unregister_class(each)
