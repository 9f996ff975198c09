// The page: what a person does becomes a scene, and a scene becomes a picture, an address, a command and a file.

import init, * as sorairo from "./sorairo.js";
import { address, at, parse, seenAlike, toml, withPreset } from "./scene.js";
import { Controls, element, rounded } from "./controls.js";
import { Painter, WorkerCalls } from "./renderer.js";
import { View, isWhole, lookOf, paint, show } from "./view.js";
import { Dome, Place } from "./sun.js";
import { Strip } from "./strip.js";
import { Readout } from "./readout.js";
import { Tour } from "./tour.js";

/** The sky of an address without a scene. */
const START = {
  "sun.elevation": 4, "sun.azimuth": 20, "sun.disc": true,
  "camera.projection": "perspective", "camera.fov": 100, "camera.look_azimuth": 0, "camera.look_elevation": 20,
};
/** Most pixels of a picture whose size the window decides. */
const MOST_PIXELS = 2.5e6;
/** Columns of an error map, each of whose pixels takes every wavelength: a coarse one comes first. */
const MAP_COLUMNS = [48, 96, 192];

const byId = (id) => document.getElementById(id);
const sentence = (error) => String(error?.message ?? error);
const pixels = ([width, height]) => `${width}x${height}`;

let state = { scene: {}, beside: null, measured: null, errors: null };
/** The size of the full picture that was asked for last. */
let drawnSize;
/** `mapper` and `dayWorker` are workers of their own: an error map and a day take seconds, and no picture waits for them. */
let worker, mapper, dayWorker, painter, view, controls, place, dome, strip, readout, tour;

function complain(text) {
  byId("complaint").textContent = text;
  byId("complaint").hidden = !text;
}

function say(text) {
  byId("say").textContent = text;
}

/** The size of the picture: the scene's, or as many pixels as the window has room for. */
function size(scene) {
  const asked = /^(\d+)x(\d+)$/.exec(scene["camera.size"] ?? "");
  if (asked) return [Number(asked[1]), Number(asked[2])];
  const [width, height] = view.room;
  const density = Math.min(devicePixelRatio, Math.sqrt(MOST_PIXELS / (width * height)));
  return [Math.max(1, Math.round(width * density)), Math.max(1, Math.round(height * density))];
}

const sized = (scene, picture = size(scene)) => ({ ...scene, "camera.size": scene["camera.size"] ?? pixels(picture) });
const text = (scene, picture) => toml({ ...scene, "camera.size": pixels(picture) });

function camera(effective, [width, height]) {
  return {
    projection: effective["camera.projection"], fov: effective["camera.fov"], width, height,
    lookAzimuth: effective["camera.look_azimuth"], lookElevation: effective["camera.look_elevation"],
  };
}

/** Every key's value. What a projection leaves to its default is read off the directions of a picture of three by three pixels. */
function effective(scene) {
  const values = JSON.parse(sorairo.scene(toml(sized(scene))));
  if (isWhole(values["camera.projection"])) return values;
  const seen = (column, row) => JSON.parse(sorairo.direction(text(scene, [3, 3]), column, row));
  const look = lookOf(seen(1, 1), seen(1, 0), seen(0, 1), values["camera.projection"]);
  for (const [key, value] of Object.entries(look)) values[key] ??= rounded(value);
  return values;
}

/** Takes up a change if the scene allows it; otherwise says why not, and everything stays. */
function attempt(change, { following = false, quiet = false } = {}) {
  const next = { ...state, ...change };
  try {
    next.effective = effective(next.scene);
    next.sun = JSON.parse(sorairo.sun(toml(sized(next.scene))));
    next.left = next.beside && effective(seenAlike(next.beside, next.scene));
    if (next.errors && ![...byId("errors").options].some((option) => option.value === next.errors)) throw `There is no fit “${next.errors}” to show the errors of.`;
  } catch (error) {
    if (!quiet) complain(sentence(error));
    if (state.effective) controls.show(state.effective, state.scene);
    return false;
  }
  state = next;
  complain("");
  describe(following);
  draw(following);
  return true;
}

const set = (keys, options) => attempt({ scene: { ...state.scene, ...keys } }, options);

function without(scene, ...keys) {
  return Object.fromEntries(Object.entries(scene).filter(([key]) => !keys.includes(key)));
}

function setSun({ azimuth, elevation }, following) {
  attempt({ scene: at(without(state.scene, "sun.place", "sun.time"), { azimuth, elevation }) }, { following });
}

