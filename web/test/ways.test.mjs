import assert from "node:assert/strict";
import { test } from "node:test";
import { load } from "../testing/bundled.mjs";

const { waysText, wayRows } = await load("state/ways");

const way = (name, more = {}) => ({ name, metered: false, state: "up", round_trip_ms: 12, late_per_mille: 0, rate_bytes_per_s: null, today_bytes: 1_234_567, daily_bytes: null, thinning: "nothing", failures: 0, ...more });
const link = (more = {}) => ({ up: true, ways: { live: 0, live_why: "better", records: 0, records_why: "only", ways: [way("radio"), way("4G", { metered: true, daily_bytes: 50_000_000 })], ...more } });

test("a vessel with one way has nothing to say of ways", () => {
  assert.equal(waysText(undefined), undefined);
  assert.equal(waysText({ up: true, ways: null }), undefined);
  assert.deepEqual(wayRows({ up: true, ways: null }), []);
});

test("which way, why, and how each is", () => {
  const told = waysText(link());
  assert.equal(told.word, "radio");
  assert.equal(told.note, "the fastest");
  assert.equal(told.alert, "");
  assert.deepEqual(wayRows(link()), [
    { name: "radio", state: "up", good: true, carries: "live values, commands, records", trip: "12 ms", late: "0 %", rate: "—", today: "1.2 MB" },
    { name: "4G", state: "up", good: true, carries: "standby", trip: "12 ms", late: "0 %", rate: "—", today: "1.2 of 50.0 MB" },
  ]);
});

test("a page without its link knows of no way how it is", () => {
  assert.deepEqual(wayRows(link(), false)[0], { name: "radio", state: "not known", good: false, carries: "—", trip: "—", late: "—", rate: "—", today: "1.2 MB" });
});

test("what is wrong with a way is said, and whether records go elsewhere or wait", () => {
  const ways = [way("radio", { state: "suspect", failures: 2 }), way("4G", { thinning: "most", late_per_mille: 23, rate_bytes_per_s: 120_400 })];
  const told = waysText(link({ live: 1, live_why: "failover", records: null, ways }));
  assert.equal(told.word, "4G");
  assert.equal(told.note, "another stopped answering · records wait aboard");
  assert.equal(told.alert, "warn");
  const [radio, mobile] = wayRows(link({ live: 1, live_why: "failover", records: null, ways }));
  assert.deepEqual([radio.state, radio.good, radio.carries, radio.trip, radio.late], ["does not answer", false, "standby", "—", "—"], "of a link that is not up nothing is known");
  assert.deepEqual([mobile.carries, mobile.late, mobile.rate, mobile.today], ["live values, commands", "2 %", "120 kB/s", "1.2 MB; only position, alarms and answers today"]);
  assert.equal(waysText(link({ live: 1, records: 0 })).note.split(" · ")[1], "records by radio");
  const down = waysText(link({ live: null, records: null, ways: [way("radio", { state: "down" })] }));
  assert.deepEqual([down.word, down.alert], ["none", "bad"]);
});
