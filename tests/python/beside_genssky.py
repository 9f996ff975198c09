"""Spectral irradiance of level ground by sorairo beside Radiance's genssky, at three heights of the sun, as
docs/radiance.md has it.

Usage: beside_genssky.py SORAIRO PAGE: the program, and the page whose table it is held against. genssky makes its
tables in this folder.
"""

import json
import math
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pyradiance

home = Path(pyradiance.__file__).parent
environment = os.environ | {"RAYPATH": f".:{home / 'lib'}", "PATH": f"{home / 'bin'}{os.pathsep}{os.environ['PATH']}"}
WATTS_OF_A_NANOMETRE = 400.0  # what Radiance counts a radiance per nanometre as
WAVELENGTHS = np.arange(390, 771, 20)  # nm
BANDS = ["-cs", "20", "-cw", "380", "780", "-co+"]
GLOW = "skyfunc glow sky_glow\n0\n0\n4 1 1 1 0\nsky_glow source sky\n0\n0\n4 0 0 1 180\n"


def run(*command, text=None):
    done = subprocess.run(command, input=text, capture_output=True, env=environment, encoding="latin-1")
    assert done.returncode == 0, (command, done.stderr)
    return done.stdout


def theirs(hour):
    """The sun's elevation (degrees), direct and diffuse irradiance (W/m2/nm) by increasing wavelength, at Greenwich on
    21 June."""
    name = f"sky{hour}"
    # An optical depth at 550 nm, of the aerosol of a continent on average, and a grey ground.
    place = ["6", "21", hour, "-y", "2026", "-a", "51.48", "-o", "0", "-m", "0"]
    text = run("genssky", *place, "-d", "0.115", "-g", "0.2", "-n", str(os.cpu_count()), "-f", name)
    numbers = lambda pattern: np.array(re.search(pattern, text).group(1).split(), float)
    spectrum = numbers(r"void spectrum sunrad\s+0\s+0\s+22 390 770 (.*)")
    strength = numbers(r"sunrad light solar\s+0\s+0\s+3 (.*)")[0]
    x, y, z, across = numbers(r"solar source sun\s+0\s+0\s+4 (.*)")
    direct = spectrum * strength * math.pi * math.radians(across / 2) ** 2 * z / WATTS_OF_A_NANOMETRE
    # The sky alone.
    sky = text[text.index("void specpict") :] + GLOW
    Path("sky.rad").write_text(sky)
    with open("sky.oct", "wb") as octree:
        subprocess.run(["oconv", "sky.rad"], stdout=octree, check=True, env=environment)
    sampling = ["-I", "-ab", "1", "-ad", "65536", "-lw", "1e-7", "-as", "0"]
    found = run("rtrace", "-h", *BANDS, *sampling, "sky.oct", text="0 0 0 0 0 1\n").split()
    return math.degrees(math.asin(z)), direct, np.array(found, float)[::-1] / WATTS_OF_A_NANOMETRE


def ours(sorairo, elevation):
    sun = ["--sun-elevation", str(elevation), "--aerosol", "0.115@550", "--albedo", "0.2"]
    report = json.loads(run(sorairo, "render", "--device", "cpu", "--size", "16x8", *sun, "-o", "ours.hsr", "--json"))
    light = report["spectral_irradiance"]
    return np.array(light["direct_irradiance_w_m2_nm"]), np.array(light["irradiance_w_m2_nm"])


sorairo, page = sys.argv[1:]
said = Path(page).read_text()
for hour in ("12", "16", "18.3"):
    elevation, direct, diffuse = theirs(hour)
    our_direct, our_diffuse = ours(sorairo, elevation)
    # The tables of the sun differ in the blue, point by point; the sky's light over the sun's has none of it.
    ratios = {"direct": (our_direct / direct)[WAVELENGTHS >= 500], "sky": our_diffuse / our_direct / (diffuse / direct)}
    print(f"sun at {elevation:.1f}°: sky over sun at {WAVELENGTHS} nm: {np.round(ratios['sky'], 2)}")
    assert all((ratio > 0).all() for ratio in ratios.values())
    found = [end for ratio in ratios.values() for end in (ratio.min(), ratio.max())]
    row = next(line for line in said.splitlines() if line.startswith(f"| {elevation:.0f}° | "))
    told = [float(number) for number in re.findall(r"\d\.\d\d", row)]
    print(row, np.round(found, 3))
    # Half of the last digit, and what chance leaves of the rays of rtrace.
    assert len(told) == 4 and np.abs(np.subtract(told, found)).max() < 0.015, (told, found)