function changed(key, value, following) {
  if (key === "preset") return attempt({ scene: withPreset(state.scene, value) });
  if (key === "sun.elevation" || key === "sun.azimuth") return setSun({ ...state.sun, [key.slice(4)]: value ?? Number(controls.keys[key].default) }, following);
  if (value === undefined) return attempt({ scene: without(state.scene, key) });
  if (key === "camera.projection") return attempt({ scene: { ...without(state.scene, "camera.fov", "camera.look_azimuth", "camera.look_elevation"), [key]: value } });
  return set({ [key]: value }, { following });
}

/** Everything that shows the scene, but the picture. */
function describe(following) {
  const { scene, sun } = state;
  const full = size(scene);
  controls.show(state.effective, scene);
  dome.show(sun);
  place.show(scene);
  strip.mark(sun);
  ev100(state.effective["render.exposure"]);
  view.fit(full);
  view.mark(camera(state.effective, full), sun, state.measured);
  byId("sun-text").textContent = `The sun stands ${Math.abs(sun.elevation).toFixed(2)}° ${sun.elevation < 0 ? "below" : "above"} the horizon, at azimuth ${sun.azimuth.toFixed(2)}°.`;
  byId("right").setAttribute("aria-label", `The sky of ${state.effective.preset ?? "a scene"} with the sun at elevation ${sun.elevation.toFixed(1)}°, azimuth ${sun.azimuth.toFixed(1)}°`);
  for (const box of byId("orders").querySelectorAll("input")) box.checked = box.value === String(state.effective["render.orders"]);
  byId("errors").value = state.errors ?? "";
  compared();
  if (!state.measured) readout.hide();
  if (following) return;
  byId("command").value = sorairo.command(toml(sized(scene)));
  byId("scene-text").value = toml(sized(scene));
  history.replaceState(null, "", address(state));
}

/** Shows an exposure as a camera is set to it: a number of stops, or the one that the program found. */
function ev100(stops, found) {
  const shown = (number) => (typeof number === "number" ? String(rounded(sorairo.stops_of_ev100(number).toFixed(2))) : "");
  byId("ev100").value = shown(stops);
  byId("ev100").placeholder = shown(found);
}

function compared() {
  const { beside, left } = state;
  for (const id of ["left", "divider", "swap", "single", "differences"]) byId(id).hidden = !beside;
  byId("compare-text").textContent = beside ? "The left sky stays; the controls change the right one." : "The sky that you see now stays on the left of a divider, while you change the one on the right.";
  byId("keep").textContent = beside ? "Keep the right sky on the left" : "Keep this sky on the left";
  if (!beside) return;
  const differing = Object.keys(state.effective).filter((key) => JSON.stringify(left[key]) !== JSON.stringify(state.effective[key]));
  const shown = (value) => (typeof value === "number" ? String(rounded(value)) : String(value ?? ""));
  byId("differences").tBodies[0].replaceChildren(...differing.map((key) => element("tr", {}, element("th", { scope: "row" }, key), element("td", {}, shown(left[key])), element("td", {}, shown(state.effective[key])))));
}

function draw(following) {
  byId("view").dataset.state = "drawing";
  byId("waiting").textContent = "Drawing";
  if (!state.errors || following) for (const id of ["map", "legend"]) byId(id).hidden = true;
  mapper.stop();
  drawnSize = pixels(size(state.scene));
  painter.want({ ...state, size: size(state.scene), exact: "camera.size" in state.scene, following });
}

async function drawn(job, picture, last) {
  let taken;
  const ask = async (scene) => {
    const start = performance.now();
    const answer = await worker.call("picture", text(scene, picture), !last);
    taken = performance.now() - start;
    return answer;
  };
  // The worker still knows the sky that it drew last: the right one ends a full picture, of which the spectrum is asked next.
  const besides = async () => job.beside && ask(seenAlike(job.beside, job.scene));
  let left = last && (await besides());
  const right = await ask(job.scene);
  const tookRight = taken;
  left ||= await besides();
  show(byId("right"), right.bitmap);
  if (left) show(byId("left"), left.bitmap);
  byId("left").hidden = !state.beside;
  if (right.device) told(right, picture, tookRight);
  if (!last || painter.wanted !== job) return;
  controls.found("render.exposure", right.exposure);
  ev100(state.effective["render.exposure"], right.exposure);
  if (job.measured) await readout.measure(worker, job, (scene) => toml(sized(scene)));
  if (job.errors && painter.wanted === job) await mapped(job, picture);
  if (painter.wanted !== job) return;
  Object.assign(byId("view").dataset, { state: "done", shown: text(job.scene, picture) });
  if (strip.isSeen) ofTheDay(job);
}

