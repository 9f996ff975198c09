"""Wrong requests: one sentence that names the parameter, its value and what is allowed."""

import os
from datetime import datetime

import numpy as np
import pytest
import sorairo

WRONG_SKIES = [
    (dict(sun_elevation=100), "sun_elevation (sun.elevation) is 100; it must lie between -90 and 90 degrees"),
    (dict(sun_elevation=float("nan")), "sun_elevation (sun.elevation) is NaN; it must lie between -90 and 90 degrees"),
    (dict(sun_elevation="high"), 'sun_elevation (sun.elevation): invalid type: string "high", expected a number'),
    (dict(sun_azimuth=400), "sun_azimuth (sun.azimuth) is 400; it must lie between -360 and 360 degrees"),
    (dict(albedo=1.5), "albedo (ground.albedo) is 1.5; it must lie between 0 and 1"),
    (dict(albedo="mud"), "ground.albedo"),
    (dict(preset="venus"), 'preset is "venus"; allowed: standard, earth'),
    (dict(place=43), "place is 43; latitude and longitude in degrees are wanted"),
    (dict(sun_elevation=[1, 2]), "sun_elevation (sun.elevation): invalid type: sequence, expected a number"),
    (dict(place=(43, 141)), "place (sun.place) needs a time"),
    (dict(place=(143, 141), time="2026-06-21T04:30Z"), "place (sun.place): a place is LATITUDE,LONGITUDE in degrees"),
    (dict(place=(43, 141), time=datetime(2026, 6, 21)), "time is 2026-06-21 00:00:00, which has no offset from UTC"),
    (dict(place=(43, 141), time="2026-06-21T04:30Z", sun_elevation=3), "cannot both be given"),
    (dict(keys={"sun.elevatoin": 3}), "unknown key `elevatoin`; did you mean `elevation`?"),
    (dict(keys={"moon": 3}), "unknown key `moon`"),
    (dict(keys={"preset": "earth"}), "preset is the first parameter"),
    (dict(sun_elevation=3, keys={"sun.elevation": 3}), "sun.elevation is given as a parameter too"),
    (dict(keys={"render.bands": None}), "render.bands is None"),
    (dict(scene="none.toml"), "the scene file none.toml"),
]


@pytest.mark.parametrize(("parameters", "sentence"), WRONG_SKIES)
def test_a_wrong_sky_is_refused_in_a_sentence(parameters, sentence):
    with pytest.raises(ValueError) as refusal:
        sorairo.Sky(**parameters)
    assert sentence in str(refusal.value) and "\n" not in str(refusal.value)


@pytest.fixture(scope="module")
def sky():
    return sorairo.Sky()


WRONG_QUESTIONS = [
    (lambda sky: sky.radiance(100, 0, 550), "elevation is 100; it must lie between -90 and 90 degrees"),
    (lambda sky: sky.radiance([10, np.nan], 0, 550), "elevation is NaN"),
    (lambda sky: sky.radiance(10, 361, 550), "azimuth is 361; it must lie between -360 and 360 degrees"),
    (lambda sky: sky.radiance(10, 0, [550, 300]), "wavelengths holds 300; wavelengths must lie between 360 and 830 nm"),
    (lambda sky: sky.radiance(10, 0, []), "wavelengths is empty"),
    (lambda sky: sky.radiance(10, 0, [[550]]), "wavelengths has 2 axes"),
    (lambda sky: sky.radiance("up", 0, 550), "elevation is 'up'; numbers are wanted"),
    (lambda sky: sky.radiance([1, 2], [1, 2, 3], 550), "cannot be broadcast"),
    (lambda sky: sky.radiance(10, 0, 550, method="guess"), 'method is "guess"; allowed: "fit", "dense"'),
    (lambda sky: sky.irradiance(840), "wavelengths holds 840"),
    (lambda sky: sky.irradiance(550, surface_tilt=181), "surface_tilt is 181; it must lie between 0 and 180 degrees"),
    (lambda sky: sky.irradiance(550, surface_azimuth=-361), "surface_azimuth is -361; it must lie between -360 and 360"),
    (lambda sky: sky.sun_transmittance(200), "wavelengths holds 200"),
    (lambda sky: sky.luminance(-91, 0), "elevation is -91"),
    (lambda sky: sky.render((0, 4)), "size"),
    (lambda sky: sky.render((2**23 + 1, 4)), "size"),
    (lambda sky: sky.render((-1, 4)), "size is -1x4; each side is a whole number of pixels from 1 to 8388608"),
    (lambda sky: sky.render((8.5, 4)), "size is 8.5x4"),
    (lambda sky: sky.render(8), "size is 8; width and height in pixels are wanted"),
    (lambda sky: sky.render((8, 4), [600, 500]), "wavelengths of an image must increase"),
    (lambda sky: sky.render((8, 4), [200]), "wavelengths holds 200"),
    (lambda sky: sky.render((8, 4), device="abacus"), 'device "abacus" is not a device of this machine; allowed: auto, cpu'),
    (lambda sky: sorairo.device("abacus"), 'device "abacus" is not a device'),
]


@pytest.mark.parametrize(("question", "sentence"), WRONG_QUESTIONS)
def test_a_wrong_question_is_refused_in_a_sentence(sky, question, sentence):
    with pytest.raises(ValueError) as refusal:
        question(sky)
    assert sentence in str(refusal.value) and "\n" not in str(refusal.value)


def test_a_wrong_sequence_is_refused_with_its_sun():
    for parameters, sentence in [
        (dict(sun_elevation=[10, 95], elevation=0, azimuth=0), "sun 1: sun_elevation (sun.elevation) is 95"),
        (dict(sun_elevation=[10, 20]), "sequence computes nothing"),
        (dict(sun_elevation=10, elevation=3), "given together"),
        (dict(sun_elevation=[1, 2], sun_azimuth=[1, 2, 3], surface_tilt=0), "cannot be broadcast"),
        (dict(sun_elevation=10, elevation=95, azimuth=0), "sun 0: elevation is 95"),
    ]:
        with pytest.raises(ValueError) as refusal:
            sorairo.sequence(wavelengths=550, **parameters)
        assert sentence in str(refusal.value), refusal.value


def test_an_array_that_no_memory_holds_is_refused(sky):
    with pytest.raises(MemoryError):
        sky.render((65536, 65536), np.linspace(400, 700, 500), device="cpu")


def test_a_machine_without_vulkan_computes_on_the_cpu(python):
    program = """
import sorairo
sky = sorairo.Sky(sun_elevation=20)
assert sorairo.device("auto").startswith("CPU"), sorairo.device("auto")
assert (sky.render((16, 8)) == sky.render((16, 8), device="cpu")).all()
try:
    sky.render((16, 8), device="gpu")
except ValueError as refusal:
    print(refusal)
"""
    nowhere = {**os.environ, "VK_DRIVER_FILES": "/nowhere", "VK_ICD_FILENAMES": "/nowhere"}
    done = python(program, env=nowhere)
    assert done.returncode == 0, done.stderr
    assert 'device "gpu" is not a device of this machine' in done.stdout
