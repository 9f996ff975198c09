"""The page in a real browser: Debian's Chromium without a window, with WebGPU in software, and the page on
127.0.0.1."""

import base64
import gzip
import http.server
import io
import os
import re
import subprocess
import threading
from pathlib import Path

import numpy
import pytest
from PIL import Image
from playwright.sync_api import expect, sync_playwright

ROOT = Path(__file__).resolve().parents[2]
SITE = Path(os.environ.get("SORAIRO_WEB", ROOT / "target/web"))
PROGRAM = Path(os.environ.get("SORAIRO_PROGRAM", ROOT / "target/release/sorairo"))
CHROMIUM = os.environ.get("SORAIRO_CHROMIUM", "/usr/bin/chromium")

PLAIN = ["--no-sandbox"]
# A device in software that computes, but is lost where it draws into a canvas: what shows the page shares no memory
# with it.
COMPUTES = [*PLAIN, "--enable-unsafe-webgpu", "--use-webgpu-adapter=swiftshader", "--enable-unsafe-swiftshader"]
# The same device, and the page is shown by it too.
WEBGPU = [*COMPUTES, "--enable-features=Vulkan", "--use-vulkan=swiftshader", "--use-angle=vulkan"]

# Software compiles a kernel in seconds, and the machine may be loaded: far longer than anything takes, yet an end.
PATIENCE = 180_000

# Small pictures: software computes them.
SIZE = (192, 96)


class Server(http.server.ThreadingHTTPServer):
    """Serves the page, and counts what goes over the wire as a server that compresses would send it."""

    def __init__(self, folder=SITE):
        self.folder, self.sent = folder, {}
        super().__init__(("127.0.0.1", 0), Pages)
        threading.Thread(target=self.serve_forever, daemon=True).start()

    @property
    def address(self):
        return f"http://127.0.0.1:{self.server_port}/"


class Pages(http.server.SimpleHTTPRequestHandler):
    extensions_map = {".html": "text/html", ".js": "text/javascript", ".css": "text/css", ".wasm": "application/wasm"}

    def __init__(self, request, client, server):
        super().__init__(request, client, server, directory=str(server.folder))

    def log_message(self, *_):
        pass

    def do_GET(self):
        path = Path(self.translate_path(self.path))
        path = path / "index.html" if path.is_dir() else path
        if path.is_file():
            self.server.sent[path.name] = len(gzip.compress(path.read_bytes(), 9))
        super().do_GET()


@pytest.fixture(scope="session")
def server():
    assert (SITE / "sorairo.js").is_file(), f"{SITE} holds no page: run `cargo xtask web`"
    made = Server()
    yield made
    made.shutdown()


@pytest.fixture(scope="session")
def chromium():
    with sync_playwright() as playwright:
        opened = []

        def launch(arguments):
            opened.append(playwright.chromium.launch(executable_path=CHROMIUM, args=arguments))
            return opened[-1]

        yield launch
        for browser in opened:
            browser.close()


@pytest.fixture(scope="session")
def browser(chromium):
    return chromium(WEBGPU)


