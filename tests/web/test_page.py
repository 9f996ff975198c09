"""What a person does on the page."""

import csv
import io
import json
import re
import subprocess

import numpy
import pytest
from playwright.sync_api import expect

from conftest import PATIENCE, PROGRAM, SIZE, Sky, context, rgb

PIXELS = f"&camera.size={SIZE[0]}x{SIZE[1]}"
PERSPECTIVE = "camera.projection=perspective&camera.fov=90&camera.look_azimuth=0&camera.look_elevation=20"


def start(sky, scene):
    """A scene that no test before has left: a link to the scene that stands there changes nothing."""
    sky.go("preset=mountain&camera.size=16x8")
    return sky.go(scene)


def measured(sky):
    """Waits for the spectrum and returns it with its direction."""
    sky.done()
    address = sky.page.evaluate("() => new URLSearchParams(location.hash.slice(1)).get('measure')")
    azimuth, elevation = map(float, address.split(","))
    return json.loads(sky.page.locator("#spectrum").get_attribute("data-values")), azimuth, elevation


def test_a_click_shows_the_spectrum_of_the_native_program(sky, native, tmp_path):
    start(sky, PERSPECTIVE + "&sun.elevation=25&sun.azimuth=90" + PIXELS)
    box = sky.frame.bounding_box()
    sky.forget()
    sky.frame.click(position={"x": 0.25 * box["width"], "y": 0.25 * box["height"]})
    page, azimuth, elevation = measured(sky)
    assert -45 < azimuth < 0 or 315 < azimuth < 360
    assert elevation > 20
    (tmp_path / "scene.toml").write_text(sky.scene)
    towards = ["--scene", "scene.toml", "--view-azimuth", azimuth, "--view-elevation", elevation]
    rows = list(csv.DictReader(io.StringIO(native("spectrum", *towards))))
    radiance = numpy.array([float(row["radiance"]) for row in rows])
    # The same code on the same numbers; elementary functions of another processor's compiler may differ in the last
    # place.
    assert numpy.allclose(page["wavelengths_nm"], [float(row["wavelength_nm"]) for row in rows])
    assert numpy.allclose(page["radiance"], radiance, rtol=1e-4)
    figures = next(csv.DictReader(io.StringIO(native("spectrum", "--luminance", *towards))))
    assert numpy.isclose(page["luminance_cd_m2"], float(figures["luminance_cd_m2"]), rtol=1e-4)
    assert numpy.allclose(page["xy"], [float(figures["x"]), float(figures["y"])], atol=1e-4)
    assert numpy.isclose(page["colour_temperature_k"], float(figures["cct_k"]), rtol=1e-3)
    # Elsewhere the sky is another.
    towards[-1] = elevation - 10
    other = [float(row["radiance"]) for row in csv.DictReader(io.StringIO(native("spectrum", *towards)))]
    assert not numpy.allclose(page["radiance"], other, rtol=1e-2)
    card = sky.page.locator("#spectrum")
    expect(card).to_be_visible()
    for word in ["XYZ", "Chromaticity", "Luminance", "Colour temperature", "Polarisation at 550 nm", f"{figures['cct_k'].split('.')[0][:2]}"]:
        expect(card).to_contain_text(word)


def raise_sun(sky, steps):
    """By so many presses of a key on the slider."""
    slider = sky.page.locator("[data-key='sun.elevation'] input[type=range]")
    sky.forget()
    slider.focus()
    for _ in range(steps):
        slider.press("ArrowRight")
    sky.done()


def test_the_sliders_change_the_sky(sky):
    start(sky, PERSPECTIVE + "&sun.elevation=10" + PIXELS)
    before = sky.pixels()
    raise_sun(sky, 10)
    assert float(sky.value("sun.elevation")) > 10
    assert not sky.still_there(before)
    expect(sky.page.locator("#sun-text")).to_contain_text(f"{float(sky.value('sun.elevation')):.2f}°")
    assert f"sun.elevation={sky.value('sun.elevation')}" in sky.page.url


