"""The command `sorairo`."""

import sys

from . import _sorairo


def main() -> None:
    """Runs the command with the arguments of this process, and ends it with the command's exit code."""
    sys.exit(_sorairo.run(sys.argv))
