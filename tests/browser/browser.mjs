// A headless Chromium whose console must stay empty, and what every page must be: axe's judgement, widths, pictures.

import { createRequire } from "node:module";
import { existsSync } from "node:fs";
import { mkdir, readFile } from "node:fs/promises";
import { fileURLToPath } from "node:url";
import { basename, join } from "node:path";

const root = fileURLToPath(new URL("../..", import.meta.url));
const require = createRequire(join(root, "web/package.json"));
const { chromium } = require("playwright-core");
const axe = await readFile(require.resolve("axe-core/axe.min.js"), "utf8");

/** The shell has no windows of its own: it starts three times as soon, needs two thirds of the processor's time, and draws all
 * pages as if each were in front. The whole browser draws a page that is behind others as people's do: not at all. */
const [SHELL, WHOLE] = ["/usr/bin/chromium-headless-shell", "/usr/bin/chromium"];

/** A desk, a small laptop, a tablet and a phone; a page that is opened has the first. */
export const SIZES = [
  { width: 1440, height: 900 },
  { width: 1024, height: 768 },
  { width: 820, height: 1180 },
  { width: 390, height: 844 },
];
/** How much longer than on a quiet computer a wait may last: before a change lands others load the computer as well. */
export const BUSY = process.env.NEXTEST_PROFILE === "ci" ? 4 : 1;
/** Longer than anything takes. */
export const PATIENCE_MS = 60_000 * BUSY;
/** Letters of a page that failed. */
const MOST_SAID = 6_000;
/** Whether all that is done on a page is recorded with what it showed at each step, which takes a tenth of a flow's time and more. */
const TRACED = Boolean(process.env.LUTRA_TRACE);
const PALETTES = ["day", "sun", "dusk", "night"];
const TAGS = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa"];
/** Those of axe's rules that look at colours, and the one that looks at how large targets are: nine tenths of axe's time. */
const [COLOURS, SIZE] = [["color-contrast", "link-in-text-block"], ["target-size"]];

/** Starts Chromium, runs `work`, and fails on anything the pages complained about. `whole` asks for the whole browser, with pages
 * behind others, where it is there. */
export async function inBrowser(work, { whole = false } = {}) {
  const browser = await chromium.launch({
    timeout: PATIENCE_MS,
    executablePath: (whole ? [WHOLE, SHELL] : [SHELL, WHOLE]).find(existsSync),
    args: ["--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync"],
  });
  const complaints = [];
  const pages = [];
  const open = async (options = {}) => {
    // Who wants no motion: a note that comes while axe looks does not fade in before it.
    const context = await browser.newContext({ viewport: SIZES[0], serviceWorkers: "block", reducedMotion: "reduce", ...options });
    context.setDefaultTimeout(PATIENCE_MS);
    if (TRACED) await context.tracing.start({ title: basename(process.argv[1]), screenshots: true, snapshots: true });
    const page = await context.newPage();
    pages.push(page);
    page.on("console", (message) => {
      // A refusal or a broken line that a test provokes is told by the browser itself; a map that is folded away for a
      // moment by OpenLayers, which also tries at its first click which way of reading a canvas is faster;
      // and that a test wants no worker.
      const told =
        /status of (400|401|403|404|409|410|422|429|503)|WebSocket connection|ERR_CONNECTION_(REFUSED|RESET|CLOSED)|ERR_FAILED|ERR_CONTENT_LENGTH_MISMATCH|ERR_SOCKET_NOT_CONNECTED|ERR_EMPTY_RESPONSE|Service Worker registration blocked by Playwright|No map visible|willReadFrequently/.test(message.text());
      if (["error", "warning"].includes(message.type()) && !told) complaints.push(message.text());
    });
    page.on("pageerror", (error) => complaints.push(String(error)));
    page.on("request", (request) => {
      const { protocol, hostname } = new URL(request.url());
      if (protocol !== "data:" && hostname !== "127.0.0.1") complaints.push(`asked ${request.url()}`);
    });
    return page;
  };
  try {
    await work(open);
    if (complaints.length) throw new Error(`the browser complained:\n${complaints.join("\n")}`);
  } catch (error) {
    for (const [number, page] of pages.entries()) await lastSeen(page, number).catch(() => undefined);
    throw error;
  } finally {
    await browser.close();
  }
}

