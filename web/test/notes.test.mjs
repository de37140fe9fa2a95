// Notes of the log book: `npm test` bundles the module for Node and runs this.

import assert from "node:assert/strict";
import { test } from "node:test";
import { build } from "esbuild";
import { join } from "node:path";
import { folder } from "../testing/bundled.mjs";

const outfile = join(folder, "notes.mjs");
await build({ stdin: { contents: `export * from "./src/state/notes"; export * from "./src/state/noteentries";`, resolveDir: "." }, bundle: true, format: "esm", outfile, logLevel: "warning" });
const { addressOf, askOf, byDay, correctionOf, draftFrom, draftOf, EMPTY_DRAFT, fieldOf, filterFrom, LETTERS, questionOf, wayToWrite, withNewest, withNotes, wrongOf } = await import(outfile);

const note = (time_us, text = "x") => ({ id: time_us, revision: 1, time_us, vessel: 5, vessel_name: null, lat_deg: null, lon_deg: null, text, by: "nils", written_us: 9, corrected: null, withdrawn: null, photo: null, may_change: true });

test("notes that are told again come before the older ones that are known, and unchanged ones stay the same", () => {
  const before = [note(50), note(40), note(30), note(20)];
  const told = (notes, next) => withNewest(before, { notes, next });
  const changed = { ...note(40), revision: 2, text: "y" };
  const all = told([note(60), note(50), changed], "40.40");
  assert.deepEqual(all.map(({ id, text }) => [id, text]), [[60, "x"], [50, "x"], [40, "y"], [30, "x"], [20, "x"]]);
  assert.equal(all[1], before[0], "the same object");
  assert.deepEqual(told([note(60)], null).map(({ id }) => id), [60], "these are all: the others were withdrawn");
  assert.deepEqual(told([], null), []);
});

test("a draft is judged field by field", () => {
  const wrong = (part) => wrongOf({ ...EMPTY_DRAFT, text: "a", ...part })?.field;
  assert.equal(wrong({}), undefined);
  assert.equal(wrong({ text: "  " }), "text");
  assert.equal(wrong({ text: "🐟".repeat(LETTERS) }), undefined, "letters are counted as the server counts them");
  assert.equal(wrong({ text: "a".repeat(LETTERS + 1) }), "text");
  for (const lat of ["91", "x", " ", "63° 60′"]) assert.equal(wrong({ lat, lon: "10" }), "lat_deg", lat);
  assert.equal(wrong({ lat: "63" }), "lon_deg");
  assert.equal(wrong({ lon: "10" }), "lat_deg");
  assert.equal(wrong({ lat: "63,4", lon: "-10.4" }), undefined);
  assert.deepEqual([wrong({ lat: "63° 26.4′ N", lon: "10° 24′ E" }), askOf({ text: "a", vessel: "", time: "", lat: "63° 26.4′ N", lon: "10° 24′ E" }).lat_deg], [undefined, 63.44], "as positions are shown");
  assert.deepEqual(askOf({ text: " a ", vessel: "5", time: "2026-06-01T12:00", lat: "63,4", lon: "10" }), { text: "a", vessel: 5, time_us: 1_780_315_200_000_000, lat_deg: 63.4, lon_deg: 10 });
});

test("a correction keeps the time to the microsecond unless it was changed", () => {
  const one = note(1_780_315_200_123_456);
  const draft = draftOf(one);
  assert.equal(correctionOf(one, { ...draft, text: "b" }).time_us, 1_780_315_200_123_456);
  assert.equal(correctionOf(one, { ...draft, time: "2026-06-01T12:00:01" }).time_us, 1_780_315_201_000_000);
});

test("form and filter come back from their addresses", () => {
  const way = wayToWrite(5, 1_780_315_200_123_456, { lat_deg: 63.44, lon_deg: 10.4 });
  assert.deepEqual(draftFrom(new URL(way, "http://x").searchParams), { text: "", vessel: "5", time: "2026-06-01 12:00:00", lat: "63.440000", lon: "10.400000" });
  assert.deepEqual(draftFrom(new URL(wayToWrite(5, null, null), "http://x").searchParams), { ...EMPTY_DRAFT, vessel: "5" });
  const filter = { vessel: "5", from: "2026-06-01T12:00", to: "", text: "a&b", withdrawn: true };
  assert.deepEqual(filterFrom(new URLSearchParams(addressOf(filter))), filter);
  assert.equal(addressOf({ vessel: "", from: "", to: "", text: "", withdrawn: false }), "");
  assert.equal(String(questionOf(filter)), "vessel=5&from_us=1780315200000000&text=a%26b&withdrawn=true");
});

test("notes are told by their day, and words of the server by their field", () => {
  const days = byDay([note(86_400_000_001), note(86_400_000_000), note(5)]);
  assert.deepEqual(days.map(([day, some]) => [day, some.length]), [["1970-01-02", 2], ["1970-01-01", 1]]);
  assert.deepEqual(fieldOf("lat_deg: this is: no place"), { field: "lat_deg", text: "this is: no place" });
  assert.deepEqual(fieldOf("elsewhere: x"), { field: "", text: "elsewhere: x" });
  assert.deepEqual(fieldOf("Hjørner: grensen er 9 km lang", "corners: the border is 9 km long"), { field: "corners", text: "grensen er 9 km lang" }, "the English names the field");
  assert.deepEqual(fieldOf("Navnet har flere linjer: skriv én", "name: has several lines: write one"), { field: "name", text: "Navnet har flere linjer: skriv én" });
  assert.deepEqual(fieldOf("Serveren nås ikke.", ""), { field: "", text: "Serveren nås ikke." });
});

test("notes stand among the entries of their time, and older ones come with older entries", async () => {
  const entry = (time_us) => ({ entity: 1, time_us, written_us: null, kind: 0, kind_name: null, context: "", text: "e" });
  const all = [note(50), note(40), note(10)];
  const asked = [];
  const ask = async (question) => {
    asked.push(question);
    const query = new URLSearchParams(question);
    const found = all.filter(({ time_us }) => time_us >= Number(query.get("from_us")) && time_us < Number(query.get("to_us")) && time_us < Number(query.get("before") ?? Infinity));
    // One a page.
    return { notes: found.slice(0, 1), next: found.length > 1 ? String(found[0].time_us) : null };
  };
  const query = "order=newest&limit=2&skip=0&from_us=0&to_us=100";
  const first = await withNotes({ items: [entry(60), entry(40)], next: { from_us: 0, to_us: 41, skip: 1 } }, 5, query, ask);
  assert.deepEqual(first.items.map(({ time_us, kind }) => [time_us, kind]), [[60, 0], [50, -1], [40, 0], [40, -1]]);
  const rest = await withNotes({ items: [entry(20)], next: null }, 5, "from_us=0&to_us=41&skip=1", ask);
  assert.deepEqual(rest.items.map(({ time_us }) => time_us), [40, 20, 10], "the one of the border is told by its key");
  assert.equal(rest.items[0].context, "note by nils");
  assert.ok(asked.every((one) => one.startsWith("vessel=5&")));
});

