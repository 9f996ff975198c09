"""The page shows the pictures of the native program."""

import re
import time

import numpy
import pytest
from playwright.sync_api import expect

from conftest import PATIENCE, PLAIN, SIZE, Sky, context

SCENES = {
    "the whole sphere": "sun.elevation=30",
    "a low sun with its disc": "sun.elevation=1.5&sun.disc=true&camera.projection=perspective&camera.fov=70&camera.look_elevation=12",
    "haze, as a fisheye sees it": "preset=hazy&sun.elevation=20&camera.projection=fisheye",
    "twilight without ozone": "sun.elevation=-4&atmosphere.ozone.column=0&render.exposure=2.5&camera.projection=perspective&camera.fov=100",
    "mars": "preset=mars&sun.elevation=25&sun.azimuth=30&camera.projection=perspective&camera.look_azimuth=20",
    "one order from a balloon": "observer.altitude=30&sun.elevation=10&render.orders=1&camera.projection=perspective&camera.look_elevation=0&render.exposure=-3.5",
}
PIXELS = f"&camera.size={SIZE[0]}x{SIZE[1]}"


@pytest.mark.parametrize("scene", SCENES.values(), ids=SCENES.keys())
def test_every_pixel_is_that_of_the_native_program(sky, native_picture, scene):
    sky.go(scene + PIXELS)
    assert "WebGPU" in sky.device
    seen, rendered = sky.pixels(), native_picture(sky.scene)
    # Two devices may round a value to the two neighbours of a step of 8 bits.
    assert numpy.abs(seen - rendered).max() <= 1
    # The comparison would see another sky.
    assert numpy.abs(seen - native_picture(higher(sky.scene))).max() > 1


def higher(toml):
    """The scene with the sun a degree higher."""
    return re.sub(r"^sun.elevation = (.*)$", lambda found: f"sun.elevation = {float(found[1]) + 1}", toml, flags=re.MULTILINE)


def test_the_processor_draws_where_there_is_no_webgpu(chromium, server, native_picture):
    sky = Sky(context(chromium([*PLAIN, "--disable-features=WebGPU"])), server.address)
    sky.open("sun.elevation=8&camera.projection=perspective" + PIXELS)
    assert "CPU" in sky.device
    expect(sky.page.locator("#notice")).to_contain_text("WebGPU")
    assert numpy.abs(sky.pixels() - native_picture(sky.scene)).max() <= 1
    sky.go("sun.elevation=-3&preset=no-ozone" + PIXELS)
    assert numpy.abs(sky.pixels() - native_picture(sky.scene)).max() <= 1
    assert sky.troubles == []


def test_the_first_sky_comes_soon_and_little_goes_over_the_wire(browser, server, capsys):
    server.sent.clear()
    start = time.monotonic()
    sky = Sky(context(browser, service_workers="block"), server.address)
    sky.page.goto(server.address + "#sun.elevation=8" + PIXELS)
    expect(sky.page.locator("#right")).to_have_attribute("width", re.compile(r"^(?!2$)\d+$"), timeout=PATIENCE)
    first = time.monotonic() - start
    sky.done()
    full = time.monotonic() - start
    wire = sum(server.sent.values())
    with capsys.disabled():
        print(f"\n{wire} bytes over the wire by gzip ({', '.join(f'{name} {size}' for name, size in sorted(server.sent.items(), key=lambda row: -row[1]))})")
        print(f"first sky after {first:.1f} s, in full after {full:.1f} s, in software, on {sky.device}")
    assert wire <= 1_500_000
    assert all(url.startswith(server.address) for url in sky.asked)
    sky.context.close()


def test_the_page_works_without_its_server(browser, server):
    away = type(server)()
    sky = Sky(context(browser), away.address)
    sky.open("sun.elevation=12&camera.size=48x24")
    # The service worker is at work once it has kept every file.
    sky.page.evaluate("async () => { await navigator.serviceWorker.ready; }")
    away.shutdown()
    away.server_close()
    sky.page.reload()
    sky.done()
    assert sky.value("sun.elevation") == "12"
    sky.context.close()


def test_the_processor_draws_what_a_small_device_cannot(browser, server, native_picture):
    sky = Sky(context(browser, service_workers="block"), server.address)
    # A device that binds 16 KiB at once: 4096 pixels.
    small = """
        const open = GPUAdapter.prototype.requestDevice;
        GPUAdapter.prototype.requestDevice = async function (...what) {
            const device = await open.apply(this, what);
            const limits = {};
            for (const name in device.limits) limits[name] = device.limits[name];
            Object.defineProperty(device, "limits", { value: { ...limits, maxStorageBufferBindingSize: 16384 } });
            return device;
        };
    """
    sky.page.route("**/worker.js", lambda route: route.fulfill(body=small + route.fetch().text(), content_type="text/javascript"))
    notice = sky.page.locator("#notice")
    sky.open("sun.elevation=8&camera.size=64x32")
    assert "WebGPU" in sky.device
    expect(notice).to_be_hidden()
    sky.go("sun.elevation=8" + PIXELS)
    assert "CPU" in sky.device
    expect(notice).to_contain_text("too small for this picture")
    expect(notice).to_contain_text("limits")
    assert numpy.abs(sky.pixels() - native_picture(sky.scene)).max() <= 1
    sky.go("sun.elevation=9&camera.size=64x32")
    assert "WebGPU" in sky.device
    expect(notice).to_be_hidden()
    assert sky.troubles == []
    sky.context.close()


def test_a_lost_device_costs_one_picture(browser, server, native_picture):
    sky = Sky(context(browser, service_workers="block"), server.address)
    # Remembers the device that the page opens, so that the test can take it away.
    keep = """
        const open = GPUAdapter.prototype.requestDevice;
        GPUAdapter.prototype.requestDevice = async function (...what) { return (self.device = await open.apply(this, what)); };
    """
    sky.page.route("**/worker.js", lambda route: route.fulfill(body=keep + route.fetch().text(), content_type="text/javascript"))
    sky.open("sun.elevation=8" + PIXELS)
    before = sky.pixels()
    sky.page.workers[0].evaluate("() => self.device.destroy()")
    sky.forget()
    sky.link("sun.elevation=9" + PIXELS)
    expect(sky.view).to_have_attribute("data-state", "failed", timeout=PATIENCE)
    expect(sky.complaint).to_contain_text("device")
    assert sky.still_there(before)
    sky.go("sun.elevation=10" + PIXELS)
    expect(sky.complaint).to_be_hidden()
    assert numpy.abs(sky.pixels() - native_picture(sky.scene)).max() <= 1
    sky.context.close()