@pytest.mark.parametrize("projection", ["perspective", "fisheye", "equirectangular"])
def test_the_sun_is_dragged_on_the_picture(sky, projection):
    start(sky, f"camera.projection={projection}&sun.elevation=25&sun.azimuth=10" + PIXELS)
    marker = sky.page.locator("#sun-marker").bounding_box()
    frame = sky.frame.bounding_box()
    x, y = marker["x"] + marker["width"] / 2, marker["y"] + marker["height"] / 2
    across = 0.1 * frame["height"]
    mouse = sky.page.mouse
    sky.forget()
    mouse.move(x, y)
    mouse.down()
    mouse.move(x + across / 2, y)
    mouse.move(x + across, y)
    mouse.up()
    sky.done()
    assert sky.value("sun.azimuth") != "10"
    moved = sky.page.locator("#sun-marker").bounding_box()
    # The marker follows the hand to within the pixels of this small picture.
    pixel = frame["width"] / SIZE[0]
    assert abs(moved["x"] - marker["x"] - across) <= pixel
    assert abs(moved["y"] - marker["y"]) <= pixel


def test_a_hand_looks_around_and_zooms(sky):
    start(sky, PERSPECTIVE + "&sun.elevation=10" + PIXELS)
    box = sky.frame.bounding_box()
    middle = box["x"] + box["width"] / 2, box["y"] + 0.2 * box["height"]
    sky.forget()
    sky.page.mouse.move(*middle)
    sky.page.mouse.down()
    sky.page.mouse.move(middle[0] - 60, middle[1])
    sky.page.mouse.up()
    sky.done()
    assert float(sky.value("camera.look_azimuth")) > 0
    sky.forget()
    sky.page.mouse.wheel(0, -300)
    sky.done()
    assert float(sky.value("camera.fov")) < 90


def test_a_place_and_an_hour_put_the_sun_there(sky, native):
    start(sky, PERSPECTIVE + PIXELS)
    sky.forget()
    sky.page.get_by_label("place and hour").check()
    sky.done()
    sky.forget()
    sky.page.locator("#place").select_option("Sapporo")
    sky.done()
    before = sky.pixels()
    sky.forget()
    sky.page.locator("#hour").fill("1110")
    sky.done()
    assert sky.value("sun.place") == '"43.06,141.35"'
    assert "T18:30:00+09:00" in sky.value("sun.time")
    report = json.loads(native("render", "--json", "--size=8x4", "--device=cpu", "-osky.png", "--place", sky.value("sun.place").strip('"'), "--time", sky.value("sun.time").strip('"')))
    said = sky.page.locator("#sun-text").text_content()
    assert f"{abs(report['sun_elevation']):.2f}° {'below' if report['sun_elevation'] < 0 else 'above'}" in said
    assert f"{report['sun_azimuth']:.2f}°" in said
    assert not sky.still_there(before)
    play = sky.page.locator("#play")
    hour = sky.page.locator("#hour-text").text_content()
    play.click()
    expect(sky.page.locator("#hour-text")).not_to_have_text(hour, timeout=PATIENCE)
    sky.forget()
    play.click()
    sky.done()


def test_a_link_is_a_sky(sky, browser):
    scene = PERSPECTIVE + "&preset=hazy&sun.elevation=7&sun.azimuth=-20&ground.albedo=snow&render.orders=2&measure=10,30" + PIXELS
    start(sky, scene)
    other = Sky(context(browser), sky.address)
    other.page.goto(sky.page.url)
    other.done()
    assert other.scene == sky.scene
    assert other.still_there(sky.pixels())
    assert other.page.locator("#preset").input_value() == "hazy"
    assert other.page.locator("#sun-elevation").input_value() == "7"
    expect(other.page.locator("#orders input:checked")).to_have_value("2")
    expect(other.page.locator("#spectrum-title")).to_contain_text("azimuth 10°, elevation 30°")
    assert other.troubles == []
    other.context.close()


