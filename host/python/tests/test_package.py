"""The wheel: what it needs, what it brings."""

import subprocess
import sys
from importlib import metadata, resources
from pathlib import Path

import numpy as np
import pytest
import sorairo


def test_the_wheel_needs_numpy_alone(python):
    needed = [line for line in metadata.requires("sorairo") if "extra ==" not in line]
    assert [line.split(">")[0] for line in needed] == ["numpy"]
    done = python("import sys, sorairo; print(*{name.split('.')[0] for name in sys.modules} - set(sys.stdlib_module_names))")
    loaded = {name for name in done.stdout.split() if not name.startswith("_")}
    assert loaded <= {"sorairo", "numpy"}, loaded


def test_types_are_there_for_checkers_and_hold(python, tmp_path):
    files = resources.files("sorairo")
    assert (files / "py.typed").is_file()
    checks = {
        "mypy": ["--strict", "--ignore-missing-imports", "--package", "sorairo"],
        # What the extension's methods take has no names at run time but those that Rust gives.
        "mypy.stubtest": ["--ignore-positional-only", "sorairo._sorairo"],
    }
    for checker, arguments in checks.items():
        done = python(f"import sys, runpy; sys.argv[1:] = {arguments}; runpy.run_module({checker!r}, run_name='__main__')", cwd=tmp_path)
        assert done.returncode == 0, done.stdout + done.stderr


def test_every_public_thing_says_what_it_does():
    things = [sorairo, *(getattr(sorairo, name) for name in sorairo.__all__)]
    things += [thing for name, thing in vars(sorairo.Sky).items() if not name.startswith("_")]
    assert all(thing.__doc__ for thing in things)


def test_the_wheel_brings_the_command(command, tmp_path, python):
    assert metadata.version("sorairo") in command("--version")
    command("render", "--device=cpu", "--size=16x8", "-osky.png")
    assert (tmp_path / "sky.png").is_file()
    done = subprocess.run(
        [Path(sys.executable).with_name("sorairo"), "render", "--sun-elevation=100"], capture_output=True, text=True, cwd=tmp_path
    )
    assert done.returncode == 2
    assert done.stderr == "sorairo: --sun-elevation (sun.elevation) is 100; it must lie between -90 and 90 degrees\n"


def test_a_dataset_has_names_and_units():
    xarray = pytest.importorskip("xarray")
    sky = sorairo.Sky(sun_elevation=20, sun_azimuth=90)
    found = sky.to_xarray([10, 50], [0, 90, 180], [450, 550])
    assert isinstance(found, xarray.Dataset)
    assert found.radiance.dims == ("elevation", "azimuth", "wavelength")
    assert found.radiance.attrs["units"] == "W m-2 sr-1 nm-1"
    assert np.array_equal(found.radiance.sel(elevation=50, azimuth=90), sky.radiance(50, 90, [450, 550]))
    assert np.array_equal(found.global_irradiance, sky.irradiance([450, 550])["global"])
    assert float(found.sun_elevation) == 20
