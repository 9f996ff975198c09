// One control for each key of the scene, made from the scene's own table of keys: ranges, units, defaults and sentences stand there.

/** Names short enough for a panel. The sentence of a key stands below its control. */
const NAMES = {
  "preset": "Atmosphere",
  "sun.elevation": "Elevation",
  "sun.azimuth": "Azimuth",
  "sun.disc": "The sun's disc",
  "sun.distance": "Distance of the sun",
  "observer.altitude": "Altitude",
  "atmosphere.air.pressure": "Pressure",
  "atmosphere.profile": "Profile",
  "atmosphere.aerosol.kind": "Kind of haze",
  "atmosphere.aerosol.optical_depth": "Haze",
  "atmosphere.aerosol.angstrom_exponent": "Ångström exponent",
  "atmosphere.aerosol.single_scattering_albedo": "Single-scattering albedo",
  "atmosphere.aerosol.asymmetry": "Asymmetry",
  "atmosphere.ozone.column": "Ozone",
  "ground.albedo": "Ground",
  "camera.projection": "Projection",
  "camera.fov": "Field of view",
  "camera.look_azimuth": "Look towards",
  "camera.look_elevation": "Look up",
  "camera.polariser": "Polariser",
  "camera.size": "Size of the picture",
  "render.fit": "Fit",
  "render.exposure": "Exposure",
  "render.view": "View transform",
  "render.look": "Look",
  "render.white_balance": "White balance",
};

const STEPS = 1000;

export function element(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name in made && typeof value !== "string") made[name] = value;
    else made.setAttribute(name, value);
  }
  made.append(...children);
  return made;
}

export const rounded = (value) => Number(Number(value).toPrecision(4));

/** From a value to its place on a slider and back. A range that is many times as wide as its default is stretched around zero, so that
 * small values have room; angles and narrow ranges are even. */
export function slider({ minimum, maximum, unit, default: standard }) {
  const soft = Math.abs(Number(standard)) || 1;
  const even = /degree|°/.test(unit ?? "") || (maximum - minimum) / soft < 40;
  const [to, from] = even ? [(v) => v, (t) => t] : [(v) => Math.asinh(v / soft), (t) => soft * Math.sinh(t)];
  const [low, high] = [to(minimum), to(maximum)];
  return {
    place: (value) => Math.round((STEPS * (to(value) - low)) / (high - low)),
    value: (position) => {
      if (position <= 0) return minimum;
      if (position >= STEPS) return maximum;
      const value = from(low + ((high - low) * position) / STEPS);
      return Math.abs(value) < (maximum - minimum) * 1e-9 ? 0 : rounded(value);
    },
  };
}

/** The controls of a page. `changed(key, value, following)` hears every change; a value of `undefined` takes the key back to its default. */
export class Controls {
  #shown = []; #found = {}; #last;

  constructor(keys, changed) {
    this.keys = Object.fromEntries(keys.map((row) => [row.key, row]));
    this.changed = changed;
    for (const home of document.querySelectorAll("[data-keys]")) {
      for (const key of home.dataset.keys.split(" ")) if (this.keys[key]) home.append(this.#control(key));
    }
  }

  /** Shows a scene: every key's value, and which of them a person has set. */
  show(effective, scene) {
    this.#last = [effective, scene];
    for (const update of this.#shown) update(effective, scene);
  }

  /** Shows the number that a picture had where the scene leaves it to the program. */
  found(key, number) {
    this.#found[key] = number;
    this.show(...this.#last);
  }

  #control(key) {
    const row = this.keys[key];
    const name = NAMES[key] ?? key;
    const id = key.replaceAll(".", "-");
    const help = element("p", { class: "help", id: `${id}-help` }, row.sentence);
    const top = element("div", { class: "top" }, element("label", { for: id }, name));
    const made = element("div", { class: "control", "data-key": key }, top);
    const standard = row.default === null || row.default === undefined ? "" : `: ${row.default}`;
    const reset = element("button", { type: "button", class: "reset", "aria-label": `${name}: back to its default`, title: `Back to the default${standard}` }, "reset");
    reset.addEventListener("click", () => this.changed(key, undefined, false));
    top.append(reset);
    this.#shown.push((effective, scene) => { reset.hidden = !(key in scene) || key === "preset"; });
    const choices = row.choices ?? [];
    const isRange = Number.isFinite(row.minimum) && Number.isFinite(row.maximum);
    if (row.kind === "boolean") this.#box(key, id, top);
    else if (isRange) this.#range(key, id, top, made, choices);
    else if (choices.length) this.#select(key, id, made, row);
    else this.#text(key, id, top);
    made.append(help);
    return made;
  }

  #box(key, id, top) {
    const box = element("input", { type: "checkbox", id, "aria-describedby": `${id}-help` });
    box.addEventListener("change", () => this.changed(key, box.checked, false));
    top.prepend(box);
    this.#shown.push((effective) => { box.checked = effective[key] === true; });
  }

  #text(key, id, top) {
    const box = element("input", { type: "text", id, size: "10", "aria-describedby": `${id}-help`, placeholder: key === "camera.size" ? "the window's" : "" });
    box.addEventListener("change", () => this.changed(key, box.value.trim() || undefined, false));
    top.append(box);
    this.#shown.push((effective, scene) => { box.value = scene[key] ?? ""; });
  }