@pytest.mark.parametrize(
    ("link", "word"),
    [
        ("sun.elevation=200", "sun.elevation"),
        ("sun.elevatoin=20", "elevatoin"),
        ("preset=venus", "venus"),
        ("camera.size=0x9", "camera.size"),
        ("sun.elevation=low", "sun.elevation"),
        ("%%%=&&", "link"),
        ("measure=here", "measure"),
        ("errors=guess", "guess"),
        ("compare=sun.elevation%3D999", "sun.elevation"),
    ],
)
def test_a_broken_link_leaves_the_last_good_sky_and_a_sentence(sky, link, word):
    start(sky, PERSPECTIVE + "&sun.elevation=12" + PIXELS)
    before, scene = sky.pixels(), sky.scene
    expect(sky.complaint).to_be_hidden()
    sky.link(link)
    expect(sky.complaint).to_be_visible()
    expect(sky.complaint).to_contain_text(word)
    assert sky.still_there(before)
    assert sky.scene == scene
    # The sky still answers.
    sky.forget()
    sky.page.locator("#sun-elevation").fill("13")
    sky.page.locator("#sun-elevation").press("Enter")
    sky.done()
    expect(sky.complaint).to_be_hidden()


def test_a_page_opened_by_a_broken_link_says_so_and_shows_a_sky(browser, server):
    sky = Sky(context(browser, width=240, height=160), server.address)
    sky.open("sun.elevation=200")
    expect(sky.complaint).to_contain_text("sun.elevation")
    assert sky.pixels().max() > 0
    assert sky.troubles == []
    sky.context.close()


def test_a_value_out_of_range_is_refused_in_a_sentence(sky):
    start(sky, PERSPECTIVE + "&sun.elevation=12" + PIXELS)
    before = sky.pixels()
    sky.page.locator("#sun-elevation").fill("95")
    sky.page.locator("#sun-elevation").press("Enter")
    expect(sky.complaint).to_contain_text("sun.elevation")
    assert sky.still_there(before)
    expect(sky.page.locator("#sun-elevation")).to_have_value("12")


def test_two_skies_stand_side_by_side(sky, native_picture):
    start(sky, PERSPECTIVE + "&sun.elevation=-4&render.exposure=2.5" + PIXELS)
    sky.forget()
    sky.page.evaluate("() => document.querySelectorAll('details').forEach((each) => { each.open = true; })")
    sky.page.locator("#keep").click()
    sky.done()
    sky.forget()
    sky.page.locator("#atmosphere-ozone-column").fill("0")
    sky.page.locator("#atmosphere-ozone-column").press("Enter")
    sky.done()
    with_ozone = re.sub(r"^atmosphere.ozone.column.*\n", "", sky.scene, flags=re.MULTILINE)
    assert numpy.abs(sky.pixels("left") - native_picture(with_ozone)).max() <= 1
    assert numpy.abs(sky.pixels("right") - native_picture(sky.scene)).max() <= 1
    expect(sky.page.locator("#differences tbody tr")).to_have_count(1)
    expect(sky.page.locator("#differences")).to_contain_text("atmosphere.ozone.column")
    divider = sky.page.locator("#divider")
    divider.press("ArrowRight")
    expect(divider).to_have_attribute("aria-valuenow", "52")
    sky.forget()
    sky.page.locator("#single").click()
    sky.done()
    expect(sky.page.locator("#left")).to_be_hidden()


