import assert from "node:assert/strict";
import { test } from "node:test";
import { load } from "../testing/bundled.mjs";

const { readiness } = await load("state/readiness");

const part = (label, state, description = "", more = {}) => ({ entity: 1, label, state, description, ageS: 0.2, old: false, ...more });
const link = (more = {}) => ({ up: true, backlog_records: 0, backlog_age_s: 0, chart: { state: "same", text: "up to date", digest: "07", difference: null }, ...more });

test("a vessel whose parts are all normal is ready", () => {
  const { grade, verdict, remarks } = readiness([part("GPS", "NORMAL"), part("Preflight", "NORMAL"), part("unheard", "")], link());
  assert.deepEqual([grade, verdict, remarks], ["good", "Ready to sail", []]);
});

test("what stands against it comes with what to do, the worst first", () => {
  const { grade, verdict, remarks } = readiness([
    part("Clock", "FAULT", "-15.0 ms off the satellites"),
    part("Preflight", "BOOT", "the motors are not armed; missing: heading"),
    part("Motor Port", "ERROR", "nothing from the motor card: check its power"),
  ], link({ chart: { state: "other", text: "", digest: "07", difference: { stage: "other" } } }));
  assert.deepEqual([grade, verdict], ["bad", "Not ready to sail"]);
  assert.deepEqual(remarks.map(({ part }) => part), ["Motor Port", "Clock", "Sea chart", "Preflight"]);
  assert.equal(remarks[0].says, "nothing from the motor card: check its power");
});

test("a remark alone does not keep it ashore, and what only starts is not ready yet", () => {
  assert.equal(readiness([part("Clock", "FAULT", "x"), part("GPS", "NORMAL")], undefined).verdict, "Ready to sail, with one remark");
  assert.equal(readiness([part("Preflight", "BOOT", "missing: position")], undefined).verdict, "Not ready yet");
});

test("old states say nothing, and one that fell silent is told", () => {
  assert.equal(readiness([part("GPS", "NORMAL", "", { old: true })], undefined).grade, "unknown");
  assert.equal(readiness([], link()).grade, "unknown");
  const { remarks } = readiness([part("GPS", "NORMAL", "", { old: true }), part("Clock", "NORMAL")], undefined);
  assert.deepEqual(remarks.map(({ part, says }) => [part, says]), [["GPS", "does not report any more"]]);
});

test("a link that is down or slow is told", () => {
  const one = (more) => readiness([part("GPS", "NORMAL")], link(more)).remarks.map(({ says }) => says);
  assert.match(one({ up: false })[0], /is down/);
  assert.deepEqual(one({ backlog_age_s: 90, backlog_records: 400 }), ["400 records wait aboard"]);
  assert.deepEqual(one({ backlog_age_s: 10, backlog_records: 4 }), []);
});
