"""The wheel: what it needs, what it brings."""

import copy
import pickle
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
    assert "stokes" not in found
    assert isinstance(found, xarray.Dataset)
    assert found.radiance.dims == ("elevation", "azimuth", "wavelength")
    assert found.radiance.attrs["units"] == "W m-2 sr-1 nm-1"
    assert np.array_equal(found.radiance.sel(elevation=50, azimuth=90), sky.radiance(50, 90, [450, 550]))
    assert np.array_equal(found.global_irradiance, sky.irradiance([450, 550])["global"])
    assert float(found.sun_elevation) == 20


def test_a_dataset_has_stokes_vectors_where_they_are_asked_for():
    pytest.importorskip("xarray")
    sky = sorairo.Sky(sun_elevation=20, sun_azimuth=90, keys={"render.polarisation": "on"})
    found = sky.to_xarray([10, 50], [0, 90, 180], [450, 550], stokes=True)
    assert found.stokes.dims == ("elevation", "azimuth", "wavelength", "parameter")
    assert np.array_equal(found.stokes.sel(elevation=50, azimuth=180), sky.stokes(50, 180, [450, 550]))
    assert float(found.stokes.sel(elevation=50, azimuth=90, wavelength=550, parameter="U")) == 0.0


def test_a_sequence_is_a_dataset_with_times_and_what_differs():
    pytest.importorskip("xarray")
    times = ["2026-06-21T06:00:00+09:00", "2026-06-21T12:00:00+09:00", "2026-06-21T09:00:00Z"]
    depths = [0.1, 0.2, 0.3]
    found = sorairo.sequence(
        place=(43.06, 141.35),
        time=times,
        wavelengths=[450, 550],
        elevation=[[10], [50]],
        azimuth=[0, 90, 180],
        surface_tilt=[0, 30, 60],
        keys={"atmosphere.aerosol.optical_depth": depths},
    )
    dataset = found.to_xarray()
    assert dataset.radiance.dims == ("time", "elevation", "azimuth", "wavelength")
    utc = np.array(["2026-06-20T21:00", "2026-06-21T03:00", "2026-06-21T09:00"], dtype="datetime64[s]")
    assert np.array_equal(dataset.time.values.astype("datetime64[s]"), utc)
    assert list(dataset["atmosphere.aerosol.optical_depth"].values) == depths
    noon = sorairo.Sky(place=(43.06, 141.35), time=times[1], keys={"atmosphere.aerosol.optical_depth": 0.2})
    at_noon = dataset.sel(time=utc[1].astype("datetime64[ns]"))
    assert np.array_equal(at_noon.radiance.sel(elevation=50, azimuth=90), noon.radiance(50, 90, [450, 550]))
    assert np.array_equal(at_noon.global_irradiance, noon.irradiance([450, 550], 30)["global"])
    assert (float(at_noon.sun_elevation), float(at_noon.surface_tilt)) == (noon.sun_elevation, 30)
    assert dataset.global_irradiance.attrs["units"] == "W m-2 nm-1" and "optical_depth = 0.1" in dataset.attrs["scene_of_first_sun"]
    patches = sorairo.sequence(sun_elevation=[10, 20], wavelengths=550, elevation=[6, 18, 90], azimuth=[0, 12, 0]).to_xarray()
    assert patches.radiance.dims == ("sun", "direction") and list(patches.elevation) == [6, 18, 90]
    assert patches.sun_elevation.dims == ("sun",) and patches.wavelength == 550


def test_a_sky_is_pickled_and_copied(tmp_path):
    (tmp_path / "ground.csv").write_text("nm,albedo\n300,0.1\n900,0.6\n")
    sky = sorairo.Sky("hazy", sun_elevation=7.1, albedo=tmp_path / "ground.csv", keys={"render.bands": [420, 480, 540, 600, 660]})
    expected = sky.radiance(20, [0, 90], [400, 550, 700])
    kept = pickle.dumps(sky)
    for again in (pickle.loads(kept), copy.deepcopy(sky), copy.copy(sky)):
        assert again.scene == sky.scene
        assert np.array_equal(again.radiance(20, [0, 90], [400, 550, 700]), expected)
    (tmp_path / "ground.csv").write_text("nm,albedo\n300,0.2\n900,0.6\n")
    with pytest.raises(ValueError, match="ground.csv has changed"):
        pickle.loads(kept)
    assert np.array_equal(copy.deepcopy(sky).radiance(20, [0, 90], [400, 550, 700]), expected)


def test_a_pickled_sky_is_the_same_in_another_process(python):
    sky = sorairo.Sky(place=(43.06, 141.35), time="2026-06-21T08:30:00+09:00")
    program = f"import pickle; print(float(pickle.loads({pickle.dumps(sky)!r}).luminance(45, 0)).hex())"
    assert python(program).stdout.strip() == float(sky.luminance(45, 0)).hex()
