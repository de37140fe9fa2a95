// The pictures of the manual: node manual-pictures.mjs LUTRA-SERVER [PICTURE ...], as `scripts/manual-pictures` starts it. Two
// simulated Otters sail before it; each picture is written into docs/book/src/pictures as WebP, and as PNG into target/manual-pictures
// for who looks at it with a program that knows no WebP. Judges nothing but their size.

import { mkdir, stat, writeFile } from "node:fs/promises";
import { join } from "node:path";
import { check, inBrowser, logIn } from "./browser.mjs";
import { withDemo } from "./demoserver.mjs";

const [program, ...only] = process.argv.slice(2);
const [BOOK, PLAIN, VESSEL, PATIENCE_MS] = ["docs/book/src/pictures", "target/manual-pictures", "otter-1", 60_000];
const [DESK, PHONE] = [{ width: 1200, height: 760 }, { width: 390, height: 844 }];
/** Bytes of a picture, for who reads the manual by a bad 4G. */
const MOST = 60_000;

const openVessel = async (page, tab) => {
  await page.getByRole("link", { name: `Open ${VESSEL}` }).click();
  await page.locator('[data-tile="mode"]').getByText("Executing plan").waitFor();
  if (tab) await page.getByRole("tab", { name: tab }).click();
};

/** Sends something to the API in the name of the person before the page. */
const post = async (page, path, data) => {
  const csrf = await page.evaluate(() => document.querySelector('meta[name="csrf"]').content);
  const answer = await page.request.post(new URL(path, page.url()).href, { headers: { "x-csrf-token": csrf }, data });
  check(answer.ok(), `${path}: ${answer.status()} ${await answer.text()}`);
  return answer.json();
};

/** What each picture shows; each begins at the fleet. */
const PICTURES = {
  fleet: async ({ page }) => page.locator(".vessel-card", { hasText: VESSEL }).getByText("Executing plan").waitFor(),
  vessel: async ({ page }) => openVessel(page),
  phone: async ({ page }) => openVessel(page),
  control: async ({ page }) => {
    await openVessel(page, "Control");
    await page.getByRole("button", { name: "Take control", exact: true }).click();
    await page.getByText("You have control of this vessel.").waitFor();
  },
  plan: async ({ page, url }) => {
    await page.goto(`${url}/plans`);
    await page.getByRole("button", { name: "New plan" }).click();
    await page.getByRole("button", { name: "Path", exact: true }).click();
    const box = await page.locator(".map").boundingBox();
    for (const [x, y] of [[0.35, 0.35], [0.6, 0.4], [0.6, 0.65]]) await page.locator(".map").click({ position: { x: box.width * x, y: box.height * y } });
    // What was drawn last is judged, and kept.
    await page.waitForFunction(() => /Least depth on track|Safe|Partly checked|Not safe/.test(document.body.innerText) && !/Checking|Keeping|^0 m/m.test(document.body.innerText));
  },
  detections: async ({ page, url }) => {
    await page.goto(`${url}/detections`);
    await page.getByRole("region", { name: "Detections" }).getByRole("row").nth(3).waitFor();
  },
  explorer: async ({ page, url }) => {
    await page.goto(`${url}/explore`);
    await page.getByText("Hours listened").first().waitFor();
  },
  alarms: async ({ page }) => {
    await page.locator('#alarms[data-priority="warning"], #alarms[data-priority="alarm"]').waitFor({ timeout: 4 * PATIENCE_MS });
    await page.locator("#alarms .open").click();
    await page.locator('#alarm-list [data-alarm="not_heard"]').getByText("How to recover").waitFor({ timeout: 4 * PATIENCE_MS });
  },
  mission: async ({ page, url }) => {
    const now = Date.now() * 1e3;
    const { id } = await post(page, "/api/v1/missions", { name: "Release of smolt", people: "Anna, Ole", purpose: "Follow the release for an hour", notes: "", vessels: await vessels(page), from_us: now - 3_600_000_000, to_us: now });
    await page.goto(`${url}/missions/${id}`);
    await page.getByRole("region", { name: "Summary" }).getByRole("row", { name: /^otter-1/ }).waitFor();
  },
  // Last: what is closed may be in the way of an Otter.
  "no-go": async ({ page, url }) => {
    const ring = (lat, lon) => [[lat, lon], [lat, lon + 0.012], [lat + 0.004, lon + 0.012], [lat + 0.004, lon]];
    await post(page, "/api/v1/no-go-areas", { name: "Salmon farm", reason: "Moorings just below the surface", corners: ring(63.452, 10.33) });
    await post(page, "/api/v1/no-go-areas", { name: "Nets", reason: "Set nets until 1 July", corners: ring(63.46, 10.36) });
    await page.goto(`${url}/no-go-areas`);
    await page.getByText("Salmon farm").first().waitFor();
  },
};

const vessels = async (page) => (await (await page.request.get(new URL("/api/v1/vessels", page.url()).href)).json()).filter(({ name }) => /^otter-/.test(name ?? "")).map(({ address }) => address);

/** The picture as WebP, as good as fits. */
async function packed(blank, png) {
  for (const quality of [0.85, 0.75, 0.65, 0.5, 0.4]) {
    const address = await blank.evaluate(async ({ png, quality }) => {
      const picture = await createImageBitmap(await (await fetch(`data:image/png;base64,${png}`)).blob());
      const canvas = new OffscreenCanvas(picture.width, picture.height);
      canvas.getContext("2d").drawImage(picture, 0, 0);
      const bytes = new Uint8Array(await (await canvas.convertToBlob({ type: "image/webp", quality })).arrayBuffer());
      return btoa(Array.from(bytes, (one) => String.fromCharCode(one)).join(""));
    }, { png: png.toString("base64"), quality });
    const bytes = Buffer.from(address, "base64");
    if (bytes.length <= MOST) return bytes;
  }
  throw new Error("larger than it may be at the least quality");
}

async function take({ page, blank, url, name }) {
  await page.setViewportSize(name === "phone" ? PHONE : DESK);
  await page.goto(url);
  await page.getByText("Live", { exact: true }).waitFor();
  await PICTURES[name]({ page, url });
  // Tiles of the map and plots are drawn after what was waited for.
  await page.waitForLoadState("networkidle", { timeout: 3_000 }).catch(() => undefined);
  await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
  const png = await page.screenshot({ path: join(PLAIN, `${name}.png`) });
  await writeFile(join(BOOK, `${name}.webp`), await packed(blank, png));
  const { size } = await stat(join(BOOK, `${name}.webp`));
  console.log(`${name}: ${(size / 1e3).toFixed(0)} kB`);
}

const names = Object.keys(PICTURES).filter((name) => !only.length || only.includes(name));
check(names.length === (only.length || names.length), `There are these pictures: ${Object.keys(PICTURES).join(", ")}`);
for (const folder of [BOOK, PLAIN]) await mkdir(folder, { recursive: true });
await withDemo(program, ["--otters", "2", "--cut-after", "90", "--cut-for", "40"], ({ url, password }) =>
  inBrowser(async (open) => {
    const [page, blank] = [await open(), await open()];
    page.context().setDefaultTimeout(PATIENCE_MS);
    await logIn(page, url, "admin", password);
    for (const name of names) await take({ page, blank, url, name });
  }),
);
