// The live socket's compact form, and when the history is asked again: `npm test` runs this.

import assert from "node:assert/strict";
import { test } from "node:test";
import { constants, createDeflateRaw } from "node:zlib";
import { load } from "../testing/bundled.mjs";

const { inFull, Inflater } = await load("api/compact");
const { Behind } = await load("state/behind");

const frame = (more) => ({
  now_us: 5, snapshot: false, systems: [], values: [], series: [], samples: [], events: [], detections: [], leases: [],
  commands: [], alarms: [], skipped: 0, events_missed: 0, recording: null, ...more,
});
const VOLTAGE = { series: 0, system: 7, id: 257, abbrev: "Voltage", entity: 25, instance: null, names: ["value"], units: ["V"] };
const sample = (values, more = {}) => ({ series: 0, time_us: 1, received_us: 2, count: 3, period_s: 0.2, values, meanings: [], ...more });

test("a sample is a value of the series that was described before it", () => {
  const series = new Map();
  const first = inFull(frame({ snapshot: true, series: [VOLTAGE], samples: [sample([12.5])] }), series);
  const value = { system: 7, id: 257, abbrev: "Voltage", entity: 25, instance: null, time_us: 1, received_us: 2, count: 3, period_s: 0.2 };
  assert.deepEqual(first.values, [{ ...value, fields: [{ name: "value", value: 12.5, unit: "V", meaning: null }] }]);
  const next = inFull(frame({ samples: [sample([null], { count: 9, meanings: ["EMPTY"] })] }), series);
  assert.deepEqual(next.values, [{ ...value, count: 9, fields: [{ name: "value", value: null, unit: "V", meaning: "EMPTY" }] }]);
  // One that ended early has the first fields; one described again has more.
  assert.deepEqual(inFull(frame({ samples: [sample([])] }), series).values[0].fields, []);
  const longer = { ...VOLTAGE, names: ["value", "more"], units: ["V", ""] };
  assert.equal(inFull(frame({ series: [longer], samples: [sample([1, 2])] }), series).values[0].fields[1].name, "more");
  // After a snapshot nothing is known that it did not describe.
  assert.throws(() => inFull(frame({ snapshot: true, samples: [sample([1])] }), series), /not described/);
});

test("frames come out of the stream one for each message, with the time of their message", async () => {
  const deflate = createDeflateRaw();
  const message = (text) =>
    new Promise((done) => {
      const parts = [];
      const take = (part) => parts.push(part);
      deflate.on("data", take);
      deflate.write(text, () => deflate.flush(constants.Z_SYNC_FLUSH, () => {
        deflate.off("data", take);
        const bytes = Buffer.concat(parts);
        done(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length));
      }));
    });
  const got = [];
  let broken = 0;
  let told;
  const inflater = new Inflater((one, cameMs) => told(got.push([one.now_us, one.values[0]?.fields[0]?.value, cameMs])), () => told((broken += 1)));
  const heard = async (bytes, cameMs) => {
    const until = new Promise((done) => (told = done));
    inflater.take(bytes, cameMs);
    await until;
  };
  const long = "ø".repeat(30_000);
  await heard(await message(`${JSON.stringify(frame({ now_us: 1, snapshot: true, series: [VOLTAGE], samples: [sample([long])] }))}\n`), 10);
  await heard(await message(`${JSON.stringify(frame({ now_us: 2, samples: [sample([4])] }))}\n`), 20);
  assert.deepEqual(got.map(([us, value, cameMs]) => [us, value.length ?? value, cameMs]), [[1, long.length, 10], [2, 4, 20]]);
  // What no server sends ends it.
  await heard(new Uint8Array([255, 255, 255, 255]).buffer, 30);
  assert.ok(broken >= 1 && got.length === 2);
});

test("the history is asked again when something came that did not come by itself, and each minute", () => {
  const behind = new Behind();
  const calm = { snapshot: false, events_missed: 0, recording: null };
  const asked = (us) => {
    const due = behind.due(us);
    if (due) behind.asked(us);
    return due;
  };
  assert.ok(asked(0) && !asked(5e6));
  behind.frame(calm);
  assert.ok(!asked(10e6));
  behind.frame({ ...calm, snapshot: true });
  assert.ok(asked(15e6) && !asked(20e6));
  behind.frame({ ...calm, events_missed: 1 });
  assert.ok(asked(20e6));
  // Records that waited aboard have come, or some of them, when they are told of again.
  behind.backlog(300);
  assert.ok(!asked(25e6));
  behind.backlog(0);
  assert.ok(asked(30e6) && !asked(31e6));
  behind.backlog(0);
  assert.ok(!asked(35e6));
  // While the history lags it is asked with each turn, and once more after that.
  behind.frame({ ...calm, recording: "the disk is full" });
  behind.frame({ ...calm, recording: "the disk is full" });
  assert.ok(asked(36e6));
  behind.frame(calm);
  assert.ok(asked(37e6) && !asked(38e6));
  behind.failed();
  assert.ok(asked(39e6) && !asked(98e6) && asked(99e6));
});
