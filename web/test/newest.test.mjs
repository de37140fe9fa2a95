// The newest events of a stretch of time: `npm test` bundles the module for Node and runs this.

import assert from "node:assert/strict";
import { test } from "node:test";
import { load } from "../testing/bundled.mjs";

const { completed, detectionCompleted, joined, lengthened, question, refreshed, within } = await load("state/newest");

/** What a server knows, the oldest first: several at one time. */
const server = (count, first = 0) => Array.from({ length: count }, (_, at) => ({ time_us: 10 * Math.floor((first + at) / 3), name: `${first + at}` }));
const key = (one) => one.name;
const identity = { key, merged: completed };
const STRETCH = { fromUs: 0, toUs: 1_000_000 };
/** Its answer, as the store gives it. */
function answer(all, text) {
  const query = Object.fromEntries(new URLSearchParams(text).entries());
  const [from, to, limit, skip] = ["from_us", "to_us", "limit", "skip"].map((name) => Number(query[name]));
  assert.equal(query.order, "newest");
  const found = all.filter(({ time_us }) => time_us >= from && time_us < to).reverse();
  const rest = found[skip + limit];
  const items = found.slice(skip, skip + limit);
  if (!rest) return { items, next: null };
  const before = found.slice(0, skip + limit).filter(({ time_us }) => time_us === rest.time_us).length;
  return { items, next: { from_us: from, to_us: rest.time_us + 1, skip: before } };
}
const first = (all, before, limit, stretch = STRETCH) => refreshed(before, answer(all, question(stretch, limit, null)), stretch, identity);
const older = (all, known, limit) => lengthened(known, answer(all, question(known.stretch, limit, known.next)), identity);
const names = ({ items }) => items.map(key);

test("page by page all are read once, the newest first", () => {
  const all = server(20);
  let known = first(all, undefined, 4);
  while (known.next) known = older(all, known, 4);
  assert.deepEqual(names(known), all.map(key).reverse());
});

test("newer ones join what was read, without a gap and none twice", () => {
  let known = first(server(20), undefined, 4);
  known = older(server(20), known, 4);
  const more = server(23);
  known = first(more, known, 4);
  assert.deepEqual(names(known), more.slice(12).map(key).reverse());
  while (known.next) known = older(more, known, 4);
  assert.deepEqual(names(known), more.map(key).reverse());
});

test("where so many came that nothing meets, it starts over", () => {
  let known = first(server(20), undefined, 4);
  known = older(server(20), known, 4);
  const more = server(60);
  known = first(more, known, 4);
  assert.deepEqual(names(known), more.slice(56).map(key).reverse());
  assert.deepEqual(names(older(more, known, 4)), more.slice(52).map(key).reverse());
});

test("what the present leaves behind is left behind", () => {
  const all = server(20);
  let known = older(all, first(all, undefined, 4), 8);
  const stretch = { fromUs: 40, toUs: 1_000_000 };
  known = first(all, known, 4, stretch);
  assert.ok(known.items.every(({ time_us }) => time_us >= 40), names(known));
  assert.equal(known.items.length, 8);
  assert.deepEqual(within(all, { fromUs: 40, toUs: 50 }).map(key), ["12", "13", "14"]);
});

test("an answer that is whole is all", () => {
  const known = older(server(20), first(server(20), undefined, 4), 4);
  assert.deepEqual(names(first(server(3), known, 4)), ["2", "1", "0"]);
  assert.deepEqual(first([], known, 4), { items: [], next: null, stretch: STRETCH });
});

/** What came by itself, and what is in hand then. */
const live = (known, fresh, stretch = STRETCH, most = 1_000) => joined(known, fresh, stretch, most, identity);
const NOTHING = { items: [], next: null, stretch: STRETCH };

test("what comes by itself and what the history tells are one, whichever is first", () => {
  const all = server(20);
  const told = live(NOTHING, all.slice(15));
  assert.deepEqual(names(first(all, told, 4)).slice(0, 4), ["19", "18", "17", "16"]);
  let known = first(all.slice(0, 18), undefined, 100);
  known = live(known, all.slice(15));
  assert.deepEqual(new Set(names(known)), new Set(all.map(key)));
  assert.equal(known.items.length, 20);
  assert.ok(known.items.every((one, at) => at === 0 || one.time_us <= known.items[at - 1].time_us), "the newest first");
  assert.equal(live(known, all.slice(3, 7)).items, known.items, "what is known changes nothing");
});

