// The sun on a small dome, or by a place and an hour.

import { element } from "./controls.js";
import { svg } from "./plot.js";

/** Radius of the horizon on the dome; a sun below it stands outside. */
const HORIZON = 78;
/** Elevation at the rim of the dome (degrees). */
const LOWEST = -36;

const PLACES = [
  ["Tokyo", 35.68, 139.77, 9], ["Sapporo", 43.06, 141.35, 9], ["Singapore", 1.29, 103.85, 8], ["Nairobi", -1.29, 36.82, 3], ["Berlin", 52.52, 13.41, 1],
  ["London", 51.51, -0.13, 0], ["Tromsø", 69.65, 18.96, 1], ["New York", 40.71, -74.01, -5], ["Quito", -0.18, -78.47, -5], ["Sydney", -33.87, 151.21, 10],
  ["South Pole", -90, 0, 0],
];
/** Minutes of the day that pass in a second of play. */
const PACE = 40;

const byId = (id) => document.getElementById(id);

/** The sky above as one sees it lying on one's back with north on top: east is on the left. */
export class Dome {
  constructor(changed, settle) {
    this.home = byId("dome");
    this.home.append(svg("circle", { class: "ground", r: 112 }), svg("circle", { class: "horizon", r: HORIZON }), svg("circle", { r: HORIZON / 3 }), svg("circle", { r: (2 * HORIZON) / 3 }));
    for (const [name, x, y] of [["N", 0, -92], ["E", -92, 0], ["S", 0, 92], ["W", 92, 0]]) this.home.append(svg("text", { x, y }, name));
    this.sun = this.home.appendChild(svg("circle", { class: "sun", r: 8 }));
    const move = (event) => {
      const point = new DOMPoint(event.clientX, event.clientY).matrixTransform(this.home.getScreenCTM().inverse());
      const elevation = Math.max(LOWEST, 90 - (90 * Math.hypot(point.x, point.y)) / HORIZON);
      changed({ elevation, azimuth: ((Math.atan2(-point.x, -point.y) * 180) / Math.PI + 360) % 360 }, true);
    };
    this.home.addEventListener("pointerdown", (event) => { this.home.setPointerCapture(event.pointerId); move(event); });
    this.home.addEventListener("pointermove", (event) => this.home.hasPointerCapture(event.pointerId) && move(event));
    this.home.addEventListener("pointerup", settle);
  }

  show({ elevation, azimuth }) {
    const radius = (HORIZON * (90 - Math.max(LOWEST, elevation))) / 90;
    const angle = (azimuth * Math.PI) / 180;
    this.sun.setAttribute("cx", -radius * Math.sin(angle));
    this.sun.setAttribute("cy", -radius * Math.cos(angle));
  }
}

const digits = (value) => String(value).padStart(2, "0");

/** RFC 3339, to the minute. */
function instant(date, minutes, offset) {
  const away = Math.abs(Math.round(offset * 60));
  return `${date}T${digits(Math.floor(minutes / 60))}:${digits(minutes % 60)}:00${offset < 0 ? "-" : "+"}${digits(Math.floor(away / 60))}:${digits(away % 60)}`;
}

/** A place on the Earth, a date and a day's slider. */
export class Place {
  #playing = false;

  /** `hands.set(keys, following)` takes place and time, `hands.angles()` goes back to the sun's angles, `hands.idle()` is when the last picture is done. */
  constructor(hands) {
    this.hands = hands;
    byId("place").append(element("option", { value: "" }, "By its coordinates"), ...PLACES.map(([name]) => element("option", { value: name }, name)));
    byId("place").value = PLACES[0][0];
    byId("date").value = `${new Date().getFullYear()}-06-21`;
    byId("hour").value = "1080";
    this.#choose();
    for (const box of document.getElementsByName("sun-by")) {
      box.addEventListener("change", () => {
        if (!box.checked) return;
        if (box.value === "place") this.#set(false);
        else { this.#stop(); hands.angles(); }
      });
    }
    byId("place").addEventListener("change", () => { this.#choose(); this.#set(false); });
    for (const id of ["latitude", "longitude", "date", "offset"]) byId(id).addEventListener("change", () => this.#set(false));
    byId("hour").addEventListener("input", () => this.#set(true));
    byId("hour").addEventListener("change", () => this.#set(false));
    byId("play").addEventListener("click", () => (this.#playing ? this.#stop() : this.#play()));
  }

  #choose() {
    const chosen = PLACES.find(([name]) => name === byId("place").value);
    if (chosen) [byId("latitude").value, byId("longitude").value, byId("offset").value] = chosen.slice(1).map(String);
  }

  #set(following) {
    const [latitude, longitude, offset] = ["latitude", "longitude", "offset"].map((id) => byId(id).value);
    this.hands.set({ "sun.place": `${latitude},${longitude}`, "sun.time": instant(byId("date").value, byId("hour").valueAsNumber, Number(offset)) }, following);
  }

  async #play() {
    this.#playing = true;
    this.#button();
    let last = performance.now();
    while (this.#playing) {
      const now = await new Promise(requestAnimationFrame);
      // Who stops in between has asked for the last picture already.
      if (!this.#playing) return;
      const minutes = Math.floor(((now - last) / 1000) * PACE);
      if (minutes < 1) continue;
      last = now;
      byId("hour").value = String((byId("hour").valueAsNumber + minutes) % 1440);
      this.#set(true);
      await this.hands.idle();
    }
  }

  #stop() {
    if (!this.#playing) return;
    this.#playing = false;
    this.#button();
    if (byId("by-angles").hidden) this.#set(false);
  }

  #button() {
    byId("play").setAttribute("aria-pressed", String(this.#playing));
    byId("play").textContent = this.#playing ? "Stop" : "Play the day";
  }

  show(scene) {
    const isPlaced = "sun.place" in scene;
    byId("by-angles").hidden = isPlaced;
    byId("by-place").hidden = !isPlaced;
    for (const box of document.getElementsByName("sun-by")) box.checked = (box.value === "place") === isPlaced;
    if (!isPlaced) { this.#playing = false; this.#button(); return; }
    this.#fill(scene);
    const minutes = byId("hour").valueAsNumber;
    byId("hour-text").textContent = `${digits(Math.floor(minutes / 60))}:${digits(minutes % 60)}`;
    byId("hour").setAttribute("aria-valuetext", byId("hour-text").textContent);
  }

  #fill(scene) {
    const [latitude, longitude] = String(scene["sun.place"]).split(",").map((part) => part.trim());
    const time = /^(\d{4}-\d\d-\d\d)T(\d\d):(\d\d)(?::\d\d(?:\.\d+)?)?(?:Z|([-+])(\d\d):(\d\d))$/i.exec(scene["sun.time"] ?? "");
    byId("latitude").value = latitude;
    byId("longitude").value = longitude;
    byId("place").value = PLACES.find((place) => String(place[1]) === latitude && String(place[2]) === longitude)?.[0] ?? "";
    if (!time) return;
    byId("date").value = time[1];
    byId("hour").value = String(Number(time[2]) * 60 + Number(time[3]));
    byId("offset").value = String((time[4] === "-" ? -1 : 1) * (Number(time[5] ?? 0) + Number(time[6] ?? 0) / 60));
  }
}