/** Draws the strip of a sky's day, by a worker of its own. */
function ofTheDay({ scene, size: full }) {
  const moments = JSON.parse(sorairo.filmstrip(text(scene, full)));
  const sky = moments.map((moment) => text(at(scene, moment), full)).join();
  const draw = async (moment, picture) => (await dayWorker.call("picture", text(at(scene, moment), picture), true)).bitmap;
  strip.want(sky, moments, full, draw).catch((error) => complain(sentence(error)));
  strip.mark(state.sun);
}

async function mapped(job, [width, height]) {
  const widest = Math.min(width, MAP_COLUMNS.at(-1));
  const steps = [...MAP_COLUMNS.filter((each) => each < widest), widest];
  for (const [done, each] of steps.entries()) {
    const small = [each, Math.max(1, Math.round((height * each) / width))];
    byId("waiting").textContent = `Computing every wavelength, ${done + 1} of ${steps.length}`;
    const map = await mapper.call("errors", text(job.scene, small), job.errors);
    if (painter.wanted !== job) return;
    paint(byId("map"), map.pixels, small);
    legend(map.scale, job.errors);
  }
}

function failed(error, job) {
  complain(sentence(error));
  byId("view").dataset.state = "failed";
  byId("waiting").textContent = job.following ? "Drawing" : "No picture of this scene";
}

/** Says who drew a picture, and why not another. */
function told({ device, isGpu, whyNotGpu }, [width, height], taken) {
  byId("status").textContent = `${width} × ${height} pixels in ${Math.round(taken)} ms on ${device}.`;
  painter.isSlow = !isGpu;
  byId("notice").hidden = isGpu;
  if (!isGpu) byId("notice").textContent = whyNotGpu ? `The processor draws this sky, slower than a GPU would. ${whyNotGpu.replace(/\.?$/, ".")}` : "The processor draws this sky, as the address asks.";
}

const hands = {
  look(right, up, following) {
    const seen = camera(state.effective, size(state.scene));
    if (isWhole(seen.projection)) return say("The whole sphere is in sight; choose another projection to look around.");
    const azimuth = seen.lookAzimuth + (right * seen.fov) / Math.max(0.2, Math.cos((seen.lookElevation * Math.PI) / 180));
    const elevation = Math.min(90, Math.max(-90, seen.lookElevation + up * seen.fov));
    set({ "camera.look_azimuth": rounded(((azimuth + 540) % 360) - 180), "camera.look_elevation": rounded(elevation) }, { following, quiet: true });
  },
  zoom(factor, following) {
    if (isWhole(state.effective["camera.projection"])) return hands.look();
    set({ "camera.fov": rounded(state.effective["camera.fov"] * factor) }, { following, quiet: true });
  },
  sun(position, following) {
    const direction = seenAt(position);
    if (direction) setSun(direction, following);
  },
  measure(position) {
    const direction = seenAt(position);
    if (direction) attempt({ measured: { azimuth: rounded(direction.azimuth), elevation: rounded(direction.elevation) } });
  },
  settle: () => attempt({}),
};

function seenAt({ x, y }) {
  const full = size(state.scene);
  const at = (part, length) => Math.min(length - 1, Math.max(0, Math.floor(part * length)));
  return JSON.parse(sorairo.direction(text(state.scene, full), at(x, full[0]), at(y, full[1])));
}