test("what the history did not have yet is not lost by its answer", () => {
  const all = server(20);
  const latest = all.slice(18);
  let known = live(first(all.slice(0, 18), undefined, 100), latest);
  known = live(first(all.slice(0, 18), known, 100), latest);
  assert.equal(known.items.length, 20);
});

test("a report that tells more completes the one before, and neither takes anything away", () => {
  const brief = { time_us: 30, name: "a", lat: 63, age: null, raw: null };
  const full = { time_us: 30, name: "a", lat: 63, age: 0.4, raw: "$1" };
  for (const reports of [[brief, full], [full, brief], [brief, full, brief]]) {
    let known = NOTHING;
    for (const one of reports) known = live(known, [one]);
    assert.deepEqual(known.items, [full]);
    assert.deepEqual(refreshed(known, { items: [brief], next: null }, STRETCH, identity).items, [full]);
  }
});

test("one that comes late takes its place, unless that is not in hand yet", () => {
  const all = server(20);
  const late = { time_us: 35, name: "late" };
  const whole = live(first(all, undefined, 100), [late]).items;
  const at = whole.findIndex(({ name }) => name === "late");
  assert.deepEqual([whole[at - 1].time_us, whole[at + 1].time_us], [40, 30]);
  const part = first(all, undefined, 4);
  const after = live(part, [late]);
  assert.equal(after.items, part.items);
  assert.deepEqual(after.next, part.next);
  const withLate = [...all.slice(0, 12), late, ...all.slice(12)];
  let known = after;
  while (known.next) known = older(withLate, known, 4);
  assert.equal(names(known).filter((name) => name === "late").length, 1, "it comes with its neighbours");
});

test("the list is bounded: what goes is told, and comes back when asked for", () => {
  const all = server(30);
  let known = first(all.slice(0, 10), undefined, 100);
  for (const one of all.slice(10)) known = live(known, [one], STRETCH, 12);
  assert.equal(known.items.length, 12);
  assert.notEqual(known.next, null);
  while (known.next) known = older(all, known, 5);
  assert.deepEqual(new Set(names(known)), new Set(all.map(key)));
  assert.equal(known.items.length, 30);
});

test("the stretch that goes on leaves behind what it has left, and then nothing is unknown", () => {
  const all = server(20);
  const part = first(all, undefined, 4);
  const later = live(part, [], { fromUs: 60, toUs: 1_000_000 });
  assert.deepEqual(names(later), ["19", "18"]);
  assert.equal(later.next, null);
  assert.deepEqual(names(live(later, [{ time_us: 20, name: "old" }], { fromUs: 60, toUs: 1_000_000 })), ["19", "18"]);
});

test("whatever comes in whatever order, the list is what a server knows of the stretch", () => {
  let seed = 7;
  const chance = (most) => (seed = (seed * 48_271) % 2_147_483_647) % most;
  for (let run = 0; run < 200; run++) {
    const all = server(5 + chance(40));
    const told = Math.min(all.length, chance(all.length + 1));
    let known = first(all.slice(0, told), undefined, 1 + chance(30));
    for (let step = 0; step < 60; step++) {
      const at = told + chance(Math.max(1, all.length - told));
      known = live(known, all.slice(at, at + 1 + chance(3)), STRETCH, 10 + chance(40));
    }
    known = live(known, all.slice(told), STRETCH, 1_000);
    while (known.next) known = older(all, known, 1 + chance(9));
    assert.deepEqual(new Set(names(known)), new Set(all.map(key)), `run ${run}`);
    assert.equal(known.items.length, all.length, `run ${run}: none twice`);
  }
});

test("a stretch that ends with the present has what a clock ahead of it tells", () => {
  const ahead = { time_us: 1_000_500, name: "ahead" };
  assert.deepEqual(names(live(NOTHING, [ahead])), []);
  const open = { ...STRETCH, open: true };
  assert.deepEqual(names(live(NOTHING, [ahead], open)), ["ahead"]);
  assert.equal(new URLSearchParams(question(open, 4, null)).get("to_us"), "61000000");
  assert.deepEqual(within([ahead], open), [ahead]);
});

test("a detection that others confirmed since is no longer called unconfirmed", () => {
  const [alone, confirmed, live] = [{ snr_db: 5, flags: ["unconfirmed"], min_lag_s: null }, { snr_db: 5, flags: [], min_lag_s: 61 }, { snr_db: null, flags: null, min_lag_s: null }];
  assert.deepEqual(detectionCompleted(alone, confirmed), confirmed);
  assert.deepEqual(detectionCompleted(confirmed, live), confirmed, "what comes live says nothing of it");
});
