// The picture and what a hand does on it: look around, zoom, move the sun, measure, divide.

const RADIANS = Math.PI / 180;
/** How far a pointer moves before a click becomes a drag (CSS pixels). */
const STILL = 5;

/** Whether a projection shows the whole sphere, in which nobody looks around. */
export const isWhole = (projection) => projection === "equirectangular" || projection === "octahedral";

/** Where a direction (degrees) stands in the picture, in parts of its width and height from the top left; null where it is not in sight. */
export function project(camera, { azimuth, elevation }) {
  const [e, a] = [elevation * RADIANS, azimuth * RADIANS];
  if (camera.projection === "equirectangular") {
    const turn = (((azimuth + 180) % 360) + 360) % 360;
    return { x: turn / 360, y: 0.5 - elevation / 180 };
  }
  if (camera.projection === "octahedral") {
    const [east, north, up] = [Math.cos(e) * Math.sin(a), Math.cos(e) * Math.cos(a), Math.sin(e)];
    const sum = Math.abs(east) + Math.abs(north) + Math.abs(up);
    const unfolded = (part) => (part + (part < 0 ? -1 : 1) * Math.max(0, -up)) / sum;
    return { x: 0.5 + unfolded(east) / 2, y: 0.5 - unfolded(north) / 2 };
  }
  const [le, la] = [camera.lookElevation * RADIANS, camera.lookAzimuth * RADIANS];
  const d = [Math.cos(e) * Math.cos(a), Math.cos(e) * Math.sin(a), Math.sin(e)];
  const dot = (v) => v[0] * d[0] + v[1] * d[1] + v[2] * d[2];
  const forward = dot([Math.cos(le) * Math.cos(la), Math.cos(le) * Math.sin(la), Math.sin(le)]);
  const right = dot([-Math.sin(la), Math.cos(la), 0]);
  const up = dot([-Math.sin(le) * Math.cos(la), -Math.sin(le) * Math.sin(la), Math.cos(le)]);
  const half = (camera.fov / 2) * RADIANS;
  const { width, height } = camera;
  let position;
  if (camera.projection === "fisheye") {
    const angle = Math.acos(Math.min(1, Math.max(-1, forward)));
    const sine = Math.hypot(right, up);
    if (angle > half) return null;
    const radius = (angle / half) * (Math.min(width, height) / 2);
    position = sine > 0 ? [(right / sine) * radius, (up / sine) * radius] : [0, 0];
  } else {
    if (forward <= 0) return null;
    const scale = width / 2 / Math.tan(half) / forward;
    position = [right * scale, up * scale];
  }
  const [x, y] = [0.5 + position[0] / width, 0.5 - position[1] / height];
  return x >= 0 && x <= 1 && y >= 0 && y <= 1 ? { x, y } : null;
}

/** What a camera looks at, from the directions of three pixels of its picture of three by three: the centre, the one above, the one beside. */
export function lookOf(centre, above, beside, projection) {
  const unit = ({ azimuth, elevation }) => [Math.cos(elevation * RADIANS) * Math.cos(azimuth * RADIANS), Math.cos(elevation * RADIANS) * Math.sin(azimuth * RADIANS), Math.sin(elevation * RADIANS)];
  const [a, b] = [unit(centre), unit(beside)];
  const angle = Math.acos(Math.min(1, a[0] * b[0] + a[1] * b[1] + a[2] * b[2]));
  const half = projection === "fisheye" ? 1.5 * angle : Math.atan(1.5 * Math.tan(angle));
  // Straight up and down the azimuth is that of the picture's upper or lower edge.
  const isUpright = Math.abs(centre.elevation) < 89.9;
  const azimuth = isUpright ? centre.azimuth : above.azimuth + (centre.elevation > 0 ? 180 : 0);
  return { "camera.fov": (2 * half) / RADIANS, "camera.look_azimuth": ((azimuth + 540) % 360) - 180, "camera.look_elevation": centre.elevation };
}

function place(marker, position) {
  marker.hidden = !position;
  if (!position) return;
  marker.style.left = `${100 * position.x}%`;
  marker.style.top = `${100 * position.y}%`;
}

/** Shows a picture on a canvas, which takes its size. The pixels stay on the device that drew them. */
export function show(canvas, bitmap) {
  canvas.width = bitmap.width;
  canvas.height = bitmap.height;
  canvas.getContext("bitmaprenderer").transferFromImageBitmap(bitmap);
  canvas.hidden = false;
}

/** Paints RGBA pixels on a canvas. */
export function paint(canvas, pixels, [width, height]) {
  canvas.width = width;
  canvas.height = height;
  canvas.getContext("2d").putImageData(new ImageData(new Uint8ClampedArray(pixels.buffer, pixels.byteOffset, pixels.length), width, height), 0, 0);
  canvas.hidden = false;
}

/** The element with the pictures. `hands` has `look(right, up, following)` and `zoom(factor, following)` in parts of the field of view,
 * `sun(position, following)`, `measure(position)`, and `settle()`, which ends what followed a hand. */
