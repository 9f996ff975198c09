"""What the tests of the wheel share. They run where the wheel is installed: `./test.sh` does that."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

WAVELENGTHS = list(range(380, 781, 5))


@pytest.fixture
def command(tmp_path):
    """Runs the wheel's own command in a folder, successfully, and returns what it prints."""

    def run(*arguments):
        program = Path(sys.executable).with_name("sorairo")
        done = subprocess.run([program, *map(str, arguments)], cwd=tmp_path, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return done.stdout

    return run


@pytest.fixture
def report(command):
    """What `sorairo render --json` says of a sky."""
    return lambda *arguments: json.loads(command("render", "--size=64x32", "--device=cpu", "-osky.exr", "--json", *arguments))


@pytest.fixture
def python():
    """Runs a program in a Python of its own."""

    def run(program, **options):
        return subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=300, **options)

    return run
