// Whether pages lose memory: what a person does in an hour, one thing after the other, and what is left of it.

import { check } from "./browser.mjs";
import { verdict } from "./bench-frames.mjs";

/** This much more in the end than after one and two thirds is growth: heap, nodes, listeners. */
const MORE = { heap: 1.1, nodes: 1.1, listeners: 1.05 };

/** What the page holds once everything that nobody needs is gone. */
async function held(page) {
  const cdp = await page.context().newCDPSession(page);
  await cdp.send("HeapProfiler.enable");
  await cdp.send("Performance.enable");
  await cdp.send("HeapProfiler.collectGarbage");
  await cdp.send("HeapProfiler.collectGarbage");
  const { metrics } = await cdp.send("Performance.getMetrics");
  await cdp.detach();
  const of = (name) => metrics.find((one) => one.name === name).value;
  return { heap: of("JSHeapUsedSize"), nodes: of("Nodes"), listeners: of("JSEventListeners") };
}

const shown = ({ heap, nodes, listeners }) => `${(heap / 1e6).toFixed(1)} MB, ${nodes} nodes, ${listeners} listeners`;

function compare(what, [first, middle, last]) {
  const grown = Object.entries(MORE).filter(([name, most]) => last[name] > Math.max(first[name], middle[name]) * most);
  verdict(what, `after a third ${shown(first)}; two thirds ${shown(middle)}; in the end ${shown(last)}`, "no growth", !grown.length);
}

/** From page to page, as links lead. */
async function pages(page, url, vessel, plan) {
  const paths = ["/", `/vessels/${vessel}`, "/plans", `/plans/${plan}`, "/admin", "/admin/vessels", "/admin/audit", "/account", `/vessels/${vessel}?tab=Values`];
  for (const path of paths) {
    await page.goto(url + path);
    await page.getByText("Live", { exact: true }).waitFor();
  }
  return paths.length;
}

/** Everything that the first page and a vessel's page do without leaving them. */
async function onFleet(page) {
  const cards = page.locator(".systems button.system");
  for (const at of [1, 2, 0]) await cards.nth(at).click();
  await page.getByLabel("Filter").fill("voltage");
  await page.getByLabel("Filter").fill("");
  await page.locator(".map").focus();
  for (const key of ["+", "+", "-", "-", "ArrowUp", "ArrowDown"]) await page.keyboard.press(key);
  await page.getByRole("button", { name: "Show all" }).click();
  for (const palette of ["Night", "Day"]) await page.getByRole("button", { name: palette, exact: true }).click();
  return 12;
}

async function onVessel(page) {
  let acts = 0;
  const click = async (role, name) => {
    await page.getByRole(role, { name, exact: true }).click();
    acts += 1;
  };
  for (const tab of ["Values", "Entities", "Log book", "Tags", "Link loss", "Control", "Plots"]) await click("tab", tab);
  for (const name of ["Zoom out", "Zoom in", "Earlier", "Later"]) await click("button", name);
  await page.getByRole("button", { name: "Add a field" }).click();
  await page.getByLabel("Words of quantity, message, entity or field").fill("estimatedstate psi");
  await page.keyboard.press("Enter");
  await page.getByRole("button", { name: /^Remove .*psi/ }).click();
  acts += 2;
  await click("button", "+1 s, step forward");
  await click("button", "Back to live");
  await click("button", "Replay what is shown");
  await click("button", "Back to live");
  for (const palette of ["Night", "Day"]) await click("button", palette);
  return acts;
}

/** The first page and a vessel's page, live and left alone for so many seconds by the clock. */
export async function watchHour(open, url, { vessel, seconds }) {
  check(seconds >= 3, `LUTRA_HOUR_S is a number of seconds, 3 at least, not ${seconds}`);
  const pages = { "the first page": "/", "a vessel's page": `/vessels/${vessel}?span=300&plots=EstimatedState.1.u,EstimatedState.1.psi,Rpm.2.value` };
  const watched = [];
  for (const [name, path] of Object.entries(pages)) {
    const page = await open();
    await page.goto(url + path);
    await page.getByText("Live", { exact: true }).waitFor();
    watched.push({ name, page, seen: [], begun: performance.now() });
  }
  for (const third of [1, 2, 3]) {
    // Each page goes on while the other is looked at; what is waited for is the clock.
    await new Promise((done) => setTimeout(done, Math.max(0, watched[0].begun + (third * seconds * 1_000) / 3 - performance.now())));
    for (const { name, page, seen } of watched) {
      check(await page.getByText("Live", { exact: true }).isVisible(), `${name} is not live any more`);
      seen.push(await held(page));
      console.log(`  ${name} after ${Math.round((third * seconds) / 3)} s: ${shown(seen.at(-1))}`);
    }
  }
  for (const { name, page, seen } of watched) {
    compare(`${name}, watched for ${seconds} s by the clock`, seen);
    await page.context().close();
  }
}

/** `acts` page changes, tabs, zooms and the like. */
export async function benchHour(page, url, { vessel, acts }) {
  const csrf = await page.evaluate(() => document.querySelector('meta[name="csrf"]').content);
  const made = await page.request.post(`${url}/api/v1/plans`, { headers: { "x-csrf-token": csrf }, data: { name: `hour ${Date.now()}`, description: "", vessel: null, repeat: false, maneuvers: [] } });
  const { id } = await made.json();
  check(id > 0, "a plan to open");
  const live = async (path) => {
    await page.goto(url + path);
    await page.getByText("Live", { exact: true }).waitFor();
    // The page draws four times a second; what it lazily makes it has made by then.
    await page.waitForLoadState("networkidle");
  };
  const rounds = async (what, most, path, round, leaves = false) => {
    let done = 0;
    await live(path);
    const seen = [];
    // What is made once, like pictures of letters and rows of messages that come seldom, is made in the first third.
    for (const until of [most / 3, (most * 2) / 3, most]) {
      while (done <= until) done += await round();
      if (leaves) await live(path);
      seen.push(await held(page));
    }
    compare(`${done} ${what}`, seen);
  };
  await rounds("page changes", acts / 3, "/", () => pages(page, url, vessel, id), true);
  await rounds("acts on the first page", acts / 3, "/", () => onFleet(page));
  await rounds("acts on a vessel's page", acts / 3, `/vessels/${vessel}?span=300&plots=EstimatedState.1.u`, () => onVessel(page));
}
