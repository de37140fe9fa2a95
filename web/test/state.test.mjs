// The pure parts: `npm test` bundles them for Node and runs this.

import assert from "node:assert/strict";
import { test } from "node:test";
import { load } from "../testing/bundled.mjs";

const fleet = await load("state/fleet");
const { Track } = await load("state/track");
const format = await load("ui/format");
const plot = await load("plot/model");
const { vitals, withHeard, entities, partsInWords, worst } = await load("state/vitals");
const alarms = await load("state/alarms");
const loss = await load("state/linkloss");
const { ownPlaceText } = await load("state/ownplace");
const { placeAt } = await load("state/track");

const update = (system, abbrev, value) => ({
  system, id: 1, abbrev, entity: 1, instance: null, time_us: 0, received_us: 1e6, period_s: 0.1,
  fields: [{ name: "value", value, unit: "V", meaning: null }],
});
const frame = (values, more = {}) => ({
  now_us: 5e6, snapshot: false, systems: [], values, events: [], leases: [], commands: [], alarms: [], skipped: 0, events_missed: 0, recording: null, ...more,
});

test("the latest of each series stays, and a snapshot starts over", () => {
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
  const systems = [{ address: 10256, name: "otter-1" }, { address: 9, name: "otter-1" }, { address: 7, name: null }, { address: 8, name: "a\u202eb" }];
  assert.deepEqual(format.asCalled(systems, { 10256: "Lutra one" }).map(({ name }) => name), ["Lutra one", "otter-1", "unknown 0x0007", "ab"]);
  assert.deepEqual(format.asCalled(systems, {}).slice(0, 2).map(({ name }) => name), ["otter-1 (0x2810)", "otter-1 (0x0009)"]);
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

const said = (abbrev, entity, fields, more = {}) => ({
  system: 1, id: 1, abbrev, entity, instance: null, time_us: 0, received_us: 5e6, count: 1, period_s: 1,
  fields: Object.entries(fields).map(([name, value]) => ({ name, value, unit: "", meaning: typeof value === "string" ? value : null })), ...more,
});
const known = (...updates) => new Map(updates.map((one, index) => [String(index), one]));

test("instruments are read off the right series and grow old by their contract", () => {
  const labels = new Map([[9, "Fuel Level"], [10, "Motor Port"], [11, "Motor Starboard"], [25, "Battery 0"], [26, "Battery 1"]]);
  const values = known(
    said("EstimatedState", 6, { vx: 0, vy: 2, psi: 1 }), said("Rpm", 11, { value: 200 }), said("Rpm", 10, { value: 100 }),
    said("FuelLevel", 25, { value: 5 }), said("FuelLevel", 9, { value: 80 }),
    said("Voltage", 25, { value: 33 }), said("Voltage", 26, { value: 31 }), said("Voltage", 3, { value: 5 }),
  );
  const now = vitals(values, labels, 6e6);
  assert.equal(now.speed_mps.value, 2);
  assert.equal(now.course_rad.value, Math.PI / 2);
  assert.deepEqual([now.port_rpm.value, now.starboard_rpm.value], [100, 200]);
  assert.equal(now.battery.value, 80);
  assert.deepEqual([now.voltage.value, now.voltage.note], [31, "Battery 1"]);
  const rails = known(said("Voltage", 30, { value: 5 }), said("Voltage", 31, { value: 27 }));
  const unnamed = new Map([[30, "Rail 4"], [31, "Pack"]]);
  assert.equal(vitals(rails, unnamed, 6e6).voltage.note, "Pack", "a power rail is not a battery");
  assert.equal(now.mode.ageS, null, "what was never said has no age");
  assert.ok(!now.speed_mps.old && now.mode.old);
  assert.ok(vitals(values, labels, 8.1e6).speed_mps.old, "three periods are over");
});

test("the tag that was heard last is the newest that any message told", () => {
  const values = known({ ...said("TBRFishTag", 9, { trans_id: 7, SNR: 20 }), received_us: 5e6 });
  const read = vitals(values, new Map(), 9e6);
  const heard = (time_us) => ({ time_us, protocol_name: "OPi", protocol: null, tag_id: 103, snr_db: 30 });
  assert.equal(withHeard(read, undefined, 9e6), read);
  assert.equal(withHeard(read, heard(3e6), 9e6), read, "an older one");
  const { snr } = withHeard(read, heard(8e6), 9e6);
  assert.deepEqual([snr.value, snr.note, snr.ageS, snr.old], [30, "OPi-103", 1, false], "a coding without a number in TBRFishTag");
  assert.equal(withHeard(vitals(new Map(), new Map(), 9e6), heard(8e6), 9e6).snr.value, 30, "none before");
  const silent = known({ ...said("TBRFishTag", 9, { trans_id: 7, SNR: 0 }), received_us: 5e6 });
  assert.equal(vitals(silent, new Map(), 9e6).snr.value, null, "a receiver that does not say it, as a VR2C");
  assert.equal(withHeard(read, { ...heard(8e6), snr_db: null }, 9e6).snr.value, null);
});

test("the worst part is told, and parts that say nothing are not hidden", () => {
  const values = known(said("EntityState", 1, { state: "NORMAL", description: "" }), said("EntityState", 2, { state: "FAULT", description: "hot" }));
  const all = entities(values, new Map([[1, "a"], [2, "b"], [3, "c"]]), 5e6);
  assert.deepEqual(all.map(({ label, state }) => [label, state]), [["a", "NORMAL"], ["b", "FAULT"], ["c", ""]]);
  assert.equal(worst(all).label, "b");
});

test("a line joins history and the present and breaks where nothing was said", () => {
  const line = new plot.Line({ message: "A", entity: 1, field: "value" });
  const live = (time_us, value) => line.add(said("A", 1, { value }, { time_us }));
  live(25e6, 7);
  line.recorded({ unit: "V", width_us: 1e6, start_us: [0, 1e6, 20e6], first_us: [0, 1e6, 20e6], count: [5, 5, 1], min: [1, 2, 3], max: [3, 4, 3], mean: [2, 3, 3], first: [], last: [] }, 21e6);
  live(20e6, 9);
  live(26e6, 8);
  const [seconds, max, min, mean] = line.table(2, 5e6);
  assert.deepEqual(seconds, [0.5, 1.5, 10.75, 20, 25, 26], "the gap is one point of nothing; what the history has is not twice there");
  assert.deepEqual(mean, [4, 6, null, 6, 14, 16]);
  assert.deepEqual([max[0], min[0]], [6, 2]);
});

test("time moves, follows the present and is never empty", () => {
  const now = 1e12;
  const live = { spanUs: 60e6 };
  assert.deepEqual(plot.ends(live, now), { fromUs: now - 60e6, toUs: now });
  const back = plot.panned(live, -0.5, now);
  assert.deepEqual(back, { fromUs: now - 90e6, toUs: now - 30e6 });
  assert.deepEqual(plot.panned(back, 1, now), { spanUs: 60e6 }, "what reaches the present follows it");
  assert.deepEqual(plot.zoomed(back, 0.5, now), { fromUs: now - 75e6, toUs: now - 45e6 });
  assert.equal(plot.zoomed({ spanUs: 1e6 }, 0.1, now).spanUs, 1e6);
  assert.deepEqual(plot.parsed(plot.written({ message: "Rpm", entity: 10, field: "value" })), { message: "Rpm", entity: 10, field: "value" });
  assert.equal(plot.parsed("Rpm.x.value"), undefined);
});

test("exports hold what is shown and nothing else", () => {
  const source = (message, entity, field) => ({ message, entity, field });
  const files = plot.exports(7, [source("Rpm", 10, "value"), source("Rpm", 11, "value")], 1e6, 2e6);
  assert.equal(files.length, 1);
  const query = new URL(files[0].href, "http://x").searchParams;
  assert.deepEqual([query.get("entity"), query.get("field"), query.get("vessel")], ["10,11", "value", "7"]);
  assert.deepEqual([query.get("from"), query.get("to")], ["1970-01-01T00:00:01.000Z", "1970-01-01T00:00:02.000Z"]);
  assert.equal(plot.exports(7, [source("A", 1, "u"), source("A", 2, "v")], 0, 1e6).length, 2, "A 1 v is not shown");
});

test("a time on the track is a place between its points", () => {
  const at = (time_us, lat_deg) => ({ time_us, lat_deg, lon_deg: 10 });
  assert.equal(placeAt([at(0, 63), at(10, 64)], 5).lat_deg, 63.5);
  assert.equal(placeAt([at(0, 63)], 30e6), undefined);
  assert.equal(placeAt([], 5), undefined);
  const [gone, back] = [at(0, 63), at(600e6, 64)];
  const silence = [{ from_us: 1e6, to_us: 599e6 }];
  assert.equal(placeAt([gone, back], 300e6, silence), undefined, "nobody knows where it was");
  assert.ok(placeAt([gone, back], 2e6, silence), "but right after it was heard");
  assert.ok(placeAt([gone, at(290e6, 63), at(310e6, 63), back], 300e6, silence), "and once it told, late");
  assert.ok(placeAt([gone, back], 300e6, []), "a straight way has no points between");
});

const control = await load("state/control");

test("control and commands follow the frames of their vessel", () => {
  const command = (id, stage) => ({ id, vessel: 7, by: "nils", order: "goto", subject: "", steps: [{ stage, time_us: 1, text: "" }], over: false, plan: null, parameters: null });
  const lease = { vessel: 7, holder: { name: "nils", window: "a", since_us: 1, until_us: 2 }, waiting: null, last: null };
  let state = control.withControl(control.NO_CONTROL, frame([], { leases: [lease], commands: [command(1, "sent"), command(2, "sent")] }), 7);
  state = control.withControl(state, frame([], { commands: [command(1, "received"), { ...command(3, "sent"), vessel: 8 }] }), 7);
  assert.deepEqual(state.commands.map((one) => [one.id, one.steps[0].stage]), [[2, "sent"], [1, "received"]]);
  const all = control.withControls(new Map(), frame([], { snapshot: true, leases: [lease], commands: [{ ...command(3, "sent"), vessel: 8 }] }));
  assert.deepEqual([all.get(7).lease, all.get(8).commands.length], [lease, 1], "of all vessels from the first frame on");
  assert.equal(control.withControls(all, frame([])), all);
  assert.equal(control.withControl(state, frame([]), 7), state);
  assert.equal(control.withControl(state, frame([], { snapshot: true }), 7).lease, undefined);
  const part = (name, key, more = {}) => control.partOf({ ...lease, ...more }, name, key);
  assert.deepEqual([part("nils", "a"), part("nils", "b"), part("ada", "a"), part("ada", "a", { waiting: { name: "ada" } }), part("ada", "a", { holder: null })], ["here", "elsewhere", "other", "waiting", "free"]);
});

test("a leg has a bearing and a distance", () => {
  const { distance_m, bearing_rad } = control.legTo({ lat_deg: 63, lon_deg: 10 }, [63, 10.001]);
  assert.ok(Math.abs(distance_m - 50.48) < 0.1 && Math.abs(bearing_rad - Math.PI / 2) < 1e-4);
});

test("the own place tells its accuracy, its age where it is old, and the way to the vessel", () => {
  const own = { lat_deg: 63, lon_deg: 10, accuracy_m: 7.6, atMs: 1_000 };
  assert.equal(ownPlaceText(undefined, undefined, 0), "Waiting for this device's position …");
  assert.equal(ownPlaceText(own, undefined, 5_000), "You ±8 m");
  const vessel = { name: "otter-1", lat_deg: 63, lon_deg: 10.001 };
  assert.equal(ownPlaceText(own, vessel, 61_000), "You ±8 m, 60 s old · otter-1 50.5 m (0.027 nmi), 090° T");
});

const alarm = (id, priority, state, more = {}) => ({
  id, priority, state, says: [], since_us: id, sounded: 1, shelved: null, collapsed: null, wants_acknowledgement: state !== "acknowledged", ...more,
});

test("alarms follow the frames, the most urgent first", () => {
  const first = frame([], { snapshot: true, alarms: [alarm(1, "warning", "unacknowledged"), alarm(2, "caution", "acknowledged"), alarm(3, "alarm", "acknowledged"), alarm(4, "warning", "unacknowledged", { collapsed: "not_heard" })] });
  let known = alarms.withAlarms(alarms.NO_ALARMS, first);
  assert.deepEqual(alarms.told(known).map((one) => one.id), [3, 1, 2]);
  assert.deepEqual(alarms.counts(alarms.told(known)), { emergency: 0, alarm: 1, warning: 1, caution: 1 });
  const before = known;
  known = alarms.withAlarms(known, frame([], { alarms: [alarm(3, "alarm", "normal"), alarm(5, "emergency", "unacknowledged")] }));
  assert.deepEqual(alarms.told(known).map((one) => one.id), [5, 1, 2]);
  assert.equal(alarms.newlySounding(before, known), "emergency");
  assert.equal(alarms.newlySounding(known, known), undefined);
  assert.equal(alarms.withAlarms(known, frame([])), known, "nothing new is the same");
  known = alarms.withAlarms(known, frame([], { alarms: [alarm(1, "warning", "unacknowledged", { shelved: { by: "nils", reason: "x" } })] }));
  assert.deepEqual(alarms.told(known).map((one) => one.id), [5, 2], "put aside");
  assert.equal(alarms.withAlarms(known, frame([], { snapshot: true })).size, 0);
});

test("without the server the bar says since when alarms are not known, and never that there are none", () => {
  const top = { ...alarm(1, "warning", "unacknowledged"), vessel_name: "otter-1", text: "one motor hot" };
  assert.equal(alarms.barText(undefined, 0), "No alarms");
  assert.equal(alarms.barText(top, 0), "otter-1: one motor hot");
  // What is over does not read as if it were.
  const over = { ...top, state: "returned", since_us: 86_400e6 * 20_000 + 60e6, over_us: 86_400e6 * 20_000 + 99e6 };
  assert.equal(alarms.barText(over, 0), "otter-1: one motor hot; over since 00:01:39Z, not acknowledged");
  assert.equal(alarms.whenText(over), "from 2024-10-04 00:01:00Z to 00:01:39Z");
  assert.equal(alarms.whenText({ ...over, over_us: null }), "since 2024-10-04 00:01:00Z");
  const at = 86_400e6 * 20_000 + 3_600e6;
  assert.equal(alarms.barText(undefined, 2, at), "Alarms unknown since 01:00:00Z: the server is not reached. Last known: No alarms; 2 shelved");
  assert.match(alarms.barText(top, 0, at), /^Alarms unknown since 01:00:00Z.* Last known: otter-1: one motor hot$/);
  assert.equal(alarms.barText(undefined, 0, null), "Alarms unknown: the server is not reached");
});

test("what a vessel will do without the link is told in its own words, with the time that it gives as a number", () => {
  const now = 86_400e6 * 20_000;
  const words = "in contact; without: hold at 12:05:00 UTC";
  const state = { system: 1, abbrev: "EntityState", entity: 7, received_us: now + 2e6, time_us: now, fields: [{ name: "state", value: 1, unit: "", meaning: "NORMAL" }, { name: "description", value: words, unit: "", meaning: null }] };
  const event = (entity, time_us, data, topic = "EntityStateValues") => ({ system: 1, abbrev: "Event", entity, received_us: time_us + 2e6, time_us, fields: [{ name: "topic", value: topic }, { name: "data", value: data }] });
  const labels = new Map([[7, "Lost Communications"]]);
  const of = (...updates) => loss.linkLoss(new Map(updates.map((one, at) => [String(at), one])), labels);
  const told = of(state, event(7, now, "lost=0;due_s=300"), event(8, now + 1, "due_s=1"), event(7, now + 1, "due_s=2", "Other"));
  assert.deepEqual([told.entity, told.words, told.dueUs, told.lost], ["Lost Communications", words, now + 300e6, false], "by the vessel's clock, from its own entity and topic");
  assert.equal(of(state).dueUs, null, "no time is read out of a sentence");
  assert.equal(told.next, undefined, "an older vessel reports a sentence only");
  assert.equal(of(state, event(7, now, "lost=0;due_s=300;then=hold")).next, "hold station");
  assert.equal(of(state, event(7, now, "lost=0;due_s=19;then=run;plan=a=b")).next, "run plan a=b");
  assert.equal(of(state, event(7, now, "lost=0;then=dance")).next, undefined, "a code that this page does not know is not made up");
  const saying = (description) => ({ ...state, fields: state.fields.map((field) => (field.name === "description" ? { ...field, value: description } : field)) });
  const plain = saying("no console is heard; run plan home: in force; next: nothing further");
  const lost = of(plain, event(7, now, "lost=1;then=nothing;now=run;now_plan=home;stands=holds"));
  assert.deepEqual([lost.now, lost.next], ["It does this now: run plan home.", "do nothing further"]);
  const how = "no console is heard; run plan home: in force; returning by a route of 1.2 km around land; next: nothing further";
  assert.equal(of(saying(how), event(7, now, "lost=1;now=run;now_plan=home;stands=holds")).now, `It does this now: run plan home. Its words: ${how}.`, "how it does so only its sentence says");
  const instead = of(saying("no console is heard; hold station: run plan home is in force instead; next: nothing further"), event(7, now, "lost=1;now=run;now_plan=home;stands=outranked"));
  assert.equal(instead.now, "Another of its safeguards, as strong or stronger, is in force now: run plan home.");
  assert.match(of(state, event(7, now, "lost=1;now=hold;stands=waits")).now, /cannot at present: hold station\. Its words: in contact/);
  assert.equal(of(state, event(7, now, "lost=1;now=hold;stands=dancing")).now, undefined, "an unknown standing is not made up");
  assert.equal(of(state, event(7, now, "lost=0")).dueUs, null, "it carries on");
  assert.equal(of(state, event(7, now + 5e6, "lost=1;due_s=10"), event(7, now, "lost=0;due_s=300")).dueUs, now + 15e6, "the newest counts");
  assert.equal(loss.linkLoss(new Map(), new Map()).entity, null, "unknown is said to be");
});

const { Arrivals, Awake } = await load("state/arrival");

test("what waited on the way is as old as it is, and clocks that drift apart are no way", () => {
  const arrivals = new Arrivals();
  assert.equal(arrivals.dueMs(1_000_000, 50), 50);
  assert.equal(arrivals.dueMs(2_000_000, 1_050), 1_050);
  // Three seconds late, and then the rest of the queue at once.
  assert.ok(Math.abs(arrivals.dueMs(3_000_000, 5_050) - 2_054) < 1);
  assert.ok(Math.abs(arrivals.dueMs(5_000_000, 5_060) - 4_054) < 1);
  // Who comes sooner than any before shows the way.
  assert.equal(arrivals.dueMs(7_000_000, 5_900), 5_900);
  const drifting = new Arrivals();
  for (let second = 0; second < 36_000; second++) {
    const atMs = second * 1_000.1;
    assert.ok(atMs - drifting.dueMs(second * 1e6, atMs) < 1, String(second));
  }
});

test("sleep and a clock that is set are noticed once, slewing is not", () => {
  const awake = new Awake();
  assert.equal(awake.jumped(1_000_000, 10), false);
  assert.equal(awake.jumped(1_000_250, 260), false);
  assert.equal(awake.jumped(1_600_500, 510), true);
  assert.equal(awake.jumped(1_600_750, 760), false);
  assert.equal(awake.jumped(1_001_000, 1_010), true);
  for (let step = 1; step < 1_000; step++) assert.equal(awake.jumped(1_001_000 + step * 260, 1_010 + step * 250), false);
});

test("a place that is no longer reported is old, and without the server all is", () => {
  const system = { address: 7, liveness: "live", fix: { lat_deg: 63, lon_deg: 10 } };
  const values = new Map([["a", update(7, "EstimatedState", 1)], ["b", { ...update(7, "GpsFix", 1), received_us: 9e6 }]]);
  assert.equal(fleet.asSeen(system, values, 2.9e6, true).liveness, "live");
  // What tells best is what the place is from; another that goes on does not make it fresh.
  assert.equal(fleet.asSeen(system, values, 3.1e6, true).liveness, "stale");
  assert.equal(fleet.asSeen({ ...system, liveness: "lost" }, values, 2e6, true).liveness, "lost");
  assert.equal(fleet.asSeen(system, values, 2e6, false).liveness, "lost");
  assert.equal(fleet.asSeen(system, undefined, 9e6, true).liveness, "live");
});

test("parts that fell silent are told, and are not normal", () => {
  const part = (entity, state, old = false, description = "") => ({ entity, label: entity === 9 ? "" : `Part ${entity}`, state, description, ageS: old ? 100 : 1, old });
  assert.deepEqual(partsInWords([part(1, ""), part(2, "")]), { text: "state of its parts unknown", bad: false });
  assert.deepEqual(partsInWords([part(1, "NORMAL"), part(2, "NORMAL"), part(3, "", true)]), { text: "all parts normal", bad: false }, "who never spoke did not fall silent");
  assert.deepEqual(partsInWords([part(1, "NORMAL"), part(9, "NORMAL", true)]), { text: "1 of 2 parts silent: entity 9", bad: true });
  const four = [1, 2, 3, 4].map((entity) => part(entity, "NORMAL", entity > 1));
  assert.deepEqual(partsInWords(four), { text: "3 of 4 parts silent: Part 2, Part 3 and 1 more", bad: true });
  assert.deepEqual(partsInWords(four.map((one) => ({ ...one, old: true }))), { text: "all 4 parts silent, normal before (old)", bad: false }, "then the link is what is bad");
  assert.deepEqual(partsInWords([part(1, "ERROR", true, "hot"), part(2, "NORMAL")]), { text: "Part 1: error, hot (old) · 1 of 2 parts silent: Part 1", bad: true });
});

test("a place is as old as its arrival, whatever the vessel's clock says", () => {
  const place = { ...update(1, "EstimatedState", 1), time_us: 9e15, received_us: 4e6 };
  assert.equal(loss.linkLoss(new Map([["EstimatedState/1/", place]]), new Map()).placeUs, 4e6);
  const fix = { ...update(1, "GpsFix", 1), received_us: 6e6 };
  const both = new Map([["GpsFix/1/", fix], ["EstimatedState/1/", place]]);
  assert.equal(loss.linkLoss(both, new Map([[7, "Lost Communications"]])).placeUs, 4e6, "of what tells best");
  assert.equal(loss.linkLoss(new Map(), new Map()).placeUs, null);
});

const { fileOf, isTime, picked, pickedUs } = await load("state/takeout");

test("a fraction of a second that is typed stands in the address of the file", () => {
  const noon = 1_780_315_200_000_000;
  assert.deepEqual(["2026-06-01 12:00", "2026-06-01 12:00:00.5", "2026-06-01T12:00:00.000001Z", "2026-06-01 12:00:00.123456"].map(pickedUs), [noon, noon + 500_000, noon + 1, noon + 123_456]);
  assert.ok(!isTime("2026-06-01 12:00:00.1234567") && !isTime("2026-02-30 12:00:00.5"), "finer than a microsecond, and no day");
  const asked = (from) => new URL(fileOf({ kind: "log", message: "", vessel: "", from, to: "", angles: "deg", every_s: "", form: "csv", gzip: false }), "http://x").searchParams.get("from");
  assert.equal(asked("2026-06-01 12:00:00"), "2026-06-01T12:00:00Z");
  assert.equal(asked("2026-06-01 12:00:00.5"), "2026-06-01T12:00:00.500000Z");
  assert.equal(asked("1969-12-31 23:59:59.25"), "1969-12-31T23:59:59.250000Z");
  assert.equal(asked("tomorrow"), "tomorrow", "the server says what is wrong with it");
  assert.equal(picked(noon + 500_000), "2026-06-01 12:00:00", "a field has whole seconds");
});

test("a table is taken away as CSV or as Parquet, which is packed within", () => {
  const of = (form, gzip) => fileOf({ kind: "messages", message: "Rpm", vessel: "", from: "", to: "", angles: "rad", every_s: "", form, gzip });
  assert.equal(of("csv", true), "/api/v1/export.csv?message=Rpm&angles=rad&gzip=true");
  assert.equal(of("parquet", true), "/api/v1/export.parquet?message=Rpm&angles=rad");
});

const { stepText } = await load("state/orderwords");

test("a vessel's own words are never taken for a text of the catalogue", () => {
  globalThis.lutraWords = (english) => ({ "it was not sent": "det ble ikke sendt", "late: {why}": "sent: {why}" })[english];
  try {
    const text = "it was not sent";
    const says = { template: text, values: {} };
    assert.deepEqual([stepText({ text, says, late: false }), stepText({ text, late: false })], ["det ble ikke sendt", text]);
    assert.deepEqual([stepText({ text: `late: ${text}`, says, late: true }), stepText({ text: `late: ${text}`, late: true })], ["sent: det ble ikke sendt", `late: ${text}`]);
  } finally {
    delete globalThis.lutraWords;
  }
});