class Sky:
    """A page with a sky, and what a person sees of it."""

    def __init__(self, context, address):
        self.address, self.context, self.troubles, self.asked = address, context, [], []
        self.page = context.new_page()
        self.page.set_default_timeout(PATIENCE)
        self.page.on("console", lambda message: message.type == "error" and self.troubles.append(message.text))
        self.page.on("pageerror", lambda error: self.troubles.append(str(error)))
        self.page.on("request", lambda request: self.asked.append(request.url))
        self.view = self.page.locator("#view")
        self.frame = self.page.locator("#frame")
        self.complaint = self.page.locator("#complaint")

    def open(self, scene=""):
        self.page.goto(self.address + (f"#{scene}" if scene else ""))
        return self.done()

    def done(self):
        """Waits until the picture of what was asked for last stands there in full."""
        expect(self.view).to_have_attribute("data-state", re.compile("done|failed"), timeout=PATIENCE)
        assert self.view.get_attribute("data-state") == "done", self.complaint.text_content()
        return self

    def forget(self):
        """From here on `done` waits for a picture that is asked for later."""
        self.page.evaluate("() => { document.getElementById('view').dataset.state = 'asked'; }")

    def go(self, scene):
        """Follows a link to another scene."""
        self.forget()
        self.page.evaluate("scene => { location.hash = scene; }", scene)
        return self.done()

    def link(self, scene):
        """Follows a link that may be broken."""
        self.page.evaluate("scene => { location.hash = scene; }", scene)

    @property
    def scene(self):
        """The scene file of the picture that stands there."""
        return self.view.get_attribute("data-shown")

    @property
    def device(self):
        return self.page.locator("#status").text_content()

    def pixels(self, canvas="right"):
        """Height × width × RGB of what a canvas shows."""
        return self.decoded(
            """id => {
                const canvas = document.getElementById(id);
                const copy = new OffscreenCanvas(canvas.width, canvas.height).getContext("2d", { willReadFrequently: true });
                copy.drawImage(canvas, 0, 0);
                return copy.getImageData(0, 0, canvas.width, canvas.height);
            }""",
            canvas,
        )

    def picture(self):
        """Height × width × RGB of the picture that stands there, as a studio of the page's own thread reads it back."""
        size = re.search(r'camera.size = "(\d+)x(\d+)"', self.scene)
        return self.decoded(
            """async ([toml, width, height]) => {
                const { Studio } = await import("./sorairo.js");
                self.studio ??= await Studio.open("auto");
                return { data: await self.studio.picture(toml), width, height };
            }""",
            [self.scene, int(size[1]), int(size[2])],
        )

    def decoded(self, image, *arguments):
        """Height × width × RGB of the image that a function of the page gives."""
        data, height, width = self.page.evaluate(
            f"""async (...all) => {{
                const {{ data, width, height }} = await ({image})(...all);
                let text = "";
                for (let i = 0; i < data.length; i += 4096) text += String.fromCharCode(...data.subarray(i, i + 4096));
                return [btoa(text), height, width];
            }}""",
            *arguments,
        )
        return numpy.frombuffer(base64.b64decode(data), numpy.uint8).reshape(height, width, 4)[..., :3].astype(int)

    def worker_begins(self, script):
        """Before the page is opened: its workers run a script before their own."""
        self.page.route("**/worker.js", lambda route: route.fulfill(body=script + route.fetch().text(), content_type="text/javascript"))

    def value(self, key):
        """What the page's own scene file says of a key; None where the preset decides."""
        found = re.search(rf"^{re.escape(key)} = (.*)$", self.scene, re.MULTILINE)
        return found and found[1]

    def still_there(self, pixels):
        return numpy.array_equal(self.pixels(), pixels)


def context(browser, width=800, height=500, **more):
    return browser.new_context(viewport={"width": width, "height": height}, **more)


@pytest.fixture(scope="session")
def shared(browser, server):
    """One page for most tests: software takes seconds to compile the kernels for another."""
    return Sky(context(browser), server.address).open(f"camera.size={SIZE[0]}x{SIZE[1]}")


@pytest.fixture
def sky(shared):
    """The shared page; whatever a test does there, the browser's console hears of no error."""
    shared.page.set_viewport_size({"width": 800, "height": 500})
    yield shared
    troubles, shared.troubles[:] = list(shared.troubles), []
    assert troubles == []


@pytest.fixture
def native(tmp_path):
    """Runs the native program in a folder, successfully, and returns what it prints."""

    def run(*arguments):
        assert PROGRAM.is_file(), f"{PROGRAM} is missing: run `cargo build --release`"
        done = subprocess.run([PROGRAM, *map(str, arguments)], cwd=tmp_path, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return done.stdout

    return run


@pytest.fixture
def native_picture(native, tmp_path):
    """The RGB of the PNG that the native program renders of a scene file's text."""

    def render(toml):
        (tmp_path / "scene.toml").write_text(toml)
        native("--quiet", "render", "--scene", "scene.toml", "--device", "cpu", "-o", "sky.png")
        return rgb((tmp_path / "sky.png").read_bytes())

    return render


def rgb(png):
    return numpy.asarray(Image.open(io.BytesIO(png)).convert("RGB")).astype(int)
