"""Lights a horizontal sensor in Radiance with the sky and the sun that sorairo wrote, and looks at the sky in some
directions.

Usage: radiance_sky.py SCENE REPORT PROBES: the .rad file, the JSON of `sorairo render`, and JSON of directions, each
with its elevation and azimuth (degrees) and its radiance at the report's wavelengths.
"""

import json
import math
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pyradiance

WATTS_OF_A_NANOMETRE = 400.0  # what Radiance counts a radiance per nanometre as
home = Path(pyradiance.__file__).parent
environment = os.environ | {"RAYPATH": f".:{home / 'lib'}"}


def radiance(program, *arguments, text=""):
    """Runs a program of Radiance."""
    run = subprocess.run([home / "bin" / program, *arguments], input=text, capture_output=True, env=environment, encoding="latin-1")
    # After sunset the sky alone gives light.
    told = run.stderr.replace("rtrace: warning - no light sources found\n", "")
    assert run.returncode == 0 and not told, (program, told)
    return run.stdout


scene, report, probes = sys.argv[1], json.load(open(sys.argv[2])), json.load(open(sys.argv[3]))
expected = report["spectral_irradiance"]
wavelengths = np.array(expected["wavelength_nm"])
step = wavelengths[1] - wavelengths[0]
limits = ["-cs", str(len(wavelengths)), "-cw", str(wavelengths[0] - step / 2), str(wavelengths[-1] + step / 2), "-co+"]
with open("scene.oct", "wb") as octree:
    subprocess.run([home / "bin" / "oconv", scene], stdout=octree, check=True, env=environment)


def trace(rays, *arguments):
    """Values per nanometre, by increasing wavelength, of rays: each a place and a direction."""
    lines = "\n".join(" ".join(map(str, ray)) for ray in rays)
    found = radiance("rtrace", "-h", *limits, *arguments, "scene.oct", text=lines)
    return np.array([line.split() for line in found.splitlines()], float)[:, ::-1] / WATTS_OF_A_NANOMETRE


# One bounce takes the sky; enough samples of it that chance leaves less than a tenth of what is allowed.
sampling = ["-I", "-ab", "1", "-ad", "65536", "-lw", "1e-7", "-as", "0", "-dj", "0", "-u-"]
up, down = trace([(0, 0, 0, 0, 0, 1), (0, 0, 0, 0, 0, -1)], *sampling)
total = np.array(expected["irradiance_w_m2_nm"]) + expected["direct_irradiance_w_m2_nm"]
ground = np.array(expected["ground_irradiance_w_m2_nm"])
for name, found, wanted in (("from above", up, total), ("from below", down, ground)):
    error = found / wanted - 1
    # Of bands of 50 nm the picture has the middles of three parts, between which lines of gases lie: 1.4 % at 700 nm.
    print(f"{name}: {error.min():+.2%} to {error.max():+.2%}")
    assert (wanted > 0).all() and np.abs(error).max() <= 0.016, (name, error)

assert len(probes) >= 3
for probe in probes:
    elevation, azimuth = math.radians(probe["elevation"]), math.radians(probe["azimuth"])
    direction = (math.cos(elevation) * math.sin(azimuth), math.cos(elevation) * math.cos(azimuth), math.sin(elevation))
    (found,) = trace([(0, 0, 0, *direction)])
    wanted = np.array(probe["radiance"])
    # A mantissa of 8 bits is a part in 128 to 256 of the brightest band, whatever band it is of. In the band of oxygen
    # at 760 nm the picture has the middles of parts, where the spectrum has each nanometre: up to 3.2 % of the
    # brightest, at dusk.
    error, whole = np.abs(found - wanted).max() / wanted.max(), found.sum() / wanted.sum() - 1
    print(f"at {probe['elevation']}, {probe['azimuth']}: {error:.2%} of the brightest band, {whole:+.2%} of the sum")
    assert wanted.max() > 0 and error <= 0.04 and abs(whole) <= 0.012, (probe, found)
