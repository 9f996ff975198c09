"""Python goes on while sorairo computes, and may interrupt it."""

import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import sorairo

# A minute of work, of which the test waits for half a second.
LONG = "sky.radiance(np.linspace(0, 90, 100_000), 120, np.linspace(380, 780, 81), method='dense')"


def test_python_runs_while_a_sky_is_computed():
    sky = sorairo.Sky(sun_elevation=10)
    wavelengths = np.linspace(380, 780, 81)
    # Hundreds of sleeps long, so that a quicker machine leaves room for the ticks.
    computing = threading.Thread(target=lambda: sky.radiance(np.linspace(0, 90, 2000), 120, wavelengths, method="dense"))
    ticks = 0
    computing.start()
    while computing.is_alive():
        time.sleep(0.002)
        ticks += 1
    # With the lock held there would be one, after the work.
    assert ticks > 10


def test_threads_share_a_sky():
    sky = sorairo.Sky(sun_elevation=10)
    expected = sky.radiance(30, np.arange(0, 360, 10), [450, 650])
    found = [None] * 4

    def compute(i):
        found[i] = sky.radiance(30, np.arange(0, 360, 10), [450, 650])

    threads = [threading.Thread(target=compute, args=(i,)) for i in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all(np.array_equal(one, expected) for one in found)


def test_ctrl_c_interrupts():
    # What is started in the background may have been told to ignore it, and Python then does.
    listens = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)"
    program = f"{listens}\nimport numpy as np, sorairo\nsky = sorairo.Sky(sun_elevation=10)\nprint('computing', flush=True)\n{LONG}\nprint('done')"
    process = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stdout.readline() == "computing\n"
    time.sleep(0.5)
    process.send_signal(signal.SIGINT)
    start = time.monotonic()
    out, err = process.communicate(timeout=60)
    seconds = time.monotonic() - start
    print(f"interrupted after {seconds:.2f} s")
    assert "KeyboardInterrupt" in err and "done" not in out


def test_ctrl_c_is_heard_at_once_whatever_is_computed():
    # Some seconds of work each, in one piece: the light at thousands of wavelengths, and thousands of suns.
    for long in (
        "sky.radiance(45, 0, np.linspace(380, 780, 10_000), method='dense')",
        "sorairo.sequence(sun_elevation=np.linspace(-18, 90, 9000), wavelengths=np.linspace(380, 780, 401), surface_tilt=90)",
    ):
        program = f"""
import os, signal, threading, time
import numpy as np, sorairo
signal.signal(signal.SIGINT, signal.default_int_handler)
sky = sorairo.Sky(sun_elevation=-4)
def interrupt():
    global sent
    sent = time.monotonic()
    os.kill(os.getpid(), signal.SIGINT)
threading.Timer(0.5, interrupt).start()
try:
    {long}
except KeyboardInterrupt:
    print(time.monotonic() - sent)
"""
        done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60)
        assert done.returncode == 0, done.stderr
        # Python is asked every 50 ms; the rest is for a machine with other work.
        assert float(done.stdout) < 1, done.stdout


def test_a_forked_process_is_refused_and_does_not_hang(python):
    program = """
import os, sorairo
sorairo.Sky()
child = os.fork()
if child == 0:
    try:
        sorairo.Sky()
    except RuntimeError as refusal:
        print(refusal, flush=True)
    os._exit(0)
os.waitpid(child, 0)
"""
    done = python(program)
    assert "before this process was forked" in done.stdout, done.stderr


def is_begun(folder):
    """Whether a file is being written; one by which the folder is tried stays empty, and may go while it is looked
    at."""
    try:
        return any(file.stat().st_size for file in folder.iterdir())
    except FileNotFoundError:
        return False


def test_ctrl_c_interrupts_the_command(tmp_path):
    # Hundreds of times the work that is done once the first rows are there.
    arguments = ["render", "--size=16000x8000", "--path=direct", "--device=cpu", "-osky.exr"]
    process = subprocess.Popen(
        [Path(sys.executable).with_name("sorairo"), *arguments], cwd=tmp_path, stderr=subprocess.PIPE, text=True
    )
    while process.poll() is None and not is_begun(tmp_path):
        time.sleep(0.002)
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=60)
    assert process.returncode == 130 and "interrupted" in said
    assert not list(tmp_path.iterdir())