  #select(key, id, made, { choices, choice_sentences: sentences }) {
    const select = element("select", { id, "aria-describedby": `${id}-chosen ${id}-help` }, ...choices.map((choice, i) => element("option", { value: choice, title: sentences[i] }, choice)));
    const chosen = element("p", { class: "chosen", id: `${id}-chosen` });
    select.addEventListener("change", () => this.changed(key, select.value, false));
    made.append(select, chosen);
    this.#shown.push((effective) => {
      select.value = effective[key];
      chosen.textContent = sentences[choices.indexOf(effective[key])] ?? "";
    });
  }

  #range(key, id, top, made, choices) {
    const row = this.keys[key];
    const scale = slider(row);
    const number = element("input", { type: "number", id, step: "any", min: String(row.minimum), max: String(row.maximum), "aria-describedby": `${id}-help` });
    const range = element("input", { type: "range", min: "0", max: String(STEPS), step: "1", "aria-label": NAMES[key] ?? key, "aria-describedby": `${id}-help` });
    const unit = row.unit === "degrees" ? "°" : (row.unit ?? "");
    const words = typeof row.default === "string" && !choices.length && /^\w+$/.test(row.default) ? [row.default] : choices;
    top.append(number);
    if (unit) top.append(element("span", { class: "unit" }, unit));
    made.append(range);
    number.addEventListener("change", () => this.changed(key, number.value === "" ? undefined : number.valueAsNumber, false));
    range.addEventListener("input", () => this.changed(key, scale.value(range.valueAsNumber), true));
    range.addEventListener("change", () => this.changed(key, scale.value(range.valueAsNumber), false));
    let select;
    if (words.length) {
      select = element("select", { "aria-label": `${NAMES[key] ?? key}: a word in place of a number` }, element("option", { value: "" }, "a number"), ...words.map((each) => element("option", { value: each }, each)));
      select.addEventListener("change", () => this.changed(key, select.value || scale.value(range.valueAsNumber), false));
      made.append(select);
    }
    this.#shown.push((effective) => {
      const value = effective[key];
      const isNumber = typeof value === "number";
      const found = isNumber ? undefined : this.#found[key];
      // A projection without a field of view has nothing to show here.
      made.hidden = value === null || value === undefined;
      if (select) select.value = isNumber ? "" : (value ?? "");
      number.value = isNumber ? rounded(value) : "";
      number.placeholder = found === undefined ? "" : rounded(found);
      if (!isNumber) range.value = scale.place(Math.min(row.maximum, Math.max(row.minimum, found ?? 0)));
      else if (document.activeElement !== range) range.value = scale.place(value);
      const told = isNumber ? `${rounded(value)} ${unit}` : String(value ?? "as the program chooses");
      range.setAttribute("aria-valuetext", found === undefined ? told : `${told}: ${rounded(found)} ${unit}`);
    });
  }
}