def test_the_error_map_tells_a_cubic_from_the_default(sky):
    scene = PERSPECTIVE + "&sun.elevation=2&camera.size=64x32"

    def most_common(fit):
        start(sky, f"{scene}&errors={fit}")
        colours, counts = numpy.unique(sky.pixels("map").reshape(-1, 3), axis=0, return_counts=True)
        return tuple(colours[counts.argmax()])

    cubic = most_common("cubic")
    expect(sky.page.locator("#legend-scale span")).not_to_have_count(0)
    assert cubic != most_common("regression")
    start(sky, scene)
    expect(sky.page.locator("#map")).to_be_hidden()


def test_an_error_map_covers_the_right_sky_alone(sky):
    start(sky, PERSPECTIVE + "&sun.elevation=2&camera.size=64x32&errors=cubic&compare=sun.elevation%3D6")
    seen = """part => {
        const { left, top, width, height } = document.getElementById("frame").getBoundingClientRect();
        return document.elementFromPoint(left + part * width, top + 0.1 * height).id;
    }"""

    def at(part):
        """The canvas that a person sees there, in parts of the width."""
        return sky.page.evaluate(seen, part)

    divider = sky.page.locator("#divider")
    divider.press("End")
    assert (at(0.25), at(0.75)) == ("left", "left")
    divider.press("Home")
    assert (at(0.25), at(0.75)) == ("map", "map")
    for _ in range(25):
        divider.press("ArrowRight")
    assert (at(0.25), at(0.75)) == ("left", "map")
    sky.forget()
    sky.page.evaluate("() => document.getElementById('single').click()")
    sky.done()
    assert (at(0.25), at(0.75)) == ("map", "map")


# What the page's own thread may ask: these plan no sky, as the module's own tests hold them to.
PLAN_NOTHING = {"command", "direction", "filmstrip", "keys", "presets", "scene", "start", "stops_of_ev100", "sun"}


def test_a_hand_that_drags_lets_the_page_s_own_thread_plan_no_sky(browser, server):
    sky = Sky(context(browser, service_workers="block"), server.address)

    def listened(route):
        # Every function of the module, and what opens a studio.
        begins = r"^(?:export function (\w+)|    static (open))\(.*\) {$"
        body, count = re.subn(begins, r"\g<0> if (self.document) (self.asked ??= []).push('\1\2');", route.fetch().text(), flags=re.MULTILINE)
        assert count > len(PLAN_NOTHING)
        route.fulfill(body=body, content_type="text/javascript")

    sky.page.route("**/sorairo.js", listened)
    sky.open(PERSPECTIVE + "&sun.elevation=-4&compare=sun.elevation%3D5" + PIXELS)
    raise_sun(sky, 5)
    asked = sky.page.evaluate("() => self.asked")
    assert {"direction", "scene", "sun"} <= set(asked) <= PLAN_NOTHING
    sky.context.close()


def test_an_error_map_that_takes_long_keeps_no_picture_waiting(browser, server):
    sky = Sky(context(browser, service_workers="block"), server.address)
    # A map of a scene with one order of scattering never ends.
    forever = ('errors: (toml, fit) =>', 'errors: (toml, fit) => toml.includes("render.orders = 1") ? new Promise(() => {}) :')

    def slowed(route):
        body = route.fetch().text()
        assert body.count(forever[0]) == 1
        route.fulfill(body=body.replace(*forever), content_type="text/javascript")

    sky.page.route("**/worker.js", slowed)
    sky.open(PERSPECTIVE + "&sun.elevation=2&camera.size=64x32")
    before = sky.pixels()
    sky.link(PERSPECTIVE + "&sun.elevation=2&camera.size=64x32&render.orders=1&errors=cubic")
    expect(sky.page.locator("#waiting")).to_have_text("Computing every wavelength, 1 of 2", timeout=PATIENCE)
    # The picture stands there already, and the next one does not wait for the map.
    assert not sky.still_there(before)
    sky.go(PERSPECTIVE + "&sun.elevation=3&camera.size=64x32")
    assert sky.value("sun.elevation") == "3"
    # Nor is the next map that of the one that was given up.
    sky.go(PERSPECTIVE + "&sun.elevation=3&camera.size=64x32&errors=cubic")
    expect(sky.page.locator("#map")).to_have_attribute("width", "64")
    assert sky.troubles == []
    sky.context.close()


