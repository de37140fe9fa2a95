// What answers when a page is opened and the server is not reached: a page that says so, and nothing else. It keeps no
// values and no page of a vessel, which would look like the present.

/** Addresses of the page's style and script, put in when this is bundled, so that new ones make a new worker. */
declare const PARTS: readonly string[];
declare const self: ServiceWorkerGlobalScope;
const OFFLINE = "/offline";
const KEPT = `lutra ${PARTS.join(" ")}`;

self.addEventListener("install", (event) => {
  event.waitUntil(
    caches
      .open(KEPT)
      .then((kept) => kept.addAll([OFFLINE, ...PARTS]))
      .then(() => self.skipWaiting()),
  );
});

self.addEventListener("activate", (event) => {
  const old = caches.keys().then((names) => Promise.all(names.filter((name) => name !== KEPT).map((name) => caches.delete(name))));
  event.waitUntil(old.then(() => self.clients.claim()));
});

self.addEventListener("fetch", (event) => {
  const { request } = event;
  // What is asked of the server otherwise fails as it does without a worker, and the page says so.
  const kept = request.mode === "navigate" ? OFFLINE : PARTS.find((path) => path === new URL(request.url).pathname);
  if (request.method !== "GET" || !kept) return;
  event.respondWith(fetch(request).catch(async (error: unknown) => (await caches.match(kept)) ?? Promise.reject(error)));
});

// A notification of an alarm leads to the page that told it.
self.addEventListener("notificationclick", (event) => {
  event.notification.close();
  const lead = async (): Promise<void> => {
    const open = await self.clients.matchAll({ type: "window" });
    const page = open.find(({ url }) => url === event.notification.data) ?? open[0];
    await (page ? page.focus() : self.clients.openWindow(String(event.notification.data)));
  };
  event.waitUntil(lead());
});

export {};
