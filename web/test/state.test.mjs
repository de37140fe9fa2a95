// The pure parts: `npm test` bundles them for Node and runs this.

import assert from "node:assert/strict";
import { test } from "node:test";
import { build } from "esbuild";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { mkdtemp } from "node:fs/promises";

const folder = await mkdtemp(join(tmpdir(), "lutra-web-"));
async function load(path) {
  const outfile = join(folder, `${path.replaceAll("/", "-")}.mjs`);
  await build({ entryPoints: [`src/${path}.ts`], bundle: true, format: "esm", outfile, logLevel: "warning" });
  return import(outfile);
}
const fleet = await load("state/fleet");
const { Track } = await load("state/track");
const format = await load("ui/format");

const update = (system, abbrev, value) => ({
  system, id: 1, abbrev, entity: 1, instance: null, time_us: 0, received_us: 1e6, period_s: 0.1,
  fields: [{ name: "value", value, unit: "V", meaning: null }],
});
const frame = (values, more = {}) => ({
  now_us: 5e6, snapshot: false, systems: [], values, events: [], skipped: 0, events_missed: 0, ...more,
});

test("the latest of each series stays, and a snapshot begins anew", () => {
  let state = fleet.withFrame(fleet.EMPTY, frame([update(1, "Voltage", 1), update(1, "Current", 2)], { snapshot: true }), 0);
  const before = state.values.get(1);
  state = fleet.withFrame(state, frame([update(1, "Voltage", 3)], { skipped: 7 }), 100);
  assert.equal(state.values.get(1).size, 2);
  assert.equal(state.values.get(1).get("Voltage/1/").fields[0].value, 3);
  assert.equal(before.get("Voltage/1/").fields[0].value, 1, "an earlier state does not change");
  assert.equal(state.skipped, 7);
  state = fleet.withFrame(state, frame([], { snapshot: true }), 200);
  assert.equal(state.values.size, 0);
});

test("age goes by the server's clock and goes on without it", () => {
  const state = fleet.withFrame(fleet.EMPTY, frame([]), 1_000);
  assert.equal(fleet.serverNowUs(state, 3_500), 7.5e6);
  assert.equal(fleet.ageS(update(1, "Voltage", 1), 7.5e6), 6.5);
  assert.equal(fleet.freshForS({ ...update(1, "a", 1), period_s: 1 }), 3);
  assert.equal(fleet.freshForS({ ...update(1, "a", 1), period_s: null }), 10);
});

test("events are bounded", () => {
  const events = Array.from({ length: 500 }, (_, value) => update(1, "LogBookEntry", value));
  const state = fleet.withFrame(fleet.EMPTY, frame([], { events }), 0);
  assert.equal(state.events.length, 200);
  assert.equal(state.events.at(-1).fields[0].value, 499);
});

test("a track joins what was recorded with what is live, and is bounded", () => {
  const track = new Track();
  const at = (time_us, lat_deg) => ({ time_us, lat_deg, lon_deg: 10 });
  track.add(at(10, 63.5));
  assert.equal(track.add(at(11, 63.5)), false, "it did not move");
  assert.equal(track.add(at(9, 64)), false, "it is older");
  track.recorded([at(1, 63), at(10, 63.5)]);
  assert.deepEqual(track.all().map((point) => point.time_us), [1, 10]);
  for (let time = 20; time < 100_000; time++) track.add(at(time, time / 1_000));
  assert.ok(track.all().length <= 20_000);
  assert.equal(track.all().at(-1).time_us, 99_999);
});

test("numbers are written in one way", () => {
  assert.equal(format.latitude(63.4459123), "63° 26.755′ N");
  assert.equal(format.longitude(-0.99999999), "001° 00.000′ W");
  assert.equal(format.bearing(-Math.PI / 2), "270° T");
  assert.equal(format.bearing(2 * Math.PI - 1e-9), "000° T");
  assert.equal(format.knots(1), "1.9 kn");
  assert.equal(format.age(3), "3.0 s");
  assert.equal(format.age(125), "2 min");
  const field = (value, unit = "", name = "x", meaning = null) => format.field({ name, value, unit, meaning });
  assert.deepEqual(field(Math.PI / 2, "rad"), { text: "90.0", unit: "°" });
  assert.deepEqual(field(1.1073, "rad", "lat"), { text: "63.443617", unit: "°" });
  assert.deepEqual(field(1.1073, "rad", "start_lat"), { text: "63.443617", unit: "°" });
  assert.deepEqual(field(1_795_268_766.25, "s"), { text: "1795268766.250", unit: "s" });
  assert.deepEqual(field(null, "V"), { text: "no number", unit: "V" });
  assert.deepEqual(field(3, "", "state", "Service"), { text: "Service", unit: "" });
  assert.deepEqual(field(-0.5, "m"), { text: "−0.500", unit: "m" });
  assert.equal(format.systemName({ address: 0x814, name: null }), "unknown 0x0814");
});
