// Nothing old looks fresh: node freshness.mjs URL ONE-TIME-PASSWORD. Prints what the boat is to do. Its values come five
// times a second, so that by contract they are old after two seconds.

import { check, inBrowser, logIn } from "./browser.mjs";

const [url, oneTime] = process.argv.slice(2);
const BOAT = 2068;

/** In the page: what looks fresh although nothing came for too long; it is drawn four times a second. */
function watch(boat) {
  const [parse, systems] = [JSON.parse, new Map()];
  const seen = { suspects: {}, wrong: [], links: [], valuesMs: undefined, heardMs: undefined, greyedMs: undefined };
  window.seen = seen;
  // What the page reads of the live socket.
  JSON.parse = (...asked) => {
    const frame = parse(...asked);
    if (frame?.samples === undefined) return frame;
    seen.heardMs = performance.now();
    for (const { series, system } of frame.series) systems.set(series, system);
    if (!frame.snapshot && frame.samples.some(({ series }) => systems.get(series) === boat)) seen.valuesMs = seen.heardMs;
    return frame;
  };
  const seconds = (text) => {
    const told = /([\d.]+) (s|min|h|d)/.exec(text ?? "");
    return told ? Number(told[1]) * { s: 1, min: 60, h: 3_600, d: 86_400 }[told[2]] : 0;
  };
  /** Contract of the values, and after how much more they must look old, s; the rest of the second is for the eye below. */
  const [CONTRACT, MORE] = [2, 0.4];
  const fresh = () => {
    const silent = seen.valuesMs === undefined ? 0 : (performance.now() - seen.valuesMs) / 1e3;
    const found = [];
    const late = (age, limit = CONTRACT) => Math.max(age, silent) > limit + MORE;
    for (const card of document.querySelectorAll(".system")) {
      const [place, heard] = [card.querySelector(".place"), card.querySelector(".heard")];
      const age = seconds(/heard (.*) ago/.exec(heard?.textContent ?? "")?.[1]);
      if (late(age, 5) && /live|late/.test(card.dataset.liveness)) found.push(`card ${card.dataset.liveness} at ${age} s`);
      for (const told of [place, ...card.querySelectorAll(".mode, .fact .num")]) {
        if (late(age) && !/^(not reported|—)$/.test(told.textContent) && !told.hasAttribute("data-old")) found.push(`${told.className} ${told.textContent} at ${age} s`);
      }
    }
    for (const tile of document.querySelectorAll(".tile:not([data-old]):not([data-tile=snr])")) {
      const age = seconds(tile.querySelector(".age").textContent);
      if (late(age, tile.dataset.tile === "link" ? 5 : CONTRACT)) found.push(`tile ${tile.dataset.tile} at ${age} s`);
    }
    for (const row of document.querySelectorAll("tbody:not([aria-hidden]) > tr:not([hidden]):not(.stale)")) {
      const text = row.lastElementChild.querySelector("button") ? row.children[5].textContent : row.lastElementChild.textContent;
      if (row.closest(".tabpanel[hidden], .plan-side, .commands") || !/ s$|min$|h$|d$/.test(text)) continue;
      if (late(seconds(text))) found.push(`row ${row.textContent}`);
    }
    for (const told of document.querySelectorAll(".tabpanel:not([hidden]) .legend .num:not([data-old])")) if (late(0) && told.textContent !== "—") found.push(`legend ${told.textContent}`);
    const map = document.querySelector(".map");
    if (map && late(0) && !(map.dataset.old ?? "").includes(String(boat))) found.push("map");
    return found;
  };
  /** Animation frames that were drawn while something was suspect. */
  let [frames, counts] = [0, false];
  const count = () => {
    frames += 1;
    counts = Object.keys(seen.suspects).length > 0;
    if (counts) requestAnimationFrame(count);
  };
  setInterval(() => {
    const [now, found] = [performance.now(), document.body.dataset.link === "down" ? [] : fresh()];
    for (const key of Object.keys(seen.suspects)) if (!found.includes(key)) delete seen.suspects[key];
    for (const key of found) {
      seen.suspects[key] ??= { now, frames };
      // What is drawn in between has had its time: ten frames, for a browser that is kept from drawing shows nothing new.
      if (now - seen.suspects[key].now > 600 && frames - seen.suspects[key].frames >= 10) seen.wrong.push(key);
    }
    if (!counts && Object.keys(seen.suspects).length) count();
  }, 100);
  document.addEventListener("DOMContentLoaded", () =>
    new MutationObserver(() => {
      const { link } = document.body.dataset;
      if (link === "down" && seen.links.at(-1) !== "down" && seen.heardMs !== undefined) seen.greyedMs = performance.now() - seen.heardMs;
      if (seen.links.at(-1) !== link) seen.links.push(link);
    }).observe(document.body, { attributeFilter: ["data-link"] }),
  );
}