def test_the_slider_of_an_automatic_exposure_stands_at_its_number(sky, native):
    start(sky, "sun.elevation=10" + PIXELS)
    sky.page.evaluate("() => document.querySelectorAll('details').forEach((each) => { each.open = true; })")
    report = json.loads(native("render", "--json", "--size=192x96", "--device=cpu", "-osky.png", "--sun-elevation=10"))
    control = sky.page.locator("[data-key='render.exposure']")
    shown = float(control.locator("input[type=number]").get_attribute("placeholder"))
    # Four digits are shown.
    assert abs(shown - report["exposure_ev"]) < 1e-3
    automatic = sky.pixels()
    sky.forget()
    control.locator("select").select_option(label="a number")
    sky.done()
    # A slider has a thousand places, here a hundredth of a stop apart.
    assert abs(float(sky.value("render.exposure")) - shown) < 0.05
    assert numpy.abs(sky.pixels() - automatic).max() <= 10
    sky.go("sun.elevation=10&render.exposure=-6" + PIXELS)
    assert control.locator("input[type=number]").get_attribute("placeholder") == ""
    assert numpy.abs(sky.pixels() - automatic).max() > 10


def test_a_preset_says_what_it_is(sky, native):
    reference = native("scene", "reference")
    for preset in ["hazy", "mars"]:
        start(sky, f"preset={preset}" + PIXELS)
        said = sky.page.locator("#preset-chosen").text_content()
        assert f"* `{preset}`: {said}\n" in reference


def test_the_strip_shows_the_day_of_the_place_and_a_press_sets_the_hour(sky, native_picture):
    day = "&sun.place=35.68,139.77&sun.time=2026-09-22T12:00:00%2B09:00&render.exposure=adapt"
    start(sky, PERSPECTIVE + day + PIXELS)
    strip = sky.page.locator("#strip")
    expect(strip).to_have_attribute("data-state", "done", timeout=PATIENCE)
    hours = strip.locator("button")
    expect(hours).to_have_count(12)
    assert hours.all_text_contents() == sorted(hours.all_text_contents())
    noon, dusk = hours.nth(6), hours.nth(10)
    expect(dusk).to_have_attribute("aria-pressed", "false")
    sky.forget()
    dusk.click()
    sky.done()
    expect(dusk).to_have_attribute("aria-pressed", "true")
    assert f"T{dusk.text_content()}:00+09:00" in sky.value("sun.time")
    assert sky.value("sun.place") == '"35.68,139.77"'
    # Each small picture is that of its hour, which a press shows in full.
    for hour, text in [(dusk, sky.scene), (noon, sky.scene.replace(dusk.text_content(), noon.text_content()))]:
        hour.locator("canvas").evaluate("each => { each.id = 'hour'; }")
        small = sky.pixels("hour")
        hour.locator("canvas").evaluate("each => each.removeAttribute('id')")
        height, width, _ = small.shape
        text = re.sub(r'camera.size = "[^"]*"', f'camera.size = "{width}x{height}"', text)
        # The same code on two processors.
        assert numpy.abs(small - native_picture(text)).max() <= 1
    assert small.mean() > 50


def test_without_a_place_the_strip_is_a_sun_that_rises(sky):
    start(sky, PERSPECTIVE + "&sun.elevation=20&sun.azimuth=70" + PIXELS)
    expect(sky.page.locator("#strip")).to_have_attribute("data-state", "done", timeout=PATIENCE)
    sky.forget()
    sky.page.locator("#strip button").first.click()
    sky.done()
    assert (sky.value("sun.elevation"), sky.value("sun.azimuth")) == ("-9", "70")


