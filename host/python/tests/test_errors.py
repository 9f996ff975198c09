"""Wrong requests: one sentence that names the parameter, its value and what is allowed."""

import os
from datetime import datetime, timedelta, timezone, tzinfo

import numpy as np
import pytest
import sorairo

# That of Tokyo, before its standard time.
LOCAL_MEAN_TIME = timezone(timedelta(hours=9, minutes=18, seconds=59))


class NoOffset(tzinfo):
    """A zone that does not know its offset."""

    def utcoffset(self, _):
        return None


WRONG_SKIES = [
    (dict(sun_elevation=100), "sun_elevation (sun.elevation) is 100; it must lie between -90 and 90 degrees"),
    (dict(sun_elevation=float("nan")), "sun_elevation (sun.elevation) is NaN; it must lie between -90 and 90 degrees"),
    (dict(sun_elevation="high"), 'sun_elevation (sun.elevation): invalid type: string "high", expected a number'),
    (dict(sun_azimuth=np.inf), "sun_azimuth (sun.azimuth) is inf; an azimuth is a finite number of degrees"),
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
    (dict(place=(43, 141), time=np.datetime64("2026-06-21T04:30")), "time is '2026-06-21T04:30', and numpy's times have no offset from UTC"),
    (dict(place=(43, 141), time=np.datetime64("NaT")), "no offset from UTC"),
    (dict(place=(43, 141), time=datetime(2026, 6, 21, tzinfo=NoOffset())), "has no offset from UTC; give it a tzinfo"),
    (dict(place=(43, 141), time=datetime(1, 1, 1, tzinfo=LOCAL_MEAN_TIME)), "no time of a calendar year of UTC"),
    (dict(place=(43, 141), time=20260621), "time is 20260621; a datetime with a tzinfo or a text with an offset from UTC is wanted"),
    (dict(sun_elevation=10**400), "sun_elevation (sun.elevation) is 1000"),
    (dict(sun_elevation=10**5000), "sun_elevation (sun.elevation) is a int too long to show, which is beyond every number"),
    (dict(sun_elevation=2**70), "sun_elevation (sun.elevation) is 1.1805916207174113e21; it must lie between"),
    (dict(place=(10**400, 0), time="2026-06-21T04:30Z"), "place is 1000"),
    (dict(place=b"43", time="2026-06-21T04:30Z"), "place is b'43'; latitude and longitude in degrees are wanted"),
    (dict(albedo="\ud800"), "albedo (ground.albedo) is '\\ud800', which holds half a character"),
    (dict(preset="\udfff"), "preset is '\\udfff', which holds half a character"),
    (dict(preset=5), "preset is 5; a text is wanted"),
    (dict(time="\ud800", place=(1, 2)), "time is '\\ud800', which holds half a character"),
    (dict(scene=5), "scene is 5; the name of a file is wanted"),
    (dict(scene="\ud800"), "scene is '\\ud800'; the name of a file is wanted"),
    (dict(keys=5), "keys is 5; a dict of keys and values is wanted"),
    (dict(keys={5: 3}), "keys is 5; a text is wanted"),
    (dict(keys={"\ud800": 3}), "keys is '\\ud800', which holds half a character"),
    (dict(keys={"render.fit": "\ud800"}), "render.fit is '\\ud800', which holds half a character"),
    (dict(keys={"render.orders": 10**400}), "render.orders is 1000"),
    (dict(keys={"render.bands": [[450, 550], [600, 650]]}), "render.bands has 2 axes; at most 1 are allowed"),
    (dict(keys={"render.bands": [[450, 550], 650]}), "render.bands is [[450, 550], 650]; numbers are wanted"),
    (dict(keys={"render.bands": b"abcd"}), "render.bands is b'abcd'; a number, a text"),
    (dict(keys={"render.bands": bytearray(b"abcd")}), "render.bands is bytearray(b'abcd'); a number, a text"),
    (dict(keys={"render.bands": [450, "x"]}), "render.bands is [450, 'x']; numbers are wanted"),
    (dict(keys={"render.bands": [450, 10**400]}), "render.bands is [450, 1000"),
    (dict(keys={"render.bands": {450, 550}}), "render.bands is {"),
    (dict(sun_elevation=np.ma.masked), "sun_elevation (sun.elevation) has 1 masked of 1 values"),
    (dict(keys={"render.bands": np.ma.array([450.0, 550.0, 600.0, 650.0], mask=[0, 1, 0, 0])}), "render.bands has 1 masked of 4 values"),
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
    (lambda sky: sky.radiance(10, np.inf, 550), "azimuth is inf; an azimuth is a finite number of degrees"),
    (lambda sky: sky.radiance(10, 0, [550, 270]), "wavelengths holds 270; wavelengths must lie between 280 and 2500 nm"),
    (lambda sky: sky.between(10, 0, -1, 550), "distance is -1; it must be 0 km or more"),
    (lambda sky: sky.between(-10, 0, 1, 550), "distance is 1 km, and the ground is 0.000 km away there"),
    (lambda sky: sky.between(10, 0, 1), "wavelengths are wanted, or rgb=True in their place"),
    (lambda sky: sky.between(10, 0, 1, 550, rgb=True), "wavelengths are wanted, or rgb=True in their place"),
    (lambda sky: sky.radiance(10, 0, []), "wavelengths is empty"),
    (lambda sky: sky.radiance(10, 0, [[550]]), "wavelengths has 2 axes"),
    (lambda sky: sky.radiance("up", 0, 550), "elevation is 'up'; numbers are wanted"),
    (lambda sky: sky.radiance([1, 2], [1, 2, 3], 550), "cannot be broadcast"),
    (lambda sky: sky.radiance(10, 0, 550, method="guess"), 'method is "guess"; allowed: "fit", "dense"'),
    (lambda sky: sorairo.Sky(keys={"render.polarisation": "off"}).stokes(10, 0, 550), "render.polarisation is \"off\""),
    (lambda sky: sky.stokes(10, 0, 550, frame="level"), 'frame is "level"; allowed: "vertical", "camera"'),
    (lambda sky: sky.irradiance(2501), "wavelengths holds 2501"),
    (lambda sky: sky.irradiance(550, surface_tilt=181), "surface_tilt is 181; it must lie between 0 and 180 degrees"),
    (lambda sky: sky.irradiance(550, surface_azimuth=-np.inf), "surface_azimuth is -inf; an azimuth is a finite number of degrees"),
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
    (lambda sky: sorairo.device("\ud800"), "device is '\\ud800', which holds half a character"),
    (lambda sky: sky.render((8, 4), device=5), "device is 5; a text is wanted"),
    (lambda sky: sky.render((10**5000, 4)), "size is a int too long to showx4; each side"),
    (lambda sky: sky.render((True, 4)), "size is Truex4; each side is a whole number of pixels"),
    (lambda sky: sky.render((np.int64(0), 4)), "size is 0x4; each side is a whole number of pixels"),
    (lambda sky: sky.render(b"ab"), "size is b'ab'; width and height in pixels are wanted"),
    (lambda sky: sky.radiance(10**400, 0, 550), "elevation is 1000"),
    (lambda sky: sky.radiance(b"45", 0, 550), "elevation is b'45'; numbers are wanted"),
    (lambda sky: sky.radiance(45 + 1j, 0, 550), "elevation is (45+1j); numbers are wanted"),
    (lambda sky: sky.radiance(np.datetime64("2026-06-21"), 0, 550), "elevation is"),
    (lambda sky: sky.radiance(10, 0, 550, method="\ud800"), "method is '\\ud800', which holds half a character"),
    (lambda sky: sky.radiance(np.ma.array([10.0, 20.0], mask=[0, 1]), 0, 550), "elevation has 1 masked of 2 values"),
    (lambda sky: sky.radiance(10, [0, np.ma.array([1.0], mask=True)], 550), "azimuth has 1 masked of 1 values"),
    (lambda sky: sky.radiance(10, 0, np.ma.masked_less([400.0, 500.0], 450)), "wavelengths has 1 masked of 2 values"),
    (lambda sky: sky.render((8, 4), np.ma.masked_less([400.0, 500.0], 450)), "wavelengths has 1 masked of 2 values"),
    (lambda sky: sky.irradiance(550, surface_tilt=np.ma.array([10.0], mask=True)), "surface_tilt has 1 masked of 1 values"),
    (lambda sky: sky.irradiance(550, surface_tilt=[10, 181]), "surface_tilt is 181; it must lie between 0 and 180 degrees"),
    (lambda sky: sky.alpha_opic([10, 20], [1, 2, 3]), "surface_tilt of shape (2,) and surface_azimuth of shape (3,) cannot be broadcast"),
    (lambda sky: sky.radiance(90 + 1e-6, 0, 550), "elevation is 90.000001; it must lie between -90 and 90 degrees"),
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
        (dict(sun_elevation=[1, 2], albedo=[0.1, 0.2, 0.3], surface_tilt=0), "values and albedo (ground.albedo) 3, and they cannot be broadcast"),
        (dict(sun_elevation=[1, 2], albedo=[0.1, 1.2], surface_tilt=0), "sun 1: albedo (ground.albedo) is 1.2; it must lie between 0 and 1"),
        (dict(sun_elevation=[1, 2], surface_tilt=[0, 181]), "sun 1: surface_tilt is 181; it must lie between 0 and 180 degrees"),
        (dict(sun_elevation=[1, 2], surface_tilt=[[0, 90]]), "surface_tilt has 2 axes; at most 1 are allowed"),
        (dict(sun_elevation=np.zeros((2, 2)), surface_tilt=0), "sun_elevation (sun.elevation) has 2 axes; at most 1 is allowed"),
        (dict(sun_elevation=np.ma.masked_less([1.0, 2.0], 2), surface_tilt=0), "sun_elevation (sun.elevation) has 1 masked of 2 values"),
        (dict(keys={"atmosphere.aerosol.optical_depth": [0.1, -1]}, surface_tilt=0), "sun 1: atmosphere.aerosol.optical_depth is -1"),
        (dict(place=(43, 141), time=np.array(["2026-06-21T04:30"], dtype="datetime64[ns]"), surface_tilt=0), "have no offset from UTC"),
    ]:
        with pytest.raises(ValueError) as refusal:
            sorairo.sequence(wavelengths=550, **parameters)
        assert sentence in str(refusal.value), refusal.value


