// What cards, header and STOP ALL say: `npm test` bundles the pure parts for Node and runs this.

import assert from "node:assert/strict";
import { test } from "node:test";
import { load } from "../testing/bundled.mjs";

const { alarmOf, cardOf, inPlaces } = await load("state/card");
const { doing, progressText } = await load("state/doing");
const { allToStop, press } = await load("state/stopall");
const { controlLine, endsSoon_s } = await load("state/control");
const { vitals } = await load("state/vitals");

const told = (word, more = {}) => ({ value: null, word, note: "", ageS: 0.1, old: false, ...more });
const legs = ["a", "b", "c", "d"].map((id) => ({ id }));
const fix = { lat_deg: 63.44, lon_deg: 10.4, speed_mps: 1.5, course_rad: 0, heading_rad: Math.PI / 2, time_us: 0 };
const listed = (more = {}) => ({
  system: { address: 10449, name: "otter-1", kind: "USV", liveness: "live", heard_us: 4.9e6, transports: ["link"], fix, entities: {} },
  ours: true, placeIsOld: false, placeS: 0.2, worst: undefined, parts: { text: "all parts normal", bad: false }, alarm: undefined, legs,
  vitals: { ...vitals(new Map(), new Map(), 5e6), mode: told("MANEUVER"), plan: told("EXECUTING", { note: "square" }), progress: told("", { note: "b" }), battery: told("", { value: 87.4 }) },
  ...more,
});

test("a mode is told in words of the field, and what is not reported is not made up", () => {
  assert.equal(doing(told("MANEUVER"), told("EXECUTING")), "Executing plan");
  assert.equal(doing(told("MANEUVER"), told("READY")), "Executing maneuver");
  assert.equal(doing(told("SERVICE"), told("READY")), "Ready");
  assert.equal(doing(told("ERROR"), told("READY")), "Error");
  assert.equal(doing(told("ERROR", { note: "stopped by 0x4f00" }), told("READY")), "Stopped", "nothing is wrong");
  assert.equal(doing(told("ERROR", { note: "GPS" }), told("READY")), "Error");
  assert.equal(doing(told("17"), told("")), "17", "what nobody knows stands as it came");
  assert.equal(doing(told("", { ageS: null }), told("")), "State not reported");
});

test("progress is the maneuver of all, else the share that the vessel tells, else not reported", () => {
  const plan = told("EXECUTING");
  assert.equal(progressText(plan, told("", { note: "b" }), legs), "2 of 4");
  assert.equal(progressText(plan, told("", { note: "other", value: 41.6 }), legs), "42 %");
  assert.equal(progressText(plan, told("", { note: "b" }), undefined), "not reported");
  assert.equal(progressText(told("READY"), told("", { note: "b", value: 100 }), legs), "", "of a plan that does not run nothing is told");
});

test("a card tells who, what, how far, how fast and how old", () => {
  const card = cardOf(listed(), 5e6, true);
  assert.equal(card.title, "otter-1 · USV");
  assert.deepEqual([card.doing.text, card.plan.text, card.progress.text], ["Executing plan", "square", "2 of 4"]);
  assert.deepEqual([card.speed.text, card.heading.text, card.battery.text, card.placeAge.text], ["2.9 kn", "090° T", "87 %", "0.2 s"]);
  assert.equal(card.heard, "heard 0.1 s ago by link");
  assert.equal(card.series, (10449 % 4) + 1, "the colour of the map");
  assert.ok(![card.doing, card.plan, card.speed, card.battery, card.place].some(({ old }) => old));
});

test("nothing old looks fresh on a card", () => {
  const old = cardOf(listed({ placeIsOld: true }), 5e6, true);
  assert.ok(old.place.old && old.speed.old && old.heading.old && old.placeAge.old && old.place.text.endsWith("(old)"));
  assert.ok(!old.battery.old, "what is still told is fresh");
  const deaf = cardOf(listed(), 5e6, false);
  assert.equal(deaf.link, "? not known");
  assert.equal(deaf.liveness, "lost");
  for (const name of ["doing", "plan", "progress", "speed", "heading", "battery", "place", "placeAge"]) assert.ok(deaf[name].old, name);
});

test("a card of a vessel that nobody heard says so, and an alarm comes before the state of parts", () => {
  const system = { address: 1, name: "new", kind: null, liveness: "lost", heard_us: 0, transports: [], fix: null, entities: {} };
  const card = cardOf(listed({ system, placeS: null, vitals: vitals(new Map(), new Map(), 5e6), parts: { text: "state of its parts unknown", bad: false } }), 5e6, true);
  assert.deepEqual([card.link, card.heard, card.doing.text, card.battery.text, card.speed.text, card.place.text], ["○ not heard", "not heard since the server started", "State not reported", "—", "—", "no position"]);
  assert.ok(card.worst.quiet);
  const loud = cardOf(listed({ alarm: { priority: "emergency", says: [], text: "Grounding" } }), 5e6, true);
  assert.deepEqual(loud.worst, { text: "◆ emergency: Grounding", quiet: false });
});

test("a card says which alarm is active and which is over", () => {
  const past = { vessel: 1, priority: "alarm", state: "returned", says: [], text: "Grounding" };
  const active = { vessel: 1, priority: "warning", state: "acknowledged", says: [], text: "Camera" };
  const other = { vessel: 2, priority: "emergency", state: "unacknowledged", says: [], text: "Grounding" };
  assert.equal(cardOf(listed({ alarm: past }), 5e6, true).worst.text, "▲ alarm (over): Grounding");
  assert.equal(alarmOf([other, past, active], 1), active, "what is wrong comes before what was");
  assert.equal(alarmOf([other, past], 1), past);
  assert.equal(alarmOf([other], 1), undefined);
});

test("cards keep their places, and new ones come last", () => {
  const cards = [3, 1, 2].map((address) => ({ address }));
  assert.deepEqual(inPlaces(cards, [1, 2]).map(({ address }) => address), [1, 2, 3]);
});

test("STOP ALL asks first, does not take a bounce for the answer, and forgets after five seconds", () => {
  assert.equal(press(undefined, 1_000), "ask");
  assert.equal(press(1_000, 1_100), "nothing");
  assert.equal(press(1_000, 1_600), "stop");
  assert.equal(press(1_000, 5_900), "stop");
  assert.equal(press(1_000, 6_100), "ask");
});

test("STOP ALL is about all with a name, heard or not, and of strangers about those that are heard", () => {
  const vessel = (address, liveness) => ({ address, liveness });
  const all = [vessel(1, "live"), vessel(2, "lost"), vessel(3, "late"), vessel(4, "stale")];
  assert.deepEqual(allToStop(all, { 2: "otter-2" }).map(({ address }) => address), [1, 2, 3]);
});

test("who has control is told in a few words, and is not known without the server", () => {
  const lease = { vessel: 1, holder: { name: "kari", window: "w" }, waiting: null, last: null };
  assert.equal(controlLine(lease, "other", true), "In control: kari");
  assert.equal(controlLine(lease, "here", true), "In control: you");
  const until = (until_us) => ({ ...lease, holder: { ...lease.holder, until_us } });
  assert.equal(endsSoon_s(until(60e6), 0), undefined, "renewed lately");
  assert.equal(endsSoon_s(until(60e6), 48e6), 12);
  assert.equal(endsSoon_s(until(60e6), 70e6), 0, "it may have ended");
  assert.equal(endsSoon_s(undefined, 0), undefined);
  assert.equal(controlLine(undefined, "free", true), "In control: nobody");
  assert.equal(controlLine(lease, "here", false), "In control: not known");
});
