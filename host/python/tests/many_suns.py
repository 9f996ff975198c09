"""Measures many suns in one call: by the fit, 145 directions of Tregenza's patches, 81 wavelengths.

Usage: many_suns.py [SUNS]: how many suns between the horizon and the zenith, 1000 by default.
"""

import os
import sys
import time

import numpy as np
import sorairo


def tregenza():
    """Elevations and azimuths (degrees) of the 145 patches of a sky (Tregenza 1987)."""
    rows = [(6, 30), (18, 30), (30, 24), (42, 24), (54, 18), (66, 12), (78, 6), (90, 1)]
    patches = [(elevation, 360 * i / count) for elevation, count in rows for i in range(count)]
    return np.array(patches).T


suns = int(sys.argv[1]) if len(sys.argv) > 1 else 1000
elevation, azimuth = tregenza()
wavelengths = np.arange(380, 781, 5)
# The first sky of a process reads its tables.
sorairo.Sky().radiance(45, 0, wavelengths)
for orders in ("all", 1):
    start, cpu = time.perf_counter(), time.process_time()
    found = sorairo.sequence(
        sun_elevation=np.linspace(0.5, 90, suns),
        wavelengths=wavelengths,
        elevation=elevation,
        azimuth=azimuth,
        keys={"render.orders": orders},
    )
    seconds, cpu = time.perf_counter() - start, time.process_time() - cpu
    assert found.radiance.shape == (suns, 145, 81)
    print(f"orders {orders}, {suns} suns: {seconds:.2f} s, {cpu:.2f} s of processors, {1e3 * cpu / suns:.1f} ms a sun; {os.cpu_count()} cores")
sky = sorairo.Sky(sun_elevation=40)
for name, ask in [
    ("a sky", lambda: sorairo.Sky(sun_elevation=40)),
    ("its spectra", lambda: sky.radiance(elevation, azimuth, wavelengths)),
    ("its spectra in one direction", lambda: sky.radiance(45, 0, wavelengths)),
]:
    cpu = time.process_time()
    for _ in range(10):
        ask()
    print(f"{name}: {100 * (time.process_time() - cpu):.2f} ms of processors")
