// How fast the pages are: node bench-pages.mjs URL ONE-TIME-PASSWORD VESSEL VESSELS FROM TO [SECTION...], as
// `cargo bench -p server --bench pages` starts it, which also hears when the fleet is to sail. VESSEL has samples from
// FROM to TO (µs); there are VESSELS in all. BENCH_SECONDS says how long each movement is watched, BENCH_ACTS how many
// page changes, tabs and zooms stand for an hour. The section `watch`, which runs only when it is named, leaves live pages
// alone for LUTRA_HOUR_S seconds by the clock, 3600 when that is not given.

import { inBrowser, logIn } from "./browser.mjs";
import { benchChart } from "./bench-chart.mjs";
import { frames, panning, smooth, verdict } from "./bench-frames.mjs";
import { benchHour, watchHour } from "./bench-hour.mjs";
import { benchPlot, benchRawPlot } from "./bench-plot.mjs";

const [url, oneTime, vessel, vessels, from, to, ...wanted] = process.argv.slice(2);
const seconds = Number(process.env.BENCH_SECONDS ?? 6);
const acts = Number(process.env.BENCH_ACTS ?? 600);
const RUNS = 5;

/** What the first page takes after the login, in an empty browser each time. */
async function benchFirstPage(open, state) {
  const paints = [];
  let weight;
  for (let run = 0; run < RUNS; run++) {
    const page = await open({ storageState: state });
    weight = await weighed(page, async () => {
      await page.addInitScript(() => {
        new PerformanceObserver((list) => (window.benchPaint = list.getEntries().at(-1).startTime)).observe({ type: "largest-contentful-paint", buffered: true });
      });
      await page.goto(url);
      await page.getByText("Live", { exact: true }).waitFor();
      await page.waitForFunction((count) => document.querySelectorAll(".systems > li").length >= count, Number(vessels));
      await page.waitForLoadState("networkidle");
    });
    paints.push(await page.evaluate(() => window.benchPaint));
    await page.context().close();
  }
  const kB = (bytes) => `${(bytes / 1024).toFixed(0)} kB`;
  const { parts, total } = weight;
  const own = (parts.Document ?? 0) + (parts.Script ?? 0) + (parts.Stylesheet ?? 0) + (parts.Other ?? 0);
  verdict("first page, all of it over the wire", kB(own), "200 kB", own <= 200 * 1024);
  console.log(`  ${Object.entries(parts).map(([kind, bytes]) => `${kind.toLowerCase()} ${kB(bytes)}`).join(", ")}; with chart tiles and tracks of ${vessels} vessels ${kB(total)}`);
  paints.sort((one, other) => one - other);
  verdict("largest contentful paint of the first page", `${paints[RUNS >> 1].toFixed(0)} ms, most of ${RUNS} ${paints.at(-1).toFixed(0)} ms`, "1000 ms", paints.at(-1) <= 1_000);
}

/** Bytes that came while `work` was done, by what they are. */
async function weighed(page, work) {
  const cdp = await page.context().newCDPSession(page);
  const kinds = new Map();
  const parts = {};
  let total = 0;
  await cdp.send("Network.enable");
  cdp.on("Network.responseReceived", ({ requestId, type, response }) => kinds.set(requestId, response.url.includes("/chart/tiles/") ? "Tiles" : type));
  cdp.on("Network.loadingFinished", ({ requestId, encodedDataLength }) => {
    const kind = kinds.get(requestId) ?? "Other";
    parts[kind] = (parts[kind] ?? 0) + encodedDataLength;
    total += encodedDataLength;
  });
  await work();
  await cdp.detach();
  return { parts, total };
}

/** The whole fleet on the first page. */
async function benchFleet(page) {
  await page.goto(url);
  await page.waitForFunction((count) => document.querySelectorAll('.systems [data-liveness="live"]').length >= count, Number(vessels));
  const cdp = await page.context().newCDPSession(page);
  await cdp.send("Network.enable");
  const came = { frames: 0, bytes: 0 };
  cdp.on("Network.webSocketFrameReceived", ({ response }) => {
    came.frames += 1;
    came.bytes += response.payloadData.length;
  });
  const begun = performance.now();
  smooth(`${vessels} vessels at 10 Hz on the first page`, await frames(page, seconds), 30);
  const took = (performance.now() - begun) / 1e3;
  console.log(`  ${(came.frames / took).toFixed(1)} live frames/s with ${(came.bytes / took / 1e6).toFixed(2)} MB/s`);
  smooth("the same, panned", await panning(page, () => frames(page, seconds)), 30);
  await cdp.detach();
}

await inBrowser(async (open) => {
  const page = await open();
  page.context().setDefaultTimeout(60_000);
  await logIn(page, url, "admin", oneTime, "nine grey otters");
  const sailing = async (work) => {
    console.log("the fleet sails");
    await work();
    console.log("the fleet is silent");
  };
  const sections = {
    first: () => sailing(async () => benchFirstPage(open, await page.context().storageState())),
    plot: () => benchPlot(page, url, { vessel, from, to, seconds }),
    raw: () => benchRawPlot(page, url, seconds),
    fleet: () => sailing(() => benchFleet(page)),
    chart: () => benchChart(page, url, seconds),
    hour: () => sailing(() => benchHour(page, url, { vessel, acts })),
    watch: () => sailing(async () => watchHour(async () => open({ storageState: await page.context().storageState() }), url, { vessel, seconds: Number(process.env.LUTRA_HOUR_S ?? 3_600) })),
  };
  console.log("headless Chromium, drawn by the processor: without a graphics card");
  for (const name of wanted.length ? wanted : Object.keys(sections).filter((name) => name !== "watch")) {
    if (!sections[name]) throw new Error(`no section ${name}; there are ${Object.keys(sections).join(", ")}`);
    await sections[name]();
  }
});
