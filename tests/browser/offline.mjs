// Pages that are opened while the server is not reached: node offline.mjs URL ONE-TIME-PASSWORD.

import { check, inBrowser, logIn, look } from "./browser.mjs";
import { wayTo } from "./hole.mjs";

const [server, oneTime] = process.argv.slice(2);
const BOAT = 2068;

await inBrowser(async (open) => {
  let way = await wayTo(server);
  const { url } = way;
  const page = await open({ serviceWorkers: "allow" });
  await logIn(page, url, "admin", oneTime, "battery horse staple");
  await page.goto(`${url}/vessels/${BOAT}`);
  await page.getByText("Live", { exact: true }).waitFor();
  await page.evaluate(() => navigator.serviceWorker.ready);

  // It can be put on a home screen: a manifest with pictures that are there.
  const manifest = await (await page.request.get(`${url}/manifest.webmanifest`)).json();
  check(manifest.name === "Lutra" && manifest.display === "standalone", JSON.stringify(manifest));
  for (const { src, sizes } of manifest.icons) {
    const size = await page.evaluate(async (src) => {
      const { width, height } = await createImageBitmap(await (await fetch(src)).blob());
      return `${width}x${height}`;
    }, src);
    check(size === sizes, `${src} is ${size}`);
  }

  // Nothing is reached: the page says so, also of STOP, tells no values, and looks like the others.
  way.close();
  await page.goto(`${url}/vessels/${BOAT}`);
  await page.getByRole("heading", { name: "No link to the server" }).waitFor();
  await page.getByText("STOP cannot be sent from here.").waitFor();
  check((await page.locator("[data-tile], .map, #stop").count()) === 0, "no value, no map and no button that works");
  const kept = await page.evaluate(async () => (await Promise.all((await caches.keys()).map(async (name) => (await (await caches.open(name)).keys()).map(({ url }) => new URL(url).pathname)))).flat());
  check(kept.length === 3 && kept.includes("/offline") && kept.every((path) => /^\/(offline|static\/(main-\w+\.css|offline-\w+\.js))$/.test(path)), `kept: ${kept}`);
  await look(page, "offline");

  // The server is reached again: the page that was asked for comes by itself.
  way = await wayTo(server, Number(new URL(url).port));
  await page.getByText("Live", { exact: true }).waitFor();
  check(new URL(page.url()).pathname === `/vessels/${BOAT}`, page.url());
  way.close();
});