/** What a page showed when its test failed: a picture, all that it says, as a screen reader has it, and with LUTRA_TRACE set all
 * that was done on it, as `node web/node_modules/playwright-core/cli.js show-trace` shows it. */
async function lastSeen(page, number) {
  if (page.isClosed()) return;
  const name = `target/failures/${basename(process.argv[1], ".mjs")}-${number}`;
  await mkdir(join(root, "target/failures"), { recursive: true });
  if (TRACED) await page.context().tracing.stop({ path: join(root, `${name}.zip`) }).catch(() => undefined);
  const film = TRACED ? `, what was done in ${name}.zip` : "";
  console.error(`-- page ${number}: ${page.url()}; a picture is in ${name}.png${film}; it said:`);
  console.error((await page.locator("body").ariaSnapshot({ timeout: 5_000 })).slice(0, MOST_SAID));
  await page.screenshot({ path: join(root, `${name}.png`), timeout: 10_000 });
}

export function check(holds, text) {
  if (!holds) throw new Error(text);
}

/** Lets the server's clock go on in steps of so many seconds, until something is to be seen. */
export async function later(seen, stepS) {
  for (let steps = 0; steps < 40; steps++) {
    console.log(`advance ${stepS}`);
    if (await seen.waitFor({ timeout: 600 }).then(() => true, () => false)) return;
  }
  throw new Error(`not ${seen}, 40 times ${stepS} s later`);
}

/** Asks again and again, until something that no page shows holds; gives what was answered then. */
export async function until(holds, what, withinMs = 30_000) {
  for (const end = Date.now() + withinMs * BUSY; Date.now() < end; ) {
    const answer = await holds();
    if (answer) return answer;
    await new Promise((done) => setTimeout(done, 200));
  }
  throw new Error(`${what}: not within ${(withinMs * BUSY) / 1e3} s`);
}

/** Whether two values are the same all through; else the first difference is told. */
export function same(found, wanted, what) {
  if (!Array.isArray(found) || !Array.isArray(wanted)) return check(Object.is(found, wanted), `${what}: ${JSON.stringify(found)} in place of ${JSON.stringify(wanted)}`);
  check(found.length === wanted.length, `${what}: ${found.length} in place of ${wanted.length}`);
  found.forEach((one, at) => same(one, wanted[at], `${what}, ${at}`));
}

/** A table of comma-separated values as texts, without the apostrophe that keeps spreadsheets from taking text for formulas. */
export function table(text) {
  const rows = [[]];
  for (const [, quoted, plain, end] of text.matchAll(/(?:"((?:[^"]|"")*)"|([^,\n"]*))(,|\n|$)/g)) {
    const cell = quoted === undefined ? plain : quoted.replaceAll('""', '"');
    rows.at(-1).push(/^'[=+\-@＝＋－＠\t\r\n']/.test(cell) ? cell.slice(1) : cell);
    if (end === "\n") rows.push([]);
    if (end === "") break;
  }
  // After the last line's end nothing follows.
  rows.pop();
  const [head, ...rest] = rows;
  for (const row of rest) check(row.length === head.length, `a row of ${row.length} cells under ${head.length}: ${row}`);
  return { head, rows: rest };
}

/** Whether a file of plots holds these samples of its one field, each with its time and value, and nothing else. */
export function sameSamples(text, { rows }, field) {
  const { head, rows: lines } = table(text);
  const [time, value] = [head.indexOf("unix_s"), head.findIndex((one) => one.split(" ")[0] === field)];
  check(value > 0 && /\[.+\]/.test(head[value]), `${head} has ${field} with its unit`);
  check(rows.length > 5, `${rows.length} samples`);
  // Numbers of single precision are written as short as they can be.
  const found = lines.map((line) => [Math.round(Number(line[time]) * 1e6), Math.fround(Number(line[value]))]);
  same(found, rows.map((row) => [row.time_us, Math.fround(row.values[0])]), `${field} in the file`);
}

/** Logs in with a one-time password and chooses one. */
export async function logIn(page, url, name, password, next) {
  await page.goto(`${url}/login`);
  await page.getByLabel("Name").fill(name);
  await page.getByLabel("Password").fill(password);
  await page.getByRole("button", { name: "Log in" }).click();
  if (!next) return;
  await page.getByLabel("One-time password").fill(password);
  await page.getByLabel(/New password, at least/).fill(next);
  await page.getByLabel("New password again").fill(next);
  await page.getByRole("button", { name: "Change password" }).click();
  await page.getByText("Your password is changed").waitFor();
}