def test_view_look_and_exposure_are_those_of_the_native_program(sky, native_picture):
    start(sky, PERSPECTIVE + "&sun.elevation=-3" + PIXELS)
    sky.page.evaluate("() => document.querySelectorAll('details').forEach((each) => { each.open = true; })")
    page, seen = sky.page, [sky.pixels()]

    def chosen(act, key, value):
        sky.forget()
        act()
        sky.done()
        assert sky.value(key) == value
        seen.append(sky.pixels())
        assert numpy.abs(seen[-1] - native_picture(sky.scene)).max() <= 1
        assert numpy.abs(seen[-1] - seen[-2]).max() > 5

    chosen(lambda: page.locator("#render-look").select_option("high-contrast"), "render.look", '"high-contrast"')
    chosen(lambda: page.locator("#render-view").select_option("aces"), "render.view", '"aces"')
    chosen(lambda: page.locator("#render-view").select_option("srgb"), "render.view", '"srgb"')
    exposure = page.locator("[data-key='render.exposure'] select")
    chosen(lambda: exposure.select_option("adapt"), "render.exposure", '"adapt"')
    ev100 = page.locator("#ev100")
    # Middle grey at 683 times its radiance, over an eighth of a candela: what a camera at EV100 0 exposes for.
    constant = numpy.log2(0.18 * 683 * 8)
    metered = float(page.locator("#render-exposure").get_attribute("placeholder"))
    assert abs(float(ev100.get_attribute("placeholder")) + metered - constant) < 0.01
    sky.forget()
    ev100.fill("13")
    ev100.press("Enter")
    sky.done()
    # Four digits are shown.
    assert abs(float(sky.value("render.exposure")) + 13 - constant) < 1e-3
    assert numpy.abs(sky.pixels() - native_picture(sky.scene)).max() <= 1


@pytest.mark.parametrize("picture", ["", "&render.view=aces&render.exposure=adapt"])
def test_what_is_saved_makes_the_same_picture(sky, native, tmp_path, picture):
    start(sky, PERSPECTIVE + "&sun.elevation=9&preset=hazy" + picture + PIXELS)
    sky.page.evaluate("() => document.querySelectorAll('details').forEach((each) => { each.open = true; })")

    def saved(button):
        with sky.page.expect_download() as download:
            sky.page.locator(button).click()
        path = tmp_path / download.value.suggested_filename
        download.value.save_as(path)
        return path

    assert numpy.abs(rgb(saved("#save-png").read_bytes()) - sky.pixels()).max() <= 1
    assert saved("#save-exr").read_bytes()[:4] == b"\x76\x2f\x31\x01"
    native("scene", "check", saved("#save-scene"))
    subprocess.run(sky.page.locator("#command").input_value(), shell=True, check=True, cwd=tmp_path, env={"PATH": f"{PROGRAM.parent}:/usr/bin:/bin"}, capture_output=True)
    made = next(path for path in tmp_path.glob("*.png") if path.name != "sorairo.png")
    assert numpy.abs(rgb(made.read_bytes()) - sky.pixels()).max() <= 1


def test_the_keyboard_alone_is_enough(sky):
    start(sky, PERSPECTIVE + "&sun.elevation=10" + PIXELS)
    sky.page.evaluate("() => document.querySelectorAll('#controls > details').forEach((each) => { each.open = false; })")
    sky.page.evaluate("() => document.activeElement.blur()")
    press = sky.page.keyboard.press
    focused = "() => document.activeElement.id || document.activeElement.textContent.trim()"

    def tab_to(name):
        for _ in range(60):
            press("Tab")
            if sky.page.evaluate(focused) == name:
                # Who has no mouse sees where they are.
                assert sky.page.evaluate("() => getComputedStyle(document.activeElement).outlineStyle") != "none"
                return
        raise AssertionError(f"no Tab leads to {name}")

    tab_to("frame")
    sky.forget()
    press("ArrowRight")
    sky.done()
    assert float(sky.value("camera.look_azimuth")) > 0
    sky.forget()
    press("+")
    sky.done()
    assert float(sky.value("camera.fov")) < 90
    sky.forget()
    press("Enter")
    _, azimuth, elevation = measured(sky)
    assert abs(azimuth - float(sky.value("camera.look_azimuth"))) < 1
    assert abs(elevation - 20) < 1
    tab_to("Air")
    press("Enter")
    tab_to("preset")
    sky.forget()
    press("m")
    sky.done()
    assert sky.value("preset") in ['"mars"', '"mountain"']
    press("Shift+Tab")
    tab_to("Scattering")
    press("Enter")
    sky.forget()
    press("Tab")
    press("ArrowLeft")
    sky.done()
    assert sky.value("render.orders") == "2"


