// A scene as the page holds it: the keys that a person has set, by their names in a scene file. Every other key has the value of the preset.

const NUMBER = /^[-+]?\d+(\.\d+)?([eE][-+]?\d+)?$/;

/** What the address says beside the scene. */
const PAGE_WORDS = ["compare", "measure", "errors", "tour"];

function literal(value) {
  if (Array.isArray(value)) return `[${value.map(literal).join(", ")}]`;
  return typeof value === "string" ? JSON.stringify(value) : String(value);
}

/** The text of the scene file. `preset` comes first because it stands above all tables. */
export function toml(scene) {
  const keys = Object.keys(scene).sort((a, b) => (a === "preset" ? -1 : b === "preset" ? 1 : 0));
  return keys.map((key) => `${key} = ${literal(scene[key])}\n`).join("");
}

function worded(value) {
  return Array.isArray(value) ? `[${value.join(",")}]` : String(value);
}

function valued(text) {
  if (NUMBER.test(text)) return Number(text);
  if (text === "true" || text === "false") return text === "true";
  if (/^\[[^\]]*\]$/.test(text)) return text.slice(1, -1).split(",").filter((part) => part.trim()).map((part) => valued(part.trim()));
  return text;
}

function query(scene) {
  return new URLSearchParams(Object.entries(scene).map(([key, value]) => [key, worded(value)])).toString();
}

function unquery(text) {
  return Object.fromEntries([...new URLSearchParams(text)].map(([key, value]) => [key, valued(value)]));
}

/** The part of the address behind `#`: the scene, and what the page shows of it. */
export function address({ scene, beside, measured, errors }) {
  const words = new URLSearchParams(query(Object.keys(scene).length ? scene : { preset: "standard" }));
  if (beside) words.set("compare", query(beside));
  if (measured) words.set("measure", `${measured.azimuth},${measured.elevation}`);
  if (errors) words.set("errors", errors);
  // What need not be escaped behind `#` is easier to read as it is.
  return `#${words.toString().replaceAll("%2C", ",").replaceAll("%3A", ":")}`;
}

/** What an address says; throws a sentence where it makes no sense. Values are left to the scene's own checks. */
export function parse(hash) {
  const all = unquery(hash.replace(/^#/, ""));
  const scene = {};
  for (const [key, value] of Object.entries(all)) {
    if (PAGE_WORDS.includes(key)) continue;
    if (!/^[a-z_]+(\.[a-z_]+)*$/.test(key)) throw `This link is broken: “${key}” is no key of a scene.`;
    scene[key] = value;
  }
  return {
    scene,
    beside: all.compare === undefined ? null : unquery(String(all.compare)),
    measured: all.measure === undefined ? null : direction(String(all.measure)),
    errors: all.errors ?? null,
  };
}

function direction(text) {
  const parts = text.split(",");
  if (parts.length !== 2 || !parts.every((part) => NUMBER.test(part))) throw `This link is broken: measure=${text} is not an azimuth and an elevation in degrees.`;
  return { azimuth: Number(parts[0]), elevation: Number(parts[1]) };
}

/** The scene without what a preset decides: where the sun stands, how one looks and how it is computed remain. */
export function withPreset(scene, preset) {
  const stays = (key) => /^(camera|render)\./.test(key) || ["sun.elevation", "sun.azimuth", "sun.place", "sun.time", "sun.disc"].includes(key);
  const kept = Object.entries(scene).filter(([key]) => stays(key) && key !== "render.orders");
  return { preset, ...Object.fromEntries(kept) };
}

/** A scene at a moment of its day. */
export function at(scene, { time, elevation, azimuth }) {
  const two = (value) => Number(value.toFixed(2));
  return time ? { ...scene, "sun.time": time } : { ...scene, "sun.elevation": two(elevation), "sun.azimuth": two(azimuth) };
}

/** The left sky as the right one's camera sees it. */
export function seenAlike(left, right) {
  const part = (scene, camera) => Object.fromEntries(Object.entries(scene).filter(([key]) => key.startsWith("camera.") === camera));
  return { ...part(left, false), ...part(right, true) };
}
