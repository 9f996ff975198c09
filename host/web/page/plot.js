// A spectrum beside that of the sun.

const SVG = "http://www.w3.org/2000/svg";
const [WIDTH, HEIGHT] = [360, 170];
const [LEFT, RIGHT, TOP, BOTTOM] = [44, 8, 8, 20];

export function svg(tag, attributes = {}, text = "") {
  const made = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.textContent = text;
  return made;
}

/** 1, 2 or 5 times a power of ten, at least a third of the largest value. */
function step(largest) {
  const power = 10 ** Math.floor(Math.log10(largest / 3));
  return power * ([1, 2, 5, 10].find((times) => times * power >= largest / 3) ?? 10);
}

/** Draws spectra over their wavelengths (nm): the sky's in its unit; the sun's, and that of the left sky, beside it. */
export function plot(wavelengths, sky, sun, left, unit) {
  const picture = svg("svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img" });
  const [first, last] = [wavelengths[0], wavelengths.at(-1)];
  const x = (wavelength) => LEFT + ((wavelength - first) / (last - first)) * (WIDTH - LEFT - RIGHT);
  const largest = Math.max(...sky, ...(left ?? []), Number.MIN_VALUE);
  const y = (value, top) => HEIGHT - BOTTOM - (Math.max(0, value) / top) * (HEIGHT - TOP - BOTTOM);
  const line = (values, top, name) => picture.append(svg("polyline", { class: name, points: values.map((value, i) => `${x(wavelengths[i]).toFixed(1)},${y(value, top).toFixed(1)}`).join(" ") }));
  for (let value = 0; value <= largest; value += step(largest)) {
    picture.append(svg("line", { class: "axis", x1: LEFT, x2: WIDTH - RIGHT, y1: y(value, largest), y2: y(value, largest) }));
    picture.append(svg("text", { x: LEFT - 4, y: y(value, largest) + 3, "text-anchor": "end" }, Number(value.toPrecision(2)).toString()));
  }
  for (let wavelength = Math.ceil(first / 100) * 100; wavelength <= last; wavelength += 100) {
    picture.append(svg("line", { class: "axis", x1: x(wavelength), x2: x(wavelength), y1: TOP, y2: HEIGHT - BOTTOM }));
    picture.append(svg("text", { x: x(wavelength), y: HEIGHT - 6, "text-anchor": "middle" }, `${wavelength} nm`));
  }
  line(sun, Math.max(...sun), "sun");
  if (left) line(left, largest, "left-sky");
  line(sky, largest, "sky");
  const peak = wavelengths[sky.indexOf(Math.max(...sky))];
  picture.setAttribute("aria-label", `Spectrum of the sky in ${unit}, largest at ${peak} nm, beside that of the sun`);
  return picture;
}