function save(name, type, content) {
  const link = element("a", { href: URL.createObjectURL(new Blob([content], { type })), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60000);
}

/** The files of the native program, made by the same encoders. */
async function saveFile(kind, type) {
  const button = byId(`save-${kind}`);
  button.disabled = true;
  try {
    save(`sorairo.${kind}`, type, await worker.call(kind, toml(sized(state.scene))));
  } catch (error) {
    complain(sentence(error));
  }
  button.disabled = false;
}

async function copy(content, what) {
  try {
    await navigator.clipboard.writeText(content);
    say(`${what} is on the clipboard.`);
    byId("status").textContent = `${what} is on the clipboard.`;
  } catch {
    complain(`The browser does not let the page write to the clipboard. ${what} is: ${content}`);
  }
}

function legend(scale, fit) {
  const card = byId("legend");
  const said = typeof scale === "string" ? JSON.parse(scale) : scale;
  byId("legend-text").textContent = said.sentence ?? `Errors of the fit ${fit}`;
  byId("legend-scale").replaceChildren(...(said.steps ?? []).map((step) => {
    const swatch = element("span", {}, step.label);
    swatch.style.setProperty("--swatch", step.color);
    return swatch;
  }));
  card.hidden = false;
}

function buttons() {
  const click = (id, act) => byId(id).addEventListener("click", act);
  click("keep", () => {
    attempt({ beside: { ...state.scene } });
    view.divideVisibly();
  });
  click("swap", () => attempt({ scene: seenAlike(state.beside, state.scene), beside: state.scene }));
  click("single", () => attempt({ beside: null }));
  click("save-png", () => saveFile("png", "image/png"));
  click("save-exr", () => saveFile("exr", "image/x-exr"));
  click("save-scene", () => save("sorairo.toml", "application/toml", toml(sized(state.scene))));
  click("copy-link", () => copy(location.href, "The link"));
  click("copy-command", () => copy(byId("command").value, "The command"));
  click("spectrum-close", () => { attempt({ measured: null }); byId("frame").focus(); });
  click("tour-start", () => tour.go(0));
  click("fold", () => {
    const folded = document.body.classList.toggle("folded");
    byId("fold").setAttribute("aria-expanded", String(!folded));
    byId("fold").textContent = folded ? "Show controls" : "Hide controls";
  });
  byId("ev100").addEventListener("change", () => changed("render.exposure", byId("ev100").value === "" ? undefined : rounded(sorairo.stops_of_ev100(byId("ev100").valueAsNumber)), false));
  byId("errors").addEventListener("change", () => attempt({ errors: byId("errors").value || null }));
  byId("measure").addEventListener("submit", (event) => {
    event.preventDefault();
    attempt({ measured: { azimuth: byId("measure-azimuth").valueAsNumber, elevation: byId("measure-elevation").valueAsNumber } });
  });
}

/** One button for each of what a person compares: the first order, two, and all of them. */
function orders() {
  const row = controls.keys["render.orders"];
  const home = byId("orders");
  home.firstElementChild.textContent = row.sentence;
  for (const value of ["1", "2", "all"]) {
    const box = element("input", { type: "radio", name: "orders", value });
    box.addEventListener("change", () => set({ "render.orders": value === "all" ? value : Number(value) }));
    home.append(element("label", {}, box, value));
  }
}

function fits() {
  const names = controls.keys["render.fit"].choices.filter((name) => name !== "dense");
  byId("errors").replaceChildren(element("option", { value: "" }, "no fit"), ...names.map((name) => element("option", { value: name }, name)));
}

function fromAddress() {
  try {
    const { scene, ...rest } = parse(location.hash);
    if (attempt({ ...rest, scene: location.hash.length > 1 ? scene : START })) return true;
  } catch (error) {
    complain(sentence(error));
  }
  return false;
}

async function compiled() {
  const response = await fetch(new URL("sorairo_bg.wasm", import.meta.url));
  if (!response.ok) throw `The file sorairo_bg.wasm is not beside the page (${response.status}).`;
  const isTyped = response.headers.get("content-type")?.startsWith("application/wasm");
  return isTyped ? WebAssembly.compileStreaming(response) : WebAssembly.compile(await response.arrayBuffer());
}

function firstSky() {
  if (fromAddress()) return;
  const why = byId("complaint").textContent;
  attempt({ scene: START, beside: null, measured: null, errors: null });
  complain(why);
}

/** Takes up another size of the window. */
function fitted() {
  view.fit(size(state.scene));
  if (pixels(size(state.scene)) === drawnSize) return;
  describe(false);
  draw(false);
}

async function start() {
  const module = await compiled();
  worker = new WorkerCalls(module, new URLSearchParams(location.search).get("device") ?? "auto");
  worker.open().catch((error) => complain(sentence(error)));
  mapper = new WorkerCalls(module, "cpu");
  dayWorker = new WorkerCalls(module, "cpu");
  await init({ module_or_path: module });
  painter = new Painter(drawn, failed);
  view = new View(hands);
  controls = new Controls(JSON.parse(sorairo.keys()), changed);
  dome = new Dome(setSun, hands.settle);
  place = new Place({
    set: (keys, following) => attempt({ scene: { ...without(state.scene, "sun.elevation", "sun.azimuth", "sun.distance"), ...keys } }, { following }),
    angles: () => setSun(state.sun, false),
    idle: () => painter.idle,
  });
  strip = new Strip((moment) => attempt({ scene: at(state.scene, moment) }));
  readout = new Readout();
  tour = new Tour((step) => {
    attempt({ beside: null, measured: null, errors: null, ...step });
    view.divideVisibly();
  });
  orders();
  fits();
  buttons();
  firstSky();
  addEventListener("hashchange", fromAddress);
  new ResizeObserver(fitted).observe(byId("view"));
  navigator.serviceWorker?.register(new URL("sw.js", import.meta.url)).catch(() => { /* Without it the page needs its network. */ });
}

start().catch((error) => {
  byId("view").dataset.state = "failed";
  byId("waiting").textContent = "No sky";
  complain(`The page could not start: ${sentence(error)}`);
});
