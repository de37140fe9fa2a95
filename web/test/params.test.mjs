// What the Parameters tab, the list of the fleet and the list of plans work out.

import assert from "node:assert/strict";
import { test } from "node:test";
import { join } from "node:path";
import { load } from "../testing/bundled.mjs";

const params = await load("params/model");
const copies = await load("plan/copies");
const order = await load("state/order");

const about = (more = {}) => ({ section: "S", doc: "Far ahead.", unit: "m", items: 1, min: 1, max: 50, default: "10", live: true, caution: null, ...more });
const one = (name, value, more = {}) => ({ name, value, saved: null, cut: false, time_us: 0, about: about(), ...more });
const told = (...parameters) => ({ entities: [{ entity: "Path", time_us: 0, parameters, left_out: 0 }], recorded: false });

test("a value is judged by what its parameter may be, in words", () => {
  for (const good of ["1", "50", "12.5", " 3 ", "1e1", "+2"]) assert.equal(params.problemOf(good, about()), "", good);
  for (const [bad, why] of [["", /missing/], ["  ", /missing/], ["x", /“x” is not a number/], ["0x10", /not a number/], ["Infinity", /not a number/], ["51", /51 is not within 1 to 50 m/], ["0", /not within/], ["1,2", /One number/], ["1\n2", /control/], ["y".repeat(1_001), /1000/]])
    assert.match(params.problemOf(bad, about()), why, bad);
  const three = about({ items: 3, min: 0, max: null });
  assert.equal(params.problemOf("60, 0, 0", three), "");
  assert.match(params.problemOf("60, 0", three), /3 numbers are needed, with commas between; these are 2/);
  assert.match(params.problemOf("60, -1, 0", three), /-1 is not within 0 m and more/);
  assert.equal(params.problemOf("<b>", null), "", "of another program nothing is known");
});

test("rows tell what differs, and edits what will be written", () => {
  const now = told(one("A", "12", { saved: "10" }), one("B", "10.0", { saved: "10" }), one("C", "x", { about: null }));
  let rows = params.rowsOf(now, new Map());
  assert.deepEqual(rows.map(({ unsaved, changed }) => [unsaved, changed]), [[true, true], [false, false], [null, null]]);
  let edits = params.withEdit(new Map(), params.keyOf("Path", "A"), "15", "12");
  edits = params.withEdit(edits, params.keyOf("Path", "B"), "99", "10.0");
  rows = params.rowsOf(now, edits);
  assert.deepEqual([...params.changesOf(rows)].map(([entity, of]) => [entity, of.map(params.changeText)]), [["Path", ["A: 12 → 15 m"]]], "what is wrong is not written");
  const found = (show, words) => rows.filter((row) => params.isShown(row, show, words)).map((row) => row.told.name);
  assert.deepEqual([found("all", ""), found("edited", ""), found("unsaved", ""), found("changed", "far"), found("all", "path c")], [["A", "B", "C"], ["A", "B"], ["A"], ["A"], ["C"]]);
  assert.equal(params.withEdit(edits, params.keyOf("Path", "B"), "10.0", "10.0").size, 1, "typed back is not a change");
});

test("a written value counts by what the vessel tells afterwards", () => {
  const kind = (back, stage, words = "") => params.outcomeOf("15", back, stage, words).kind;
  assert.equal(kind(one("A", "15.0"), "effect seen"), "confirmed");
  assert.equal(kind(one("A", "15"), "timed out"), "confirmed", "late, but there");
  assert.equal(kind(one("A", "12"), "effect seen"), "refused");
  assert.equal(kind(one("A", "12"), "refused", "A: too much"), "refused");
  assert.equal(kind(undefined, "expired"), "timed out");
  assert.equal(kind(undefined, "effect seen"), "timed out", "without reading back nothing is confirmed");
  assert.match(params.outcomeOf("15", one("A", "12"), "refused", "A: too much").text, /A: too much The vessel reports 12/);
});

test("a parameter in m/s is read and typed in knots, and goes back in m/s", () => {
  const limits = { unit: "m/s", min: 0.1, max: 5, default: "1" };
  const [speed] = params.rowsOf(told(one("Speed", "1.5", { saved: "1.028888889", about: about(limits) })), new Map([[params.keyOf("Path", "Speed"), " 2 "]]));
  assert.deepEqual([speed.shown.value, speed.shown.saved, speed.shown.default, speed.shown.unit, speed.shown.range], ["2.916", "2", "1.944", "kn", "0.1944 to 9.719"]);
  assert.equal(params.changeText(speed), "Speed: 2.916 → 2 kn");
  assert.equal(params.wireText(" 2 ", speed), "1.02888888889");
  assert.equal(params.wireText("2.916", speed), "1.5", "what was not changed is not changed in its last digits");
  assert.equal(params.outcomeOf("1.02888888889", one("Speed", "1.028888889", { about: about(limits) }), "effect seen", "").text, "The vessel reports 2.");
  assert.equal(params.problemOf("9.719", about(limits)), "");
  assert.match(params.problemOf("9.72", about(limits)), /9.72 is not within 0.1944 to 9.719 kn/);
  const [many] = params.rowsOf(told(one("Speeds", "0.5, x", { about: about({ ...limits, items: 2 }) })), new Map());
  assert.equal(many.shown.value, "0.5, x", "what is not a number stays as it is");
});

test("plans ashore and aboard stand side by side", () => {
  const ashore = [{ name: "a", digest: "11" }, { name: "b", digest: "22" }, { name: "draft", digest: null }];
  const plan = (plan_id, md5) => ({ plan_id, md5, size: 1, changed_us: null, changed_by: "" });
  const vessels = [
    { address: 1, name: "one", plans: { time_us: 5, plans: [plan("a", "11"), plan("b", "33"), plan("c", "44"), plan("draft", "55")] } },
    { address: 2, name: "two", plans: undefined },
    { address: 3, name: "three", plans: { time_us: 5, plans: [] } },
  ];
  const told = copies.pairs(ashore, vessels).map(({ name, copies }) => [name, ...copies.map(({ copy }) => copy)]);
  assert.deepEqual(told, [
    ["a", "same", "unknown", "only ashore"],
    ["b", "differs", "unknown", "only ashore"],
    ["c", "only aboard", "unknown", "only ashore"],
    ["draft", "differs", "unknown", "only ashore"],
  ]);
});

test("the fleet is sorted, and what is not known comes last", () => {
  const reading = (value, word = "", note = "") => ({ value, word, note, ageS: 1, old: false });
  const system = (address, name, liveness = "live", heard_us = 9) => ({ ...order.unheard(address, name), liveness, heard_us });
  const of = (system, battery, mode, state, priority) => ({
    system,
    vitals: { battery: reading(battery), mode: reading(null, mode), plan: reading(null, "", mode) },
    worst: state ? { state } : undefined,
    alarm: priority ? { priority } : undefined,
  });
  const fleet = [of(system(1, "c"), 50, "SERVICE", "NORMAL"), of(system(2, "a", "lost", 5), null, "", ""), of(system(3, "b", "late"), 20, "ERROR", "ERROR", "alarm"), of(order.unheard(4, "d"), null, "", "")];
  const names = (by) => order.inOrder(fleet, by).map((one) => one.system.name).join("");
  assert.deepEqual(["name", "worst", "heard", "battery", "mode", "plan"].map(names), ["abcd", "bcad", "dabc", "bcad", "bcad", "bcad"]);
});
