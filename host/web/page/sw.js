// Keeps the page for when there is no network. With a network the newest files come first.

const KEPT = "sorairo";
const FILES = [
  "./", "index.html", "style.css", "main.js", "scene.js", "view.js", "controls.js", "plot.js", "tour.js", "sun.js", "strip.js", "readout.js", "renderer.js", "worker.js",
  "sorairo.js", "sorairo_bg.wasm",
];

self.addEventListener("install", (event) => {
  event.waitUntil(caches.open(KEPT).then((cache) => cache.addAll(FILES)).then(() => self.skipWaiting()));
});

self.addEventListener("activate", (event) => event.waitUntil(self.clients.claim()));

async function newest(request) {
  try {
    const response = await fetch(request);
    if (response.ok) {
      const copy = response.clone();
      caches.open(KEPT).then((cache) => cache.put(request, copy));
    }
    return response;
  } catch (error) {
    const kept = await caches.match(request, { ignoreSearch: true });
    if (kept) return kept;
    throw error;
  }
}

self.addEventListener("fetch", (event) => {
  if (event.request.method === "GET" && event.request.url.startsWith(self.registration.scope)) event.respondWith(newest(event.request));
});
