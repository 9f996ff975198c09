// The strip of the day below the sky: a click on a picture of it sets the sun.

import { element } from "./controls.js";
import { show } from "./view.js";

/** Longer side of a picture (pixels). */
const LONGER_SIDE = 128;

export class Strip {
  #home = document.getElementById("strip"); #chosen; #wanted; #moments = [];

  /** `chosen(moment)` hears a click. */
  constructor(chosen) {
    this.#chosen = chosen;
  }

  /** Whether a window has room for it. */
  get isSeen() { return this.#home.offsetParent !== null; }

  /** Shows the moments of a sky that is seen in a size; `sky` tells it from others, and `draw(moment, size)` promises the picture of a moment. */
  async want(sky, moments, [width, height], draw) {
    if (this.#wanted === sky) return;
    this.#wanted = sky;
    this.#moments = moments;
    this.#home.dataset.state = "drawing";
    const scale = LONGER_SIDE / Math.max(width, height);
    const size = [width, height].map((side) => Math.max(1, Math.round(side * scale)));
    // The pictures of the day before stay until those of this one come.
    if (this.#home.children.length !== moments.length) this.#home.replaceChildren(...moments.map(() => this.#frame()));
    for (const [i, moment] of moments.entries()) this.#home.children[i].querySelector("span").textContent = moment.label;
    for (const [i, moment] of moments.entries()) {
      const bitmap = await draw(moment, size);
      if (this.#wanted !== sky) return bitmap.close();
      show(this.#home.children[i].querySelector("canvas"), bitmap);
    }
    this.#home.dataset.state = "done";
  }

  #frame() {
    const made = element("button", { type: "button" }, element("canvas", { "aria-hidden": "true", width: 2, height: 1 }), element("span"));
    made.addEventListener("click", () => this.#chosen(this.#moments[[...this.#home.children].indexOf(made)]));
    return made;
  }

  /** Marks the moment at which the sun stands where it is. */
  mark({ elevation, azimuth }) {
    const near = (one, other) => Math.abs(one - other) < 0.01;
    for (const [i, moment] of this.#moments.entries()) {
      const isNow = near(moment.elevation, elevation) && near(moment.azimuth, azimuth);
      this.#home.children[i].setAttribute("aria-pressed", String(isNow));
    }
  }
}
