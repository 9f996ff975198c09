"""Times sorairo on the CPU beside Mitsuba 3's `sunsky`, whose sky is a fit to precomputed images, over the same
directions in one run.

Usage: beside_sunsky.py --turns target/release/examples/turns --out docs/figures/sunsky.json [--rounds N] [--size WxH]

Either computes the upper half of an equirectangular image of linear RGB, on all cores, in turn, in a process that has
done so before. Of sorairo it is the time of the kernels, as the library's example `turns` tells it. Of Mitsuba, in the
variant `llvm_ad_rgb`, it is the emitter's evaluation, compiled and warm, in directions that lie in memory already; the
sun's disc is left out.
"""

import argparse
import json
import os
import statistics
import subprocess
import time
from datetime import date
from pathlib import Path

import mitsuba as mi
import numpy as np

SUN_ELEVATION = 30.0  # degrees
TURBIDITY = 3.0


def directions(width, height):
    """Those of the upper half of the pixels, row by row; z is up, y is north."""
    column, row = np.meshgrid(np.arange(width), np.arange(height // 2))
    azimuth = (column.ravel() + 0.5 - 0.5 * width) * (2.0 * np.pi / width)
    elevation = (0.5 * height - row.ravel() - 0.5) * (np.pi / height)
    level = np.cos(elevation)
    return np.stack([level * np.sin(azimuth), level * np.cos(azimuth), np.sin(elevation)])


class Sunsky:
    """Mitsuba's emitter with its directions."""

    def __init__(self, views):
        import drjit

        sun = np.radians(SUN_ELEVATION)
        self.drjit = drjit
        self.emitter = mi.load_dict(
            {
                "type": "sunsky",
                "sun_direction": [0.0, float(np.cos(sun)), float(np.sin(sun))],
                "turbidity": TURBIDITY,
                "albedo": 0.0,
                "sun_scale": 0.0,
            }
        )
        self.views = drjit.zeros(mi.SurfaceInteraction3f, views.shape[1])
        self.views.wi = -mi.Vector3f(views.astype(np.float32))
        drjit.eval(self.views)
        self.seconds()

    def seconds(self):
        """Evaluates all directions once, and says how long it took."""
        self.drjit.sync_thread()
        start = time.perf_counter()
        radiance = self.emitter.eval(self.views)
        self.drjit.eval(radiance)
        self.drjit.sync_thread()
        seconds = time.perf_counter() - start
        mean = np.asarray(radiance).mean()
        assert np.isfinite(mean) and mean > 0.0, "sunsky is dark"
        return seconds


class Turns:
    """sorairo, waiting for its turn."""

    def __init__(self, program, size):
        self.process = subprocess.Popen([program, size], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def seconds(self, path):
        """Computes the image by a path once more, and says how long its kernels took."""
        self.process.stdin.write(f"{path}\n")
        self.process.stdin.flush()
        return float(self.process.stdout.readline()) / 1000

    def end(self):
        """Ends the program, which must not have failed."""
        self.process.stdin.close()
        assert self.process.wait() == 0


def spread(seconds):
    """Median and range in milliseconds."""
    return {"median": statistics.median(seconds) * 1e3, "min": min(seconds) * 1e3, "max": max(seconds) * 1e3}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--turns", type=Path, required=True)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--size", default="1920x960")
    arguments = parser.parse_args()
    width, height = map(int, arguments.size.split("x"))
    mi.set_variant("llvm_ad_rgb")
    views = directions(width, height)
    sunsky = Sunsky(views)
    turns = Turns(arguments.turns, arguments.size)
    theirs, ours = [], {"table": [], "direct": []}
    for path in ours:
        turns.seconds(path)
    for _ in range(arguments.rounds):
        theirs.append(sunsky.seconds())
        for path, times in ours.items():
            # Mitsuba's threads spin for a while before they sleep.
            time.sleep(0.1)
            times.append(turns.seconds(path))
    turns.end()
    names = {"table": "sorairo, sky lookup", "direct": "sorairo, every pixel integrated"}
    rows = [("Mitsuba 3, `sunsky`", theirs), *((names[path], times) for path, times in ours.items())]
    report = {
        "mitsuba": mi.__version__,
        "threads": os.cpu_count(),
        "date": date.today().isoformat(),
        "size": arguments.size,
        "rounds": arguments.rounds,
        "rows": [
            {
                "name": name,
                "ms": spread(times),
                "ns_per_lit_pixel": statistics.median(times) * 1e9 / views.shape[1],
                "over_sunsky": statistics.median(times) / statistics.median(theirs),
            }
            for name, times in rows
        ],
    }
    arguments.out.write_text(json.dumps(report, indent=2) + "\n")
    for row in report["rows"]:
        print(f"{row['name']}: {row['ms']['median']:.1f} ms, {row['ns_per_lit_pixel']:.1f} ns a lit pixel, {row['over_sunsky']:.2f}")


if __name__ == "__main__":
    main()
