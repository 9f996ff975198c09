// Seven steps. Each sets a scene, perhaps a second one on the left, and says what is to be seen.

const ahead = { "camera.projection": "perspective", "camera.fov": 100, "camera.look_azimuth": 0, "camera.look_elevation": 20 };
const lowSun = { ...ahead, "sun.elevation": 1.5, "sun.azimuth": 0, "render.exposure": -2.5 };
const twilight = { ...ahead, "sun.elevation": -4, "sun.azimuth": 0, "render.exposure": 2.5 };

export const steps = [
  {
    title: "Why the sky is blue",
    text: [
      "Away from the sun you see only light that the air has scattered. Molecules are far smaller than the wavelength, and scatter nearly as its inverse fourth power: light of 430 nm about seven times as much as light of 700 nm.",
      "The plot shows it: beside the sun's own spectrum, that of the sky leans to the short side. It is blue rather than violet because the sun sends less violet, and the eye sees little of it.",
    ],
    scene: { ...ahead, "sun.elevation": 45, "sun.azimuth": 180, "camera.look_elevation": 25 },
    measured: { azimuth: 0, elevation: 50 },
  },
  {
    title: "Why the sunset is red",
    text: [
      "At the horizon sunlight crosses some thirty times as much air as from the zenith. The blue is scattered out of it on the way; what arrives, and what is scattered again near the sun, is orange and red.",
      "Haze takes out more at every wavelength, and sends it forward, into a glow around the sun.",
    ],
    scene: { ...lowSun, "sun.disc": true },
    measured: { azimuth: 0, elevation: 6 },
  },
  {
    title: "Blue again, by ozone",
    text: [
      "When the sun has set, the sky overhead is lit by light that crossed the ozone layer on a long slant. Ozone absorbs orange and yellow there, in the Chappuis bands around 600 nm, and so the twilight is blue.",
      "On the left the same air without ozone: scattering alone would leave it the colour of straw. Move the divider.",
    ],
    scene: twilight,
    beside: { ...twilight, "atmosphere.ozone.column": 0 },
    measured: { azimuth: 20, elevation: 50 },
  },
  {
    title: "What four wavelengths are enough for",
    text: [
      "Nothing here computes forty or eighty wavelengths for each pixel. Scattering and absorption change smoothly with the wavelength, so four, with a regression on the scene's own rays, foretell the others.",
      "The map shows how far the colours are from those of the dense integral over every wavelength. Its scale is below.",
    ],
    scene: { ...ahead, "sun.elevation": 20, "sun.azimuth": 40, "render.fit": "regression" },
    errors: "regression",
  },
  {
    title: "What a cubic does to a sunset",
    text: [
      "An older way draws a cubic in the wavelength through the radiance at four wavelengths. It cannot follow the lines of the sun's spectrum, the bands of ozone, or the steep slope that a long way through air leaves.",
      "On the left the cubic, on the right every wavelength: a sunset turns greenish where it should be violet grey.",
    ],
    scene: { ...lowSun, "render.fit": "dense" },
    beside: { ...lowSun, "render.fit": "cubic" },
  },
  {
    title: "What the second scattering adds",
    text: [
      "On the left light that was scattered once, on the right up to twice, at the same exposure. The second order brightens the zenith by a quarter here, by a sixth with the sun at 45°, and makes it bluer: blue light is the likeliest to be scattered again.",
      "After sunset it matters most low down: air in the shadow of the Earth gets no sunlight, only light from the rest of the sky. Choose “all” to see what further orders add.",
    ],
    scene: { ...twilight, "sun.elevation": -3, "render.exposure": 1, "render.orders": 2 },
    beside: { ...twilight, "sun.elevation": -3, "render.exposure": 1, "render.orders": 1 },
    measured: { azimuth: 20, elevation: 3 },
  },
  {
    title: "Mars",
    text: [
      "The air of Mars is so thin that molecules hardly scatter. Its sky is dust, whose grains are as large as the wavelength and scatter all colours alike, but absorb blue: the sky is butterscotch by day.",
      "The blue glow that surrounds the low sun there is missing here. It needs a forward peak narrower in blue than in red, and this model has one asymmetry for all wavelengths.",
    ],
    scene: { ...ahead, "preset": "mars", "sun.elevation": 35, "sun.azimuth": 60 },
    measured: { azimuth: 0, elevation: 20 },
  },
];

const byId = (id) => document.getElementById(id);

/** Leads through the steps. `show(step)` sets the page to a step. */
export class Tour {
  #at = 0;

  constructor(show) {
    this.show = show;
    byId("tour-next").addEventListener("click", () => (this.#at + 1 < steps.length ? this.go(this.#at + 1) : this.#leave()));
    byId("tour-back").addEventListener("click", () => this.go(this.#at - 1));
    byId("tour-close").addEventListener("click", () => this.#leave());
  }

  go(number) {
    this.#at = number;
    const { title, text, ...rest } = steps[number];
    byId("tour").hidden = false;
    byId("tour-title").textContent = title;
    byId("tour-text").replaceChildren(...text.map((sentences) => {
      const paragraph = document.createElement("p");
      paragraph.textContent = sentences;
      return paragraph;
    }));
    byId("tour-count").textContent = `${number + 1} of ${steps.length}`;
    byId("tour-back").disabled = number === 0;
    byId("tour-next").textContent = number + 1 < steps.length ? "Next" : "Finish";
    byId("tour-title").focus({ preventScroll: true });
    this.show(rest);
  }

  #leave() {
    byId("tour").hidden = true;
    byId("tour-start").focus();
  }
}