await inBrowser(async (open) => {
  const first = await open();
  const context = first.context();
  await logIn(first, url, "admin", oneTime, "nine grey otters");
  const csrf = await first.evaluate(() => document.querySelector('meta[name="csrf"]').content);
  const made = await first.request.post(`${url}/api/v1/plans`, { headers: { "x-csrf-token": csrf }, data: { name: "beside the boat", description: "", vessel: null, repeat: false, maneuvers: [] } });
  await context.addInitScript(watch, BOAT);
  const views = {};
  for (const [name, path] of Object.entries({
    fleet: "/",
    values: `/vessels/${BOAT}?tab=Values`,
    entities: `/vessels/${BOAT}?tab=Entities`,
    plots: `/vessels/${BOAT}?span=60&plots=EstimatedState.1.u`,
    plan: `/plans/${(await made.json()).id}`,
  })) {
    views[name] = await context.newPage();
    await views[name].goto(url + path);
  }
  const { fleet, values, entities, plots, plan } = views;
  const all = Object.entries(views);
  const nothingWrong = async (when) => {
    for (const [name, page] of all) {
      const wrong = await page.evaluate(() => window.seen.wrong);
      check(!wrong.length, `${when}: on ${name} this looks fresh: ${[...new Set(wrong)].slice(0, 5).join("; ")}`);
    }
  };
  const onMap = (page, old) => page.waitForFunction(([boat, old]) => (document.querySelector(".map")?.dataset.old ?? "").includes(String(boat)) === old, [BOAT, old]);
  const live = async () => {
    await fleet.locator('.system[data-liveness="live"]').getByText("otter-0").waitFor();
    await fleet.waitForFunction(() => [...document.querySelectorAll(".system .fact .num, .system .mode")].every((told) => !told.hasAttribute("data-old")));
    await values.waitForFunction(() => [...document.querySelectorAll("table.values tr")].some((row) => /Voltage/.test(row.textContent) && !row.classList.contains("stale")));
    for (const page of [values, entities, plots]) await page.locator('[data-tile="speed_mps"]:not([data-old])').waitFor();
    await plots.locator(".legend .num:not([data-old])").getByText(/m\/s/).waitFor();
    for (const [, page] of all) await onMap(page, false);
  };
  const old = async () => {
    await fleet.locator('.system[data-liveness="stale"], .system[data-liveness="lost"]').getByText("otter-0").waitFor();
    await fleet.getByText(/63° .* E \(old\)/).waitFor();
    await fleet.waitForFunction(() => [...document.querySelectorAll(".system .fact .num, .system .mode, .system .place")].every((told) => told.hasAttribute("data-old")));
    await values.waitForFunction(() => [...document.querySelectorAll("table.values tbody:not([aria-hidden]) tr:not([hidden])")].every((row) => row.classList.contains("stale")));
    await entities.waitForFunction(() => [...document.querySelectorAll("table.compact [data-entity]")].filter((row) => /normal/.test(row.textContent)).every((row) => row.classList.contains("stale")));
    for (const page of [values, entities, plots]) await page.waitForFunction(() => !document.querySelector(".tile:not([data-old]):not([data-tile=snr])"));
    await plots.locator(".legend .num[data-old]").getByText(/\(old: /).waitFor();
    for (const [, page] of all) await onMap(page, true);
  };

  await live();
  console.log("silence");
  await old();
  await nothingWrong("silence");
  await fleet.getByText(/otter-0: not heard since/).first().waitFor();
  console.log("speak");
  await live();

  // Only where it is is no longer reported: it is heard, and its place is old.
  console.log("no place");
  await fleet.locator('.system[data-liveness="live"]').getByText(/63° .* E \(old\)/).waitFor();
  for (const [, page] of all) await onMap(page, true);
  await values.locator('[data-tile="heading_rad"][data-old]').waitFor();
  await values.locator('[data-tile="mode"]:not([data-old])').waitFor();
  console.log("place");
  await live();

  // The clock of the computer is set, or it slept: the page greys, asks again, and tells the same ages.
  for (const [, page] of all) {
    await page.evaluate(() => {
      window.seen.links = [];
      const real = Date.now;
      Date.now = () => real() + 600_000;
    });
  }
  for (const [, page] of all) await page.waitForFunction(() => window.seen.links.join().includes("down,up"));
  await live();
  await nothingWrong("clock set");

  // A tab that the browser froze, while the vessel fell silent: it wakes with what is, not with what was.
  const frozen = await context.newCDPSession(values);
  await frozen.send("Page.setWebLifecycleState", { state: "frozen" });
  console.log("silence");
  await entities.waitForFunction(() => !document.querySelector(".tile:not([data-old]):not([data-tile=snr])"));
  await frozen.send("Page.setWebLifecycleState", { state: "active" });
  await old();
  await nothingWrong("tab frozen");
  console.log("speak");
  await live();

  // Without the server all pages grey.
  console.log("stop the server");
  for (const [name, page] of all) {
    await page.locator('body[data-link="down"]').waitFor();
    await page.getByText("No link to the server").waitFor();
    const greyedMs = await page.evaluate(() => window.seen.greyedMs);
    console.log(`${name} greyed ${Math.round(greyedMs)} ms after the last that it heard`);
    // Its timer is for 2.8 s; half a second is for a machine that is busy.
    check(greyedMs < 3_300, `${name} greyed late`);
    await onMap(page, true);
  }
  await fleet.locator('.system[data-liveness="lost"]').getByText("not known").waitFor();
  check(await values.evaluate(() => !document.querySelector(".tile:not([data-old])")), "no instrument looks fresh");
  for (const [name, page] of all) check((await page.locator(".map").evaluate((node) => getComputedStyle(node.closest("#fleet, #vessel") ?? node).filter)) !== "none", `${name} is grey`);
  await nothingWrong("server gone");
}, { whole: true });
