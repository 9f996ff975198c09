// What takes long, off the page: pictures, spectra, error maps and files.

import init, * as sorairo from "./sorairo.js";

let studio;

const calls = {
  async open(module, device) {
    await init({ module_or_path: module });
    studio = await sorairo.Studio.open(device);
    return { device: studio.device, isGpu: studio.is_gpu, whyNotGpu: studio.why_not_gpu };
  },
  async picture(toml) {
    const pixels = await studio.picture(toml);
    return { pixels, device: studio.device, isGpu: studio.is_gpu, whyNotGpu: studio.why_not_gpu };
  },
  png: (toml) => studio.png(toml),
  exr: (toml) => studio.exr(toml),
  spectrum: (toml, azimuth, elevation) => sorairo.spectrum(toml, azimuth, elevation),
  errors: (toml, fit) => ({ pixels: sorairo.errors(toml, fit), scale: sorairo.errors_scale() }),
};

// One after another: the device serves one request at a time, and the page asks for the next only when it knows the last.
let queue = Promise.resolve();
self.onmessage = ({ data: { id, name, parameters } }) => {
  queue = queue.then(async () => {
    try {
      const value = await calls[name](...parameters);
      const bytes = value?.pixels ?? value;
      self.postMessage({ id, value }, bytes instanceof Uint8Array ? [bytes.buffer] : []);
    } catch (error) {
      // A sentence is a complaint; anything else has left the instance in an unknown state.
      const dead = typeof error !== "string";
      self.postMessage({ id, error: dead ? String(error?.message ?? error) : error, dead });
    }
  });
};
