// The pure parts of replay: `npm test` bundles them for Node and runs this.

import assert from "node:assert/strict";
import { test } from "node:test";
import { load } from "../testing/bundled.mjs";

const clock = await load("replay/clock");
const then = await load("replay/then");
const fleet = await load("state/fleet");
const { csv } = await load("ui/csv");

const range = { fromUs: 1_000e6, toUs: 1_100e6 };
const play = { atUs: 1_050e6, speed: 10, playing: true };

test("it plays by its speed and stops at the end", () => {
  assert.equal(clock.advanced(play, 500, range.toUs).atUs, 1_055e6);
  assert.equal(clock.advanced({ ...play, speed: 0.1 }, 500, range.toUs).atUs, 1_050.05e6);
  assert.deepEqual(clock.advanced(play, 60_000, range.toUs), { atUs: 1_100e6, speed: 10, playing: false });
  assert.equal(clock.advanced({ ...play, playing: false }, 500, range.toUs).atUs, 1_050e6);
  assert.equal(clock.advanced(play, -5, range.toUs).atUs, 1_050e6, "a clock that jumps back stops nobody");
});

test("from the end it starts over, elsewhere it goes on", () => {
  assert.deepEqual(clock.toggled({ atUs: 1_100e6, speed: 1, playing: false }, range), { atUs: 1_000e6, speed: 1, playing: true });
  assert.deepEqual(clock.toggled({ ...play, playing: false }, range), play);
  assert.deepEqual(clock.toggled(play, range), { ...play, playing: false });
});

test("what stands still has a time within it, what follows the present has none", () => {
  assert.equal(clock.within(play, { spanUs: 5e6 }), null);
  assert.deepEqual(clock.within(null, range, 5), { atUs: range.toUs, speed: 5, playing: false });
  assert.equal(clock.within({ ...play, atUs: 7e6 }, range).atUs, range.fromUs);
});

test("zooming leaves the time where it is, and the present is not a way out of the past", () => {
  assert.deepEqual(clock.zoomedAbout(range, 1_020e6, 0.5, 9e9), { fromUs: 1_010e6, toUs: 1_060e6 });
  assert.deepEqual(clock.zoomedAbout(range, 1_020e6, 2, 1_150e6), { fromUs: 980e6, toUs: 1_150e6 });
  assert.deepEqual(clock.zoomedAbout(range, 1_020e6, 1e-9, 9e9), { fromUs: 1_019.8e6, toUs: 1_020.8e6 });
  const { fromUs, toUs } = clock.zoomedAbout(range, 1_100e6, 1e-9, 9e9);
  assert.ok(toUs - fromUs >= 1e6 && fromUs >= 0);
});

test("an address tells all of it and is read back", () => {
  const asked = { range, play: { atUs: 1_042e6, speed: 0.5, playing: false } };
  assert.deepEqual(clock.fromAddress(clock.toAddress(asked), 9e6), asked);
  const live = { range: { spanUs: 300e6 }, play: null };
  assert.deepEqual(clock.fromAddress(clock.toAddress(live), 9e6), live);
  assert.deepEqual(clock.fromAddress(new URLSearchParams(), 9e6), { range: { spanUs: 9e6 }, play: null });
  const alone = clock.fromAddress(new URLSearchParams("t=1050000000&speed=20"), 9e6);
  assert.deepEqual([alone.play.atUs, alone.play.speed, alone.range.fromUs < 1_050e6, alone.range.toUs > 1_050e6], [1_050e6, 20, true, true]);
  for (const bad of ["from=5&to=4", "from=-1&to=x", "t=NaN&speed=7", "t=1e400", "span=0", "from=&to="]) {
    assert.deepEqual(clock.fromAddress(new URLSearchParams(bad), 9e6), { range: { spanUs: 9e6 }, play: null }, bad);
  }
});

const field = (name, value) => ({ name, value, unit: "", meaning: null });
const state = (time_us) => ({
  system: 1, id: 350, abbrev: "EstimatedState", entity: 4, instance: null, time_us, received_us: 9e15, count: 0, period_s: 0.1,
  fields: [field("true_lat_deg", 63), field("true_lon_deg", 10), field("psi", 1), field("vx", 0), field("vy", 2)],
});

test("ages are those of the time itself, not since it came ashore", () => {
  const values = then.valuesThen({ time_us: 5e6, values: [state(4e6)], cut: false });
  assert.equal([...values.values()][0].received_us, 4e6);
});

test("a fast replay strikes no value while the next answer is under way, and all when it stays out", () => {
  const { freshForS } = fleet;
  for (const speed of [1, 10, 20, 100]) {
    // Asked 150 ms after the answer before, over a link whose round trip takes half a second.
    const [answeredUs, lateUs] = [1_000e6, 1_000e6 + 1.15e6 * speed];
    const playing = { atUs: lateUs, speed, playing: true };
    const asOf = then.agesCountTo(lateUs, answeredUs, playing);
    assert.equal(asOf, answeredUs, `${speed} times`);
    assert.ok((asOf - (answeredUs - 0.1e6)) / 1e6 < freshForS({ period_s: 0.1 }), "what was said ten times a second is no older");
    const values = then.valuesThen({ time_us: answeredUs, values: [state(answeredUs - 0.1e6)], cut: false });
    const place = { time_us: lateUs, lat_deg: 64, lon_deg: 11 };
    assert.equal(then.systemThen(1, "otter", values, place, lateUs, asOf).fix.heading_rad, 1, "the bow stays on the map");
    const hungUs = answeredUs + 2.5e6 * speed;
    assert.equal(then.agesCountTo(hungUs, answeredUs, { ...playing, atUs: hungUs }), hungUs, "an answer that stays out makes values old");
    assert.equal(then.agesCountTo(lateUs, answeredUs, { ...playing, playing: false }), lateUs, "what stands still is told of its own time");
  }
  assert.equal(then.agesCountTo(1_050e6, 1_000e6, null), 1_050e6, "what a plot points to too");
});

test("the vessel is where its track was, with its heading unless that is old", () => {
  const values = then.valuesThen({ time_us: 5e6, values: [state(4e6)], cut: false });
  const now = then.systemThen(1, "otter", values, { time_us: 5e6, lat_deg: 64, lon_deg: 11 }, 5e6);
  assert.deepEqual([now.fix.lat_deg, now.fix.heading_rad, now.fix.course_rad, now.fix.speed_mps, now.liveness], [64, 1, Math.PI / 2, 2, "live"]);
  const late = then.systemThen(1, "otter", values, undefined, 60e6);
  assert.deepEqual([late.fix.lat_deg, late.fix.heading_rad, late.liveness, late.heard_us], [63, null, "stale", 4e6]);
  assert.equal(then.systemThen(1, null, new Map(), undefined, 5e6).fix, null);
});

test("entities have the labels of their time", () => {
  const entities = [{ entity: 3, label: "new", from_us: 50, last_us: 90 }, { entity: 3, label: "old", from_us: 10, last_us: 40 }];
  assert.deepEqual([5, 20, 45, 50].map((us) => then.labelsThen(entities, us).get(3)), ["old", "old", "old", "new"]);
});

test("CSV keeps texts apart and hands no formula to a spreadsheet", () => {
  assert.equal(csv(["a", "b"], [["x,y", 1.5], ['say "so"', null], ["=1+1", -2], ["-5", "line\nline"]]), 'a,b\n"x,y",1.5\n"say ""so""",\n\'=1+1,-2\n\'-5,"line\nline"\n');
});
