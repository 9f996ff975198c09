"""Reads the sky and the sun that sorairo wrote as lights of Universal Scene Description.

Usage: usd_sky.py SCENE REPORT SUN: the .usda file, the JSON of `sorairo render`, and whether the sun shines (yes or
no).
"""

import json
import sys
from pathlib import Path

import numpy as np
import OpenEXR
from pxr import Gf, Usd, UsdGeom, UsdLux

scene, report, shines = sys.argv[1], json.load(open(sys.argv[2])), sys.argv[3] == "yes"

stage = Usd.Stage.Open(scene)
assert UsdGeom.GetStageUpAxis(stage) == "Y" and UsdGeom.GetStageMetersPerUnit(stage) == 1
assert stage.GetDefaultPrim().GetPath() == "/Sky"
lights = {prim.GetName(): prim.GetTypeName() for prim in stage.Traverse() if prim.HasAPI(UsdLux.LightAPI)}
assert lights == ({"Dome": "DomeLight", "Sun": "DistantLight"} if shines else {"Dome": "DomeLight"}), lights

e, a = np.radians([report["sun_elevation"], report["sun_azimuth"]])
# North is -Z and east +X.
sun = np.array([np.cos(e) * np.sin(a), np.sin(e), -np.cos(e) * np.cos(a)])


def to_world(prim):
    return UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(Usd.TimeCode.Default())


def emitted(light):
    """What a light's colour is multiplied by, and that colour (UsdLux: intensity times 2 to the exposure times
    colour)."""
    light = UsdLux.LightAPI(light)
    return light.GetIntensityAttr().Get() * 2.0 ** light.GetExposureAttr().Get() * np.array(light.GetColorAttr().Get())


if shines:
    prim = stage.GetPrimAtPath("/Sky/Sun")
    # It shines along its -Z.
    towards = np.array(to_world(prim).TransformDir(Gf.Vec3d(0, 0, 1)))
    print(f"the sun is {np.degrees(np.arccos(np.clip(towards @ sun, -1, 1))):.1e} degrees off")
    assert np.abs(towards - sun).max() < 1e-9, (towards, sun)
    # Normalised, a distant light's intensity is the irradiance of a surface that faces it.
    assert UsdLux.LightAPI(prim).GetNormalizeAttr().Get() is True
    found, said = emitted(prim), np.array(report["sun_irradiance_rgb"])
    # Single precision.
    assert (said >= 0).all() and said.max() > 0 and np.allclose(found, said, rtol=1e-6, atol=1e-7 * said.max()), (found, said)
    angle = UsdLux.DistantLight(prim).GetAngleAttr().Get()
    # From 1.0167 to 0.9833 au.
    assert 0.523 < angle < 0.543, angle

prim = stage.GetPrimAtPath("/Sky/Dome")
dome = UsdLux.DomeLight(prim)
assert dome.GetTextureFormatAttr().Get() == "latlong"
texture = Path(dome.GetTextureFileAttr().Get().resolvedPath)
assert texture == Path(scene).with_suffix(".exr").resolve(), texture
channels = OpenEXR.File(str(texture), separate_channels=True).channels()
pixels = np.stack([channels[name].pixels for name in "RGB"], axis=-1)
radiance = pixels.astype(float) * emitted(prim)
height, width = radiance.shape[:2]
# OpenEXR: the left edge has the longitude pi, 0 is +Z, and pi/2 is +X; Y is up.
latitude = np.pi / 2 - (np.arange(height) + 0.5) / height * np.pi
longitude = np.pi - (np.arange(width) + 0.5) / width * 2 * np.pi
latitude, longitude = np.meshgrid(latitude, longitude, indexing="ij")
local = np.stack([np.cos(latitude) * np.sin(longitude), np.sin(latitude), np.cos(latitude) * np.cos(longitude)], axis=-1)
world = local @ np.array(to_world(prim).ExtractRotationMatrix())

if shines:
    brightest = world.reshape(-1, 3)[radiance[..., 1].argmax()]
    off = np.degrees(np.arccos(np.clip(brightest @ sun, -1, 1)))
    print(f"the dome is brightest {off:.2f} degrees off the sun")
    # A pixel, and a degree of the glow's own slope.
    assert off < 2, (brightest, sun)

solid_angles = (np.sin(latitude + np.pi / height / 2) - np.sin(latitude - np.pi / height / 2)) * 2 * np.pi / width
found = np.einsum("ijk,ij,ij->k", radiance, solid_angles, np.maximum(world[..., 1], 0))
said = np.array(report["irradiance_rgb"])
error = np.abs(found - said).max() / said.max()
print(f"the dome lights a level plane by {found} W/m2, sorairo says {said}: {error:.1e}")
# Half floats keep 1e-3, and pixels of 1.4 degrees stand for their centres; the disc would add as much again.
assert error < 0.01, error
