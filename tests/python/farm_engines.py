"""Measures what an engine costs: frames a second of one sequence by each way that docs/farms.md tells of, in
interleaved rounds, as its table.

Usage: farm_engines.py [--frames N] [--rounds N] [--size WxH] [--chunk N] [--program FILE], on idle cores for figures of
a page. Every way renders the same frames on the CPU, into a folder of its own, and must leave the same files.
"""

import argparse
import hashlib
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import dask

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs/farms.md").read_text()
SCRIPT = next(part for part in PAGE.split("```bash\n") if part.startswith("#!/bin/bash")).split("```")[0]
TEMPLATE = ROOT / "docs/farms/sorairo.template.yaml"
OPENJD = Path(sys.executable).with_name("openjd")

parser = argparse.ArgumentParser()
parser.add_argument("--frames", type=int, default=64)
parser.add_argument("--chunk", type=int, default=16)
parser.add_argument("--rounds", type=int, default=5)
parser.add_argument("--size", default="1024x512")
parser.add_argument("--program", type=Path, default=ROOT / "target/release/sorairo")
asked = parser.parse_args()
FIRST = 5
SUN = f"{FIRST}:{FIRST + asked.frames - 1}:1"
CHUNKS = [(first, min(first + asked.chunk, asked.frames) - 1) for first in range(0, asked.frames, asked.chunk)]
ONE_BY_ONE = [(number, number) for number in range(asked.frames)]
CORES = len(os.sched_getaffinity(0))


def run(folder, *command, **variables):
    path = f"{asked.program.parent.resolve()}{os.pathsep}{os.environ['PATH']}"
    environment = os.environ | {"PATH": path, "XDG_RUNTIME_DIR": str(folder)} | variables
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, stdin=subprocess.DEVNULL)
    assert done.returncode == 0, (command, done.stdout, done.stderr)


def task(folder, part=None, **variables):
    """A process of the command for all frames, or for a part of them."""
    frames = ["--frames", "{}-{}".format(*part)] if part else []
    line = ["sorairo", "sequence", "--scene", "evening.toml", "--sun-elevation", SUN, "--device", "cpu", "--quiet", "-o", "frames/sky.####.png"]
    run(folder, *line, *frames, **variables)


def one_process(folder):
    task(folder)


def a_process_on_each_core(folder):
    edges = [asked.frames * i // CORES for i in range(CORES + 1)]
    with ThreadPoolExecutor(CORES) as pool:
        list(pool.map(lambda part: task(folder, part, RAYON_NUM_THREADS="1"), [(a, b - 1) for a, b in zip(edges, edges[1:])]))


def in_turn(parts):
    return lambda folder: [task(folder, part) for part in parts]


def by_openjd(frames_of_a_task):
    def work(folder):
        # The device of the other ways.
        program = folder / "on-the-cpu"
        program.write_text('#!/bin/sh\nexec sorairo "$@" --device cpu\n')
        program.chmod(0o755)
        values = [f"Sun={SUN}", "Scene=evening.toml", f"Frames=0-{asked.frames - 1}", f"Output={folder / 'frames'}", f"Program={program}", f"FramesPerTask={frames_of_a_task}"]
        run(folder, str(OPENJD), "run", str(TEMPLATE), *[word for value in values for word in ("-p", value)])

    return work


def by_the_slurm_script(folder):
    """The body of the array of the page, task after task, with the variables that Slurm sets; Slurm's own time is not
    in it."""
    (folder / "evening.sbatch").write_text(SCRIPT.replace("10:-6:1", SUN).replace(" -o frames/sky.####.exr", ""))
    for number in range(asked.frames):
        variables = {"SLURM_SUBMIT_DIR": str(folder), "SLURM_CPUS_PER_TASK": str(CORES), "SLURM_ARRAY_TASK_ID": str(number)}
        run(folder, "bash", "evening.sbatch", **variables)


def by_dask(folder):
    """Tasks of so many frames as a chunk, on a worker for each core."""
    tasks = [dask.delayed(task)(folder, part, RAYON_NUM_THREADS="1") for part in CHUNKS]
    dask.compute(*tasks, scheduler="threads", num_workers=CORES)


WAYS = {
    f"one process on {CORES} cores": one_process,
    f"{CORES} processes on a core each": a_process_on_each_core,
    f"tasks of {asked.chunk} frames by Dask, a core each": by_dask,
    f"a process for each {asked.chunk} frames, one after the other": in_turn(CHUNKS),
    "the same by `openjd`": by_openjd(asked.chunk),
    "a process for each frame, one after the other": in_turn(ONE_BY_ONE),
    "the same by `openjd`, a task for each frame": by_openjd(1),
    "the same by the script for Slurm, without Slurm": by_the_slurm_script,
}


def measured(work):
    """Seconds that a way takes, and a checksum over the frames that it leaves."""
    folder = Path(tempfile.mkdtemp())
    try:
        (folder / "evening.toml").write_text(f"camera.size = '{asked.size}'\n")
        start = time.perf_counter()
        work(folder)
        seconds = time.perf_counter() - start
        files = sorted((folder / "frames").glob("sky.*.png"))
        assert len(files) == asked.frames, f"{len(files)} frames"
        return seconds, hashlib.sha256(b"".join(file.read_bytes() for file in files)).hexdigest()
    finally:
        shutil.rmtree(folder)


seconds = {name: [] for name in WAYS}
sums = set()
for _ in range(asked.rounds):
    for name, work in WAYS.items():
        taken, files = measured(work)
        seconds[name].append(taken)
        sums.add(files)
assert len(sums) == 1, "the ways leave different frames"

print(f"{asked.frames} frames of {asked.size} pixels in PNG on {CORES} cores, interleaved rounds: {asked.rounds}\n")
print("| way | frames a second: median (least to most) |\n| --- | --- |")
for name, taken in seconds.items():
    rates = sorted(asked.frames / each for each in taken)
    print(f"| {name} | {statistics.median(rates):.1f} ({rates[0]:.1f} to {rates[-1]:.1f}) |")
median = {name: statistics.median(taken) for name, taken in seconds.items()}
names = list(WAYS)
print()
for name, without in [(names[2], names[1]), (names[4], names[3]), (names[5], names[0]), (names[6], names[5]), (names[7], names[5])]:
    print(f"{name}: {(median[name] - median[without]) / asked.frames * 1000:.0f} ms a frame more than {without}")