/** A state of a page in a flow: no wider than its window, at a desk and on a phone. With LUTRA_LONG set it is looked at as by
 * [`lookInAll`], and axe judges each text and target instead of one of those that look alike; with LUTRA_PICTURES set pictures of
 * it all lie in target/screenshots. */
export async function look(page, name) {
  if (process.env.LUTRA_LONG) return lookIn(page, name, PALETTES, SIZES);
  await fitAt(page, name, [SIZES[0], SIZES.at(-1)]);
}

/** A page as it should be: no wider than its window at each size, and without a violation by axe in each palette. Texts that look
 * alike are judged by two of them, on the first of a flow's pages that has them, and of targets those that are small or under
 * others. */
export async function lookInAll(page, name) {
  await lookIn(page, name, PALETTES, SIZES);
}

async function lookIn(page, name, palettes, sizes) {
  const whole = Boolean(process.env.LUTRA_LONG);
  for (const palette of palettes) {
    await page.evaluate((palette) => (document.documentElement.dataset.palette = palette), palette);
    const runs = [[COLOURS, whole ? "all" : "texts"]];
    // What is no matter of colours is the same in all palettes.
    if (palette === palettes[0]) runs.push([[...TAGS], "all"], [SIZE, whole ? "all" : "targets"]);
    await violations(page, `${name} in ${palette}`, runs);
    if (process.env.LUTRA_PICTURES) for (const size of SIZES) await picture(page, size, `${name}-${palette}-${size.width}`);
  }
  // Palettes do not change widths.
  await fitAt(page, name, sizes);
}

/** The size in which flows go on comes last. */
async function fitAt(page, name, sizes) {
  for (const size of [...sizes].reverse()) {
    await resize(page, size);
    await fits(page, `${name} at ${size.width} px`);
  }
}

async function picture(page, size, name) {
  const folder = join(root, "target/screenshots");
  await mkdir(folder, { recursive: true });
  await resize(page, size);
  await page.screenshot({ path: join(folder, `${name}.png`), fullPage: true });
}

/** The map paints itself after the page. */
async function resize(page, size) {
  await page.setViewportSize(size);
  await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
}

/** Nobody scrolls sideways: what sticks out of the window is named. */
export async function fits(page, where) {
  const out = await page.evaluate(() => {
    const wide = document.documentElement.scrollWidth;
    if (wide <= innerWidth) return [];
    // A box that scrolls by itself holds what is placed in it; what is placed absolutely may be so beside it.
    const clipped = (node, out) => {
      if (!node || node === document.documentElement) return false;
      const { overflowX, position } = getComputedStyle(node);
      return (overflowX !== "visible" && (!out || position !== "static")) || clipped(node.parentElement, (out && position === "static") || position === "absolute");
    };
    const past = [...document.body.querySelectorAll("*")].filter((node) => node.getBoundingClientRect().right > innerWidth + 0.5 && !clipped(node.parentElement, getComputedStyle(node).position === "absolute"));
    // Of what sticks out, what is innermost says most.
    const inner = past.filter((node) => !past.some((other) => other !== node && node.contains(other)));
    return [`${wide} px wide`, ...inner.slice(0, 8).map((node) => `${node.cloneNode().outerHTML.slice(0, 100)} ${node.textContent.trim().slice(0, 40)} to ${Math.round(node.getBoundingClientRect().right)} px`)];
  });
  check(!out.length, `${where}: the page is wider than its window: ${out.join("\n    ")}`);
}

/** Looks of texts that axe has judged in this flow, as numbers: see [`choosing`]. */
const judged = new Set();

async function violations(page, where, runs) {
  // What fades in is judged once it is there; alarms flash on.
  await page.evaluate(() => Promise.allSettled(document.getAnimations().filter((one) => one.effect?.getComputedTiming().endTime !== Infinity).map((one) => one.finished)));
  if (!(await page.evaluate(() => "axe" in window))) await page.evaluate(`${axe};(${choosing})()`);
  const { told, looks } = await page.evaluate(judge, { runs, before: [...judged] });
  check(!told.length, `${where}: ${told.join("\n")}`);
  for (const look of looks) judged.add(look);
}

