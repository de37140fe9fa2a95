// The explorer's plots and its table, without a page: `npm test` runs this.

import assert from "node:assert/strict";
import { test } from "node:test";
import { build } from "esbuild";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { folder } from "../testing/bundled.mjs";

const web = dirname(dirname(fileURLToPath(import.meta.url)));
const outdir = folder;
await build({ entryPoints: ["src/state/explore.ts", "src/api/looking.ts", "src/words/words.ts"].map((one) => join(web, one)), outdir, bundle: true, format: "esm", logLevel: "error", outExtension: { ".js": ".mjs" } });
const { apiOf, askedOf, barNumbers, barsBegin, barsTitle, brushed, hoursText, projectsOf, searchOf, sideBySide, summaryOf, ticks } = await import(join(outdir, "state/explore.mjs"));
const { look, restOf } = await import(join(outdir, "api/looking.mjs"));
const { count } = await import(join(outdir, "words/words.mjs"));

const us = (text) => Date.parse(text) * 1_000;
const texts = (from, to, most) => ticks(us(from), us(to), most).map(({ text }) => text);

test("marks of an axis stand at whole times and are few enough", () => {
  assert.deepEqual(texts("2026-11-21T08:10:00Z", "2026-11-21T11:10:00Z", 4), ["09:00", "10:00", "11:00"]);
  assert.deepEqual(texts("2026-11-21T20:00:00Z", "2026-11-22T04:00:00Z", 5), ["20:00", "22:00", "22 Nov", "02:00", "04:00"]);
  assert.deepEqual(texts("2026-11-21T08:00:00Z", "2026-11-21T08:00:20Z", 5), ["08:00:00", "08:00:05", "08:00:10", "08:00:15", "08:00:20"]);
  // Weeks begin on Monday, months on the first.
  assert.deepEqual(texts("2026-11-14T08:00:00Z", "2026-12-05T08:00:00Z", 4), ["16 Nov", "23 Nov", "30 Nov"]);
  assert.deepEqual(texts("2026-11-14T00:00:00Z", "2027-03-05T00:00:00Z", 5), ["Dec 2026", "Jan 2027", "Feb 2027", "Mar 2027"]);
  assert.deepEqual(texts("1970-01-01T00:00:01Z", "2026-11-21T00:00:00Z", 6), ["1980", "1990", "2000", "2010", "2020"]);
  for (const days of [0.001, 0.1, 1, 3, 10, 40, 100, 365, 4_000, 30_000]) {
    for (const most of [2, 4, 12]) {
      const found = ticks(us("2026-01-01T00:00:00Z") + 12_345, us("2026-01-01T00:00:00Z") + days * 86_400e6, most);
      assert.ok(found.length <= most + 1, `${found.length} marks over ${days} days`);
    }
  }
});

test("bars are called by what they are long", () => {
  assert.equal(barsTitle(3_600e6), "Detections per hour");
  assert.equal(barsTitle(86_400e6), "Detections per day");
  assert.equal(barsTitle(7 * 86_400e6), "Detections per week");
  assert.equal(barsTitle(6 * 3_600e6), "Detections by time, 6 h a bar");
});

test("thousands stand apart as the language has it", () => {
  assert.equal(count(1_234_567), "1,234,567");
  globalThis.lutraWords = () => undefined;
  assert.equal(count(1_234_567), "1\u00a0234\u00a0567");
  globalThis.lutraWords = undefined;
});

test("places on both sides of the 180th meridian lie side by side", () => {
  assert.deepEqual(sideBySide([179.9, -179.9, 179.8]), [179.9, 180.1, 179.8]);
  assert.deepEqual(sideBySide([-179, 179, -178]), [181, 179, 182]);
  assert.deepEqual(sideBySide([-0.5, 0.5, 10]), [-0.5, 0.5, 10]);
  assert.deepEqual(sideBySide([-100, 100]), [260, 100]);
  assert.deepEqual(sideBySide([7]), [7]);
  assert.deepEqual(sideBySide([]), []);
});