def test_every_control_has_a_name_and_what_describes_it_is_there(sky):
    nameless = sky.page.evaluate(
        """() => [...document.querySelectorAll("input, select, textarea, button, [role], [tabindex='0']")].filter((each) => {
            const named = each.labels?.length || each.getAttribute("aria-label") || each.getAttribute("aria-labelledby") || each.closest("label");
            return !(named || each.tagName === "BUTTON" && each.textContent.trim() || ["status", "alert"].includes(each.role));
        }).map((each) => each.outerHTML)"""
    )
    assert nameless == []
    dangling = sky.page.evaluate(
        """() => [...document.querySelectorAll("[aria-describedby], [aria-controls], [aria-labelledby], label[for], output[for]")].flatMap((each) =>
            ["aria-describedby", "aria-controls", "aria-labelledby", "for"].flatMap((name) => (each.getAttribute(name) ?? "").split(" ")).filter((id) => id && !document.getElementById(id)))"""
    )
    assert dangling == []


def test_the_controls_are_those_of_the_scene_s_keys(sky, native):
    reference = native("scene", "reference")
    for key in ["sun.elevation", "atmosphere.ozone.column", "observer.altitude"]:
        low, high = re.search(rf"### `{re.escape(key)}`.*?\*(-?[\d.]+) to (-?[\d.]+)", reference, re.DOTALL).groups()
        number = sky.page.locator(f"[data-key='{key}'] input[type=number]")
        assert (float(number.get_attribute("min")), float(number.get_attribute("max"))) == (float(low), float(high))


def test_the_tour_has_seven_steps_each_with_a_sky(sky):
    start(sky, "sun.elevation=3" + PIXELS)
    sky.page.set_viewport_size({"width": 220, "height": 200})
    titles = []
    sky.forget()
    sky.page.locator("#tour-start").click()
    while True:
        sky.done()
        expect(sky.complaint).to_be_hidden()
        titles.append((sky.page.locator("#tour-title").text_content(), sky.scene))
        if sky.page.locator("#tour-next").text_content() == "Finish":
            break
        sky.forget()
        sky.page.locator("#tour-next").click()
    assert len({title for title, _ in titles}) == len({scene for _, scene in titles}) == 7
    sky.page.locator("#tour-next").click()
    expect(sky.page.locator("#tour")).to_be_hidden()


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_a_phone_scrolls_only_downwards(sky, scheme):
    sky.page.emulate_media(color_scheme=scheme)
    sky.page.set_viewport_size({"width": 390, "height": 844})
    start(sky, PERSPECTIVE + "&sun.elevation=3&measure=0,20" + PIXELS)
    sky.page.evaluate("() => document.querySelectorAll('details').forEach((each) => { each.open = true; })")
    assert sky.page.evaluate("() => document.documentElement.scrollWidth") <= 390
    wide = sky.page.evaluate("() => [...document.querySelectorAll('body *')].filter((each) => each.getBoundingClientRect().right > 391 && !each.closest('.unseen, svg')).map((each) => each.outerHTML.slice(0, 80))")
    assert wide == []
    sky.page.emulate_media(color_scheme="light")
