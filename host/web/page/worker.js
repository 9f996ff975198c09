// What takes long, off the page: pictures, spectra, error maps and files.

import init, * as sorairo from "./sorairo.js";

/** What computes, and the processor for the first glimpse: a GPU compiles its kernels before it draws anything. */
let device, studio, glimpse;

async function opened() {
  studio ??= await sorairo.Studio.open(device);
  return studio;
}

const calls = {
  async open(module, name) {
    await init({ module_or_path: module });
    device = name;
    glimpse = await sorairo.Studio.open("cpu");
  },
  async picture(toml, isGlimpse) {
    if (isGlimpse && !studio) return { bitmap: await glimpse.bitmap(toml) };
    const bitmap = await (await opened()).bitmap(toml);
    return { bitmap, exposure: sorairo.exposure(toml), device: studio.device, isGpu: studio.is_gpu, whyNotGpu: studio.why_not_gpu };
  },
  png: async (toml) => (await opened()).png(toml),
  exr: async (toml) => (await opened()).exr(toml),
  spectrum: (toml, azimuth, elevation) => sorairo.spectrum(toml, azimuth, elevation),
  errors: (toml, fit) => ({ pixels: sorairo.errors(toml, fit), scale: sorairo.errors_scale() }),
};

// One after another: the device serves one request at a time, and the page asks for the next only when it knows the last.
let queue = Promise.resolve();
self.onmessage = ({ data: { id, name, parameters } }) => {
  queue = queue.then(async () => {
    try {
      const value = await calls[name](...parameters);
      const large = value?.bitmap ?? (value?.pixels ?? value)?.buffer;
      self.postMessage({ id, value }, large ? [large] : []);
    } catch (error) {
      // A sentence is a complaint; anything else has left the instance in an unknown state.
      const dead = typeof error !== "string";
      self.postMessage({ id, error: dead ? String(error?.message ?? error) : error, dead });
    }
  });
};