/** In the page: what axe's rules say of what they are to look at, and the looks of texts that were judged. */
async function judge({ runs, before }) {
  const [told, looks] = [[], []];
  for (const [names, which] of runs) {
    const include = which === "all" ? document : window.chosen[which](new Set(before), looks);
    if (include.length === 0) continue;
    const byTag = names[0].startsWith("wcag");
    // Each rule runs once: those that are told by their names are left out of those that are told by their tags.
    const rules = byTag ? Object.fromEntries(["color-contrast", "link-in-text-block", "target-size"].map((name) => [name, { enabled: false }])) : {};
    const options = { runOnly: { type: byTag ? "tag" : "rule", values: names }, rules, resultTypes: ["violations"] };
    const { violations } = await window.axe.run(include === document ? document : { include }, options);
    told.push(...violations.map((one) => `${one.id}: ${one.nodes.map((node) => `${node.target} ${node.any[0]?.message ?? ""}`).join("\n    ")}`));
  }
  return { told, looks };
}

/** In the page: brings `window.chosen`, what is enough for axe to look at. */
function choosing() {
  /** Of a text's look a number; two looks that share one are a matter of 2⁻⁵³. */
  const numbered = (look) => {
    let [one, other] = [0xdeadbeef, 0x41c6ce57];
    for (let at = 0; at < look.length; at++) {
      one = Math.imul(one ^ look.charCodeAt(at), 2654435761);
      other = Math.imul(other ^ look.charCodeAt(at), 1597334677);
    }
    return 4294967296 * (2097151 & (other ^ (one >>> 16))) + ((one ^ (other >>> 13)) >>> 0);
  };
  /** The first and the last text of those that look alike: same ink, size and strength on the same grounds, in the same kind of
   * layer; without those that look as what was judged `before`. `looks` gets what is new. */
  const texts = (before, looks) => {
    const grounds = new Map();
    // All that lies behind a node and how it is laid there, as one text; layers are told apart by their names.
    const ground = (node) => {
      if (!node) return "";
      if (!grounds.has(node)) {
        const { backgroundColor, backgroundImage, opacity, position, filter, mixBlendMode } = getComputedStyle(node);
        const own = [backgroundColor, backgroundImage, opacity, filter, mixBlendMode].join();
        const layer = position === "static" || position === "relative" ? "" : `layer ${node.localName}#${node.id}.${node.className}`;
        const behind = ground(node.parentElement);
        // What shows nothing of its own changes nothing.
        grounds.set(node, own === "rgba(0, 0, 0, 0),none,1,none,normal" && !layer ? behind : `${behind}/${own} ${layer}`);
      }
      return grounds.get(node);
    };
    const alike = new Map();
    for (const node of document.body.querySelectorAll("*")) {
      const says = [...node.childNodes].some((one) => one.nodeType === Node.TEXT_NODE && one.data.trim()) || node.matches("input, select, textarea");
      if (!says || !node.checkVisibility()) continue;
      const { color, fontSize, fontWeight, textShadow, textDecorationLine, display } = getComputedStyle(node);
      const off = Boolean(node.closest(":disabled, [aria-disabled=true]"));
      const key = [node.localName, color, fontSize, fontWeight, textShadow, textDecorationLine, display, off, ground(node)].join();
      alike.set(key, [alike.get(key)?.[0] ?? node, node]);
    }
    const fresh = [...alike].map(([look, nodes]) => [numbered(look), nodes]).filter(([look]) => !before.has(look));
    looks.push(...fresh.map(([look]) => look));
    return [...new Set(fresh.flatMap(([, nodes]) => nodes))];
  };
  /** Targets that are less than 24 px wide or high, or over or under another: of others axe's rule says that they are well. */
  const targets = () => {
    const all = [...document.querySelectorAll("a, area, button, input, label, select, summary, textarea, option, [role], [tabindex]")].filter((node) => node.checkVisibility()).map((node) => ({ node, box: node.getBoundingClientRect() }));
    const overlap = (one, other) => one.left < other.right && other.left < one.right && one.top < other.bottom && other.top < one.bottom;
    const crowded = ({ node, box }) => box.width < 24 || box.height < 24 || all.some((other) => other.node !== node && !other.node.contains(node) && overlap(box, other.box));
    return all.filter(crowded).map(({ node }) => node);
  };
  window.chosen = { texts, targets };
}
