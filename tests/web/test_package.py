"""The package for npm, and a page of three.js that draws a sky into its own device."""

import json
import math
import re
import shutil
import subprocess

import numpy
import pytest

from conftest import PATIENCE, ROOT, SITE, Server, context, rgb

PACKAGE = SITE.parent / "npm"
EXAMPLE = ROOT / "host/web/examples/three.html"
WINDOW = (360, 240)


def npm(folder, *arguments):
    done = subprocess.run(["npm", *map(str, arguments)], cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture(scope="session")
def packed(tmp_path_factory):
    """The packed package, and what npm says of it."""
    folder = tmp_path_factory.mktemp("packed")
    (told,) = json.loads(npm(folder, "pack", "--json", PACKAGE))
    return folder / told["filename"], told


@pytest.fixture(scope="session")
def project(packed, tmp_path_factory):
    """A folder with the example, three.js, TypeScript and the package."""
    folder = tmp_path_factory.mktemp("project")
    for file in [EXAMPLE, ROOT / "tests/web/package.json"]:
        shutil.copy(file, folder)
    npm(folder, "install", "--no-audit", "--no-fund", "--prefer-offline", packed[0])
    return folder


# Counts read-backs, and tells when the page has drawn or failed.
WATCHED = """
    self.readBack = 0;
    const map = GPUBuffer.prototype.mapAsync;
    GPUBuffer.prototype.mapAsync = function (...what) { self.readBack += 1; return map.apply(this, what); };
    for (const failure of ["error", "unhandledrejection"]) addEventListener(failure, () => { self.failed = true; });
"""


@pytest.fixture(scope="session")
def example(project, browser):
    """The page of the example once it has drawn."""
    server = Server(project)
    page = context(browser, *WINDOW).new_page()
    page.troubles = []
    page.on("console", lambda message: message.type == "error" and page.troubles.append(message.text))
    page.on("pageerror", lambda error: page.troubles.append(str(error)))
    page.add_init_script(WATCHED)
    page.goto(server.address + EXAMPLE.name)
    page.wait_for_function("() => document.body?.dataset.drawn || self.failed", timeout=PATIENCE)
    yield page
    page.context.close()
    server.shutdown()


@pytest.fixture
def page(example):
    """The same page; whatever a test does there, neither the console nor the handler of a device hears of an error."""
    yield example
    troubles, example.troubles[:] = list(example.troubles), []
    assert troubles == []


def test_the_package_holds_the_module_its_types_and_the_licences(packed):
    _, told = packed
    module = {"sorairo.d.ts", "sorairo.js", "sorairo_bg.wasm"}
    others = {"LICENSE-APACHE", "LICENSE-MIT", "README.md", "package.json"}
    assert {file["path"] for file in told["files"]} == module | others
    package = json.loads((PACKAGE / "package.json").read_text())
    workspace = (ROOT / "Cargo.toml").read_text()
    assert all(f'{key} = "{package[key]}"' in workspace for key in ["version", "license"])
    size = f"`{package['name']}`, {told['size'] / 1e6:.1f} MB packed, {package['license']}."
    assert size in (ROOT / "docs/browser.md").read_text()


TYPED = """
import init, { Studio, exposure, version } from "sorairo";
export async function drawn(device: GPUDevice, texture: GPUTexture, air: [GPUTexture, GPUTexture]): Promise<number> {
    await init();
    const studio: Studio = await Studio.attach(device);
    const toml: string = `# ${version()}`;
    await studio.draw(toml, texture, exposure(toml));
    return await studio.air(toml, ...air, 0);
}
"""
MISTAKES = {
    "none": ("", ""),
    "a device for a texture": ("draw(toml, texture,", "draw(toml, device,"),
    "a texture for a device": ("attach(device)", "attach(texture)"),
    "no such function": ("version }", "version, other }"),
    "no such device": ("Studio.attach(device)", 'Studio.open("gpu")'),
}


@pytest.mark.parametrize(("right", "wrong"), MISTAKES.values(), ids=MISTAKES.keys())
def test_typescript_knows_the_types(project, right, wrong):
    (project / "typed.ts").write_text(TYPED.replace(right, wrong))
    options = ["--noEmit", "--strict", "--target", "esnext", "--module", "esnext", "--moduleResolution", "bundler"]
    done = subprocess.run(["npx", "tsc", *options, "typed.ts"], cwd=project, capture_output=True, text=True)
    assert (done.returncode == 0) == (right == wrong), done.stdout


def test_three_shows_the_sky_of_the_studio(page):
    shown = rgb(page.locator("canvas").screenshot())
    assert page.evaluate("() => self.readBack") == 0
    toml = re.search(r"const toml = `(.*?)`", EXAMPLE.read_text(), re.DOTALL)[1]
    width, height = WINDOW
    # Three.js measures its camera's 60° from top to bottom.
    fov = math.degrees(2 * math.atan(width / height * math.tan(math.radians(30))))
    camera = f"""
        camera.projection = "perspective"
        camera.size = "{width}x{height}"
        camera.fov = {fov}
        camera.look_elevation = {math.degrees(math.atan(0.7))}
        render.view = "srgb"
        render.dither = "none"
    """
    picture = page.evaluate(
        """async ([toml, camera]) => {
            const { Studio, exposure } = await import("sorairo");
            const exposed = `${toml.replace(/camera.size.*/, "")}\\nrender.exposure = ${exposure(toml)}`;
            return Array.from(await (await Studio.open("auto")).picture(exposed + camera));
        }""",
        [toml, camera],
    )
    picture = numpy.array(picture).reshape(height, width, 4)[..., :3]
    # Half floats, and interpolation between texels of a third of a degree, may round a byte to its neighbour.
    assert numpy.abs(shown - picture).max() <= 1
    # The comparison would see another exposure, and a mirrored sky.
    assert 50 < shown.mean() < 200
    assert numpy.abs(shown - picture[:, ::-1]).max() > 20


# What scripts of the tests below have: a device whose handler complains, and a studio attached to it.
BESIDE = """async (script) => {
    const { Studio } = await import("sorairo");
    const opened = async () => (await navigator.gpu.requestAdapter()).requestDevice();
    const device = await opened();
    device.onuncapturederror = ({ error }) => console.error(error.message);
    const toml = `
        sun.elevation = 20.0
        camera.projection = "perspective"
        camera.size = "32x32"
        camera.look_elevation = 25.0
    `;
    const { COPY_DST, COPY_SRC, TEXTURE_BINDING, STORAGE_BINDING } = GPUTextureUsage;
    const usage = COPY_DST | COPY_SRC | TEXTURE_BINDING | STORAGE_BINDING;
    const texture = (size = [32, 32], format = "rgba16float") =>
        device.createTexture({ size, format, usage, dimension: size[2] ? "3d" : "2d" });
    const read = async (from) => {
        const { width, height: rowsPerImage, depthOrArrayLayers } = from;
        const [bytesPerRow, size] = [8 * width, [width, rowsPerImage, depthOrArrayLayers]];
        const usage = GPUBufferUsage.COPY_DST | GPUBufferUsage.MAP_READ;
        const buffer = device.createBuffer({ size: bytesPerRow * rowsPerImage * depthOrArrayLayers, usage });
        const encoder = device.createCommandEncoder();
        encoder.copyTextureToBuffer({ texture: from }, { buffer, bytesPerRow, rowsPerImage }, size);
        device.queue.submit([encoder.finish()]);
        await buffer.mapAsync(GPUMapMode.READ);
        return Array.from(new Uint16Array(buffer.getMappedRange()));
    };
    const studio = await Studio.attach(device);
    return eval(`(async () => { ${script} })()`);
}"""

WRONG = {
    "no device": ("Studio.attach({})", "not a GPUDevice"),
    "no texture": ("studio.draw(toml, {}, 0)", "rgba16float"),
    "another format": ("studio.draw(toml, texture([32, 32], 'rgba8unorm'), 0)", "rgba16float"),
    "too small": ("studio.draw(toml, texture([16, 16]), 0)", "16x16"),
    "a volume": ("studio.draw(toml, texture([32, 32, 8]), 0)", "D2"),
    "another device": ("(await Studio.attach(await opened())).draw(toml, texture(), 0)", "cannot be used with"),
    "no exposure": ("studio.draw(toml, texture(), NaN)", "finite"),
    "no key": ("studio.draw('sun.height = 1', texture(), 0)", "sun.height"),
    "not attached": ("(await Studio.open('cpu')).draw(toml, texture(), 0)", "Studio.attach"),
    "two sizes": ("studio.air(toml, texture([32, 32, 8]), texture([32, 32, 4]), 0)", "one size"),
    "a lost device": ("studio.draw(toml, texture(), 0, device.destroy(), await device.lost)", "lost.*attach another"),
}


@pytest.mark.parametrize(("script", "complaint"), WRONG.values(), ids=WRONG.keys())
def test_the_page_is_told_what_is_wrong(page, script, complaint):
    told = page.evaluate(BESIDE, f"return {script}.then(() => 'nothing', (error) => error);")
    assert isinstance(told, str) and re.search(complaint, told), told


def test_a_studio_opens_no_other_device_for_one_that_is_lost(page):
    script = "device.destroy(); await device.lost; const told = () => studio.picture(toml).catch((error) => error);"
    first, second = page.evaluate(BESIDE, f"{script} return [await told(), await told()];")
    assert "attach another" in first and "attach another" in second


def test_navigator_is_as_it_was(page):
    script = "return [Object.getOwnPropertyNames(navigator), navigator.gpu instanceof GPU];"
    assert page.evaluate(BESIDE, script) == [[], True]


def halves(values, *shape):
    """RGB of half floats."""
    return numpy.array(values, numpy.uint16).view(numpy.float16).reshape(*shape, 4)[..., :3].astype(float)


def test_the_air_before_a_camera_ends_in_its_sky(page):
    script = """
        const all = [texture(), texture(), texture([32, 32, 8]), texture([32, 32, 8])];
        const [sky, exposed, ...volumes] = all;
        await studio.draw(toml, sky, 0);
        await studio.draw(toml, exposed, 3);
        const middle = await studio.air(toml, ...volumes, 0);
        return [middle, ...await Promise.all(all.map(read))];
    """
    middle, sky, exposed, in_scatter, transmittance = page.evaluate(BESIDE, script)
    sky, exposed = halves(sky, 32, 32), halves(exposed, 32, 32)
    in_scatter, transmittance = halves(in_scatter, 8, 32, 32), halves(transmittance, 8, 32, 32)
    assert middle == 25
    assert sky.min() > 0
    # Half floats have eleven bits.
    assert numpy.allclose(exposed, 8 * sky, rtol=2e-3)
    # The middle of the image lies between texels of both.
    middle = numpy.s_[15:17, 15:17]
    assert numpy.allclose(in_scatter[-1][middle].mean((0, 1)), sky[middle].mean((0, 1)), rtol=1e-2)
    assert (numpy.diff(in_scatter, axis=0) >= 0).all() and (numpy.diff(transmittance, axis=0) <= 0).all()
    assert numpy.allclose(transmittance[0], 1)
