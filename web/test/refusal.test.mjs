// Where an order was refused: by the codes and places of the refusal itself.

import assert from "node:assert/strict";
import { test } from "node:test";
import { load } from "../testing/bundled.mjs";

const { legsOfGoto, refusalText, spotsOf } = await load("state/refusal");

const at = (lat_deg, lon_deg) => ({ lat_deg, lon_deg });
const reason = (more = {}) => ({ maneuver: "P2", part: "transit", number: 0, from: at(63.44, 10.34), to: at(63.44, 10.36), code: "too-shallow", text: "", lat_deg: 63.44, lon_deg: 10.35, depth_m: 2.5, object: "DEPARE", area: null, cell: "XX5LUTRA", scale: 12_000, margin_m: -2.5, ...more });
const plan = { name: "p", description: "", vessel: 5, repeat: false, maneuvers: [{ id: "P2", speed: { value: 1, unit: "mps" }, task: { kind: "goto", at: at(63.44, 10.36) } }] };

test("a verdict gives leg, spot and words of each refused leg", () => {
  const [one, turn] = spotsOf([reason(), reason({ part: "circle", code: "land", depth_m: null })], plan);
  assert.deepEqual(one, { text: "the way to P2 is too shallow, 2.5 m", label: "too shallow, 2.5 m", place: at(63.44, 10.35), from: at(63.44, 10.34), to: at(63.44, 10.36) });
  assert.deepEqual([turn.label, turn.from], ["land", undefined], "a circle is not a line");
  assert.deepEqual(spotsOf([]), []);
});

test("of a leg that only a vessel told, the spot is known and no line", () => {
  const [told] = spotsOf([reason({ part: "track", number: 2, from: null, to: null })]);
  assert.deepEqual(told, { text: "leg 3 of P2 is too shallow, 2.5 m", label: "too shallow, 2.5 m", place: at(63.44, 10.35) });
  assert.equal(spotsOf([reason({ from: null, to: null })])[0].text, "the way to P2 is too shallow, 2.5 m");
});

test("a refusal is said by its code; without one, as the server said it", () => {
  const guard = { outcome: "refused", cause: null, text: "in a line", reasons: [reason(), reason({ code: "land", depth_m: null })], warnings: [] };
  const said = (more) => refusalText({ code: "x", text: "as the server said it", ...more });
  assert.equal(said({ guard }), "The chart shows danger: the way to P2 crosses land, and 1 more leg");
  assert.equal(said({ guard: { ...guard, reasons: [], cause: "too-large" } }), "The chart shows danger: the plan is too large to be checked against the chart; split it");
  assert.equal(said({ guard: { ...guard, reasons: [], cause: "something later" } }), "The chart shows danger: in a line");
  assert.equal(said({ control: { why: "held", by: "kari" } }), "You do not have control of this vessel: kari has it.");
  assert.equal(said({}), "as the server said it");
});

test("every reason for no control has its own words", () => {
  const all = [{ why: "free" }, { why: "held", by: "a" }, { why: "other_window" }, { why: "expired" }, { why: "nobody_waits" }, { why: "asked", by: "a", within_s: 30 }, { why: "reason_needed", by: "a" }, { why: "too_long", most: 200 }];
  assert.equal(new Set(all.map((control) => refusalText({ code: "no_control", text: "", control }))).size, all.length);
});

test("of an order to go somewhere the way is said, and the place itself once", () => {
  const legs = legsOfGoto([reason({ maneuver: "go", code: "land", depth_m: null }), reason({ maneuver: "stay", from: at(63.4, 10.3), to: at(63.4, 10.3) }), reason({ maneuver: "stay", part: "station" })]);
  assert.deepEqual(spotsOf(legs).map(({ text }) => text), ["the way to the chosen place crosses land", "the chosen place is too shallow, 2.5 m"]);
  assert.equal(spotsOf(legsOfGoto([reason({ maneuver: "go" })])).length, 1);
});