test("a time that is drawn over a plot is of whole steps", () => {
  assert.deepEqual(brushed(1_250, 1_010, 1_000, 100), { from: 1_000, to: 1_300 });
  assert.deepEqual(brushed(1_100, 1_200, 1_000, 100), { from: 1_100, to: 1_200 });
  assert.deepEqual(brushed(1_100, 1_100, 1_000, 100), { from: 1_100, to: 1_200 });
  // Bars of weeks begin on Monday 16 November, the plots on Saturday 21: a drag over the first two bars is of both weeks, whole.
  const [week, from_us] = [7 * 86_400e6, us("2026-11-21T08:00Z")];
  const begin = barsBegin({ from_us, bars: [{ from_us: us("2026-11-16T00:00Z"), detections: 1, unconfirmed: 0, listened_s: null }] });
  assert.deepEqual(brushed(from_us, us("2026-11-25T00:00Z"), begin, week), { from: us("2026-11-16T00:00Z"), to: us("2026-11-30T00:00Z") });
  assert.deepEqual([barsBegin({ from_us, bars: [] }), barsBegin({ from_us: null, bars: [] })], [from_us, 0]);
  assert.deepEqual([30, 90, 5_400, 36_000_000].map((s) => hoursText(s)), ["30 s", "2 min", "2 h", "10,000 h"]);
});

test("how many nothing confirms is empty where it is not known", () => {
  const bar = (from_us) => ({ from_us, detections: 3, unconfirmed: 1, listened_s: null });
  const rows = (cut) => barNumbers({ bars: [bar(us("2026-11-21T12:00Z")), bar(us("2026-11-22T12:00Z"))], bar_us: 3_600e6, ...cut }).rows.map((row) => row[3]);
  assert.deepEqual(rows({ confirmed_from_us: null }), [1, 1]);
  // Also where nothing that was asked for is left out: what lies before it may confirm its first day.
  assert.deepEqual(rows({ left_out_before_us: null, read_from_us: null, confirmed_from_us: us("2026-11-22T12:00Z") }), [null, 1]);
  assert.deepEqual(rows({ confirmed_from_us: us("2026-11-23T00:00Z") }), [null, null]);
});

test("the whole axis is asked for with the numbers", () => {
  const asked = { from: "", to: "", vessel: "1,2", tag: "", project: [], area: "", axis: "whole" };
  assert.equal(summaryOf(asked), "vessel=1%2C2&whole_axis=true");
  assert.equal(summaryOf({ ...asked, vessel: "", axis: "" }), "");
});

test("detections are looked for through pages without any, within bounds", async () => {
  const one = (n) => ({ system: 1, id: String(n) });
  const next = (to_us) => ({ from_us: 0, to_us, skip: 2 });
  const asked = [];
  const of = (pages) => ({ ask: async (path) => { asked.push(path); return pages(asked.length); } });
  const far = [];
  const found = await look(of((page) => (page < 4 ? { detections: [], next: next(100 - page) } : { detections: [one(1), one(2)], next: null })), "tag=1&limit=9", 9, ({ rest }) => far.push(rest));
  assert.deepEqual([found.rows.length, found.rest, asked.length, far.length], [2, "", 4, 3]);
  assert.equal(asked[1], "/api/v1/detections?tag=1&limit=9&from_us=0&to_us=99&skip=2");
  asked.length = 0;
  const never = await look(of(() => ({ detections: [], next: next(5) })), "tag=1", 1, () => undefined);
  assert.equal(never.rows.length, 0);
  assert.equal(never.rest, restOf({ next: next(5) }, "tag=1"));
  assert.ok(asked.length > 5 && asked.length < 100, `${asked.length} pages`);
  assert.equal(await look({ ask: async () => undefined }, "tag=1", 1, () => undefined), undefined);
});

test("a project whose name has a semicolon is asked for as it is", () => {
  const asked = askedOf("project=Cod%3B+north&project=Salmon&project=");
  assert.deepEqual(asked.project, ["Cod; north", "Salmon"]);
  for (const text of [apiOf(asked), searchOf(asked)]) assert.equal(text, "project=Cod%3B+north&project=Salmon");
  assert.deepEqual(projectsOf(asked.project, ["cod; north", "Salmon"]), ["Cod; north", "Salmon"]);
  // Addresses of earlier versions have a list in one text.
  assert.deepEqual(projectsOf(["Cod; Salmon"], ["Cod", "Salmon"]), ["Cod", "Salmon"]);
});