TOO_LARGE = [
    "sky.render((65536, 65536), np.linspace(400, 700, 500), device='cpu')",
    # The product of these is more than a number of 64 bits, and by what is left of it small.
    "sky.render((8388608, 8388608), np.linspace(400, 700, 262144), device='cpu')",
    "sky.render((8388608, 1), np.linspace(400, 700, 20000), device='cpu')",
    "sky.radiance(np.zeros(10**6), 0, np.linspace(400, 700, 10**6))",
    "sky.radiance(np.zeros(10**6), 0, np.linspace(400, 700, 10**6), method='dense')",
    "sky.radiance(0, 0, np.linspace(400, 700, 10**7), method='dense')",
    "sky.irradiance(np.linspace(400, 700, 10**6), surface_tilt=np.linspace(0, 90, 10**6))",
    "sorairo.sequence(sun_elevation=np.linspace(1, 90, 1000), wavelengths=np.linspace(400, 700, 10**5), elevation=np.zeros(10**5), azimuth=0)",
]


def test_what_no_memory_holds_is_refused_and_the_interpreter_goes_on(python):
    # A process of their own, since what is not refused would end it.
    attempts = "".join(f"attempt(lambda: {large})\n" for large in TOO_LARGE)
    program = f"""
import numpy as np, sorairo
sky = sorairo.Sky()
def attempt(large):
    try:
        large()
    except MemoryError as refusal:
        print(refusal)
{attempts}
assert sky.render((16, 8), device="cpu").any()
"""
    done = python(program)
    assert done.returncode == 0, done.stderr
    assert len(done.stdout.splitlines()) == len(TOO_LARGE), done.stdout
    assert "an array of 8388608 x 8388608 x 262144 values does not fit into memory" in done.stdout


def test_a_process_that_may_have_little_memory_is_told_so(python):
    program = """
import numpy as np, resource, sorairo
sky = sorairo.Sky()
sky.radiance(45, 0, np.linspace(400, 700, 81))
taken = 4096 * int(open("/proc/self/statm").read().split()[0])
resource.setrlimit(resource.RLIMIT_AS, (taken + 2**30, -1))
for large in (
    lambda: sky.radiance(np.zeros(2**15), 0, np.linspace(400, 700, 2**12)),
    lambda: sky.render((2**14, 2**13), device="cpu"),
):
    try:
        large()
    except MemoryError as refusal:
        print(refusal)
print(sky.radiance(np.zeros(2**12), 0, np.linspace(400, 700, 81)).shape)
"""
    done = python(program)
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("does not fit into memory") == 2 and "(4096, 81)" in done.stdout, done.stdout


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
