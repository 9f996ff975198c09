"""Runs a command with the programs of Radiance, and with sorairo.

Usage: with_radiance.py COMMAND ... SORAIRO
"""

import os
import subprocess
import sys
from pathlib import Path

import pyradiance

home = Path(pyradiance.__file__).parent
*command, program = sys.argv[1:]
path = os.pathsep.join([str(Path(program).parent), str(home / "bin"), os.environ["PATH"]])
sys.exit(subprocess.run(command, env=os.environ | {"PATH": path, "RAYPATH": f".:{home / 'lib'}"}).returncode)