export class View {
  constructor(hands) {
    this.frame = document.getElementById("frame");
    this.marker = document.getElementById("sun-marker");
    this.probe = document.getElementById("probe");
    this.divider = document.getElementById("divider");
    this.hands = hands;
    this.#pointers();
    this.#keys();
    this.#divide();
  }

  /** The size of the window's room (CSS pixels). */
  get room() {
    const { clientWidth, clientHeight } = document.getElementById("view");
    return [Math.max(1, clientWidth), Math.max(1, clientHeight)];
  }

  /** Fits a picture of that size into the room, as large as it can be. */
  fit([width, height]) {
    const [across, down] = this.room;
    const scale = Math.min(across / width, down / height);
    this.frame.style.width = `${Math.round(width * scale)}px`;
    this.frame.style.height = `${Math.round(height * scale)}px`;
  }

  mark(camera, sun, measured) {
    place(this.marker, project(camera, sun));
    place(this.probe, measured && project(camera, measured));
  }

  #position(event) {
    const box = this.frame.getBoundingClientRect();
    return { x: (event.clientX - box.left) / box.width, y: (event.clientY - box.top) / box.height };
  }

  #pointers() {
    const { frame } = this;
    const fingers = new Map();
    let begin = null;
    let spread = 0;
    frame.addEventListener("pointerdown", (event) => {
      if (event.target === this.divider || event.button > 0) return;
      frame.setPointerCapture(event.pointerId);
      fingers.set(event.pointerId, event);
      begin = { event, sun: event.target === this.marker, moved: false };
      if (fingers.size === 2) spread = distance(fingers);
    });
    frame.addEventListener("pointermove", (event) => {
      const last = fingers.get(event.pointerId);
      if (!last) return;
      fingers.set(event.pointerId, event);
      begin.moved ||= Math.hypot(event.clientX - begin.event.clientX, event.clientY - begin.event.clientY) > STILL;
      if (!begin.moved) return fingers.set(event.pointerId, last);
      if (fingers.size === 2) {
        const now = distance(fingers);
        this.hands.zoom(spread / now, true);
        spread = now;
      } else if (begin.sun) {
        this.hands.sun(this.#position(event), true);
      } else {
        this.hands.look((last.clientX - event.clientX) / frame.clientWidth, (event.clientY - last.clientY) / frame.clientWidth, true);
      }
    });
    const end = (event) => {
      if (!fingers.delete(event.pointerId) || fingers.size) return;
      if (begin.moved) this.hands.settle();
      else if (event.type === "pointerup") this.hands.measure(this.#position(event));
    };
    frame.addEventListener("pointerup", end);
    frame.addEventListener("pointercancel", end);
    frame.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.hands.zoom(Math.exp(event.deltaY / 800), true);
      clearTimeout(this.wheel);
      this.wheel = setTimeout(() => this.hands.settle(), 250);
    }, { passive: false });
  }

  #keys() {
    const moves = { ArrowLeft: [-0.05, 0], ArrowRight: [0.05, 0], ArrowUp: [0, 0.05], ArrowDown: [0, -0.05] };
    this.frame.addEventListener("keydown", (event) => {
      if (event.target !== this.frame || event.ctrlKey || event.altKey || event.metaKey) return;
      if (moves[event.key]) this.hands.look(...moves[event.key], false);
      else if (event.key === "+" || event.key === "=") this.hands.zoom(1 / 1.15, false);
      else if (event.key === "-") this.hands.zoom(1.15, false);
      else if (event.key === "Enter" || event.key === " ") this.hands.measure({ x: 0.5, y: 0.5 });
      else return;
      event.preventDefault();
    });
  }

  /** Puts the divider there, in parts of the width. */
  divide(part) {
    const percent = Math.min(100, Math.max(0, 100 * part));
    this.divider.style.left = `${percent}%`;
    this.divider.setAttribute("aria-valuenow", Math.round(percent));
    this.frame.style.setProperty("--divided", `${percent}%`);
  }

  /** Puts the divider where both skies can be seen beside the cards. */
  divideVisibly() {
    const [frame, cards] = [this.frame.getBoundingClientRect(), document.getElementById("cards").getBoundingClientRect()];
    const isBeside = cards.height > 0 && cards.top < frame.bottom && cards.right < frame.left + 0.75 * frame.width;
    const from = isBeside ? Math.max(0, cards.right - frame.left) : 0;
    this.divide((from + frame.width) / 2 / frame.width);
  }

  #divide() {
    const { divider } = this;
    this.divide(0.5);
    divider.addEventListener("pointerdown", (event) => divider.setPointerCapture(event.pointerId));
    divider.addEventListener("pointermove", (event) => divider.hasPointerCapture(event.pointerId) && this.divide(this.#position(event).x));
    divider.addEventListener("keydown", (event) => {
      const step = { ArrowLeft: -0.02, ArrowRight: 0.02, Home: -1, End: 1 }[event.key];
      if (!step) return;
      event.preventDefault();
      this.divide(Number(divider.getAttribute("aria-valuenow")) / 100 + step);
    });
  }
}

function distance(fingers) {
  const [a, b] = [...fingers.values()];
  return Math.max(1, Math.hypot(a.clientX - b.clientX, a.clientY - b.clientY));
}
