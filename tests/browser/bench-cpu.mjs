// What a page costs the processor while it is left alone: node bench-cpu.mjs LUTRA-SERVER [SECONDS], as `scripts/bench-pages cpu`
// starts it. Three simulated Otters sail before it. Times are the processor's own, so that other programs change them little.
// PROFILE=1 also says in which functions the script's time went.

import { inBrowser, logIn } from "./browser.mjs";
import { withDemo } from "./demoserver.mjs";

const [program, given] = process.argv.slice(2);
const seconds = Number(given ?? 30);
const VESSEL = 10449;
/** What it takes to begin is not what it takes to go on. */
const SETTLE_MS = 8_000;
const PATIENCE_MS = 60_000;
const SAMPLE_US = 500;
const TOLD_FUNCTIONS = 25;

const PAGES = {
  "the first page": "/",
  "a vessel's page": `/vessels/${VESSEL}`,
  "a vessel's page, Values": `/vessels/${VESSEL}?tab=Values`,
  "the page Data, at rest": "/data",
};

/** Seconds of the processor that the browser's processes have taken, by kind: drawing is done in that of the graphics card. */
async function processes(browser) {
  const { processInfo } = await browser.send("SystemInfo.getProcessInfo");
  const of = (type) => processInfo.filter((one) => one.type === type).reduce((sum, { cpuTime }) => sum + cpuTime, 0);
  return { renderer: of("renderer"), gpu: of("GPU"), browser: of("browser") };
}

async function counters(cdp) {
  const { metrics } = await cdp.send("Performance.getMetrics");
  return Object.fromEntries(metrics.map(({ name, value }) => [name, value]));
}

/** Paints and frames of the compositor that a trace names. */
async function traced(browser, work) {
  const counts = new Map();
  browser.on("Tracing.dataCollected", ({ value }) => value.forEach(({ name, ph }) => (ph === "X" || ph === "I" || ph === "b") && counts.set(name, (counts.get(name) ?? 0) + 1)));
  await browser.send("Tracing.start", { transferMode: "ReportEvents", traceConfig: { includedCategories: ["devtools.timeline"], excludedCategories: ["*"] } });
  await work();
  const done = new Promise((all) => browser.once("Tracing.tracingComplete", all));
  await browser.send("Tracing.end");
  await done;
  return (name) => counts.get(name) ?? 0;
}

function heaviest({ nodes, samples, timeDeltas }) {
  const byId = new Map(nodes.map((node) => [node.id, node]));
  const self = new Map();
  samples.forEach((id, at) => {
    const { functionName, url, lineNumber, columnNumber } = byId.get(id).callFrame;
    const name = `${functionName || "(anonymous)"} ${url.split("/").at(-1)}:${lineNumber}:${columnNumber}`;
    self.set(name, (self.get(name) ?? 0) + timeDeltas[at]);
  });
  return [...self].filter(([name]) => !name.startsWith("(idle)")).sort(([, one], [, other]) => other - one).slice(0, TOLD_FUNCTIONS);
}

async function measure(page, browser, what) {
  const cdp = await page.context().newCDPSession(page);
  await cdp.send("Performance.enable");
  await page.waitForTimeout(SETTLE_MS);
  if (process.env.PROFILE) {
    await cdp.send("Profiler.enable");
    await cdp.send("Profiler.setSamplingInterval", { interval: SAMPLE_US });
    await cdp.send("Profiler.start");
  }
  const [before, spent] = [await counters(cdp), await processes(browser)];
  const begun = performance.now();
  await page.waitForTimeout(seconds * 1e3);
  const took = (performance.now() - begun) / 1e3;
  const [after, all] = [await counters(cdp), await processes(browser)];
  const ms = (name) => `${(((after[name] - before[name]) * 1e3) / took).toFixed(1)} ms`;
  const times = (name) => ((after[name] - before[name]) / took).toFixed(1);
  const of = (kind) => `${(((all[kind] - spent[kind]) * 1e3) / took).toFixed(0)} ms`;
  console.log(`${what}: a second costs the renderer ${of("renderer")}, drawing ${of("gpu")}, the browser ${of("browser")} of the processor`);
  console.log(`  of its main thread ${ms("TaskDuration")}: script ${ms("ScriptDuration")}, style ${ms("RecalcStyleDuration")} (${times("RecalcStyleCount")} times), layout ${ms("LayoutDuration")} (${times("LayoutCount")} times)`);
  if (process.env.PROFILE) {
    const { profile } = await cdp.send("Profiler.stop");
    for (const [name, us] of heaviest(profile)) console.log(`    ${(us / 1e3 / took).toFixed(2)} ms/s ${name}`);
  }
  const count = await traced(browser, () => page.waitForTimeout(5_000));
  console.log(`  pictures: ${["FireAnimationFrame", "Paint", "Commit", "FunctionCall"].map((name) => `${name} ${(count(name) / 5).toFixed(1)}`).join(", ")} a second`);
  await cdp.detach();
}

await withDemo(program, ["--otters", "3", "--no-past", "--no-cut"], async ({ url, password }) => {
  await inBrowser(async (open) => {
    const page = await open();
    page.context().setDefaultTimeout(PATIENCE_MS);
    await logIn(page, url, "admin", password);
    const browser = await page.context().browser().newBrowserCDPSession();
    console.log("headless Chromium, drawn by the processor: without a graphics card");
    for (const [what, path] of Object.entries(PAGES)) {
      await page.goto(url + path);
      await page.getByText("Live", { exact: true }).waitFor();
      await measure(page, browser, what);
    }
  });
});
