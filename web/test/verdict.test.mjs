// What the chart says of a plan, in a few words: bundled for Node.

import assert from "node:assert/strict";
import { test } from "node:test";
import { load } from "../testing/bundled.mjs";

const { reasonInFull, verdictOf, warningWords, worstOf } = await load("state/planverdict");

const at = (lat_deg, lon_deg = 10) => ({ lat_deg, lon_deg });
const speed = { value: 1, unit: "mps" };
const path = { id: "Path 1", speed, task: { kind: "follow_path", points: [at(63), at(63.01), at(63.02)] } };
const there = { id: "Goto 1", speed, task: { kind: "goto", at: at(63.03) } };
const plan = { name: "p", description: "", vessel: null, repeat: false, maneuvers: [path, there] };
const reason = (more) => ({ maneuver: "Path 1", part: "track", from: at(63), to: at(63.01), number: 0, code: "too-shallow", text: "", ...at(63.011), depth_m: 1.2, object: null, cell: null, scale: null, margin_m: null, ...more });
const known = (guard, problems = []) => ({ kind: "known", check: { problems, warnings: [], total: {}, maneuvers: [], digest: null, guard } });
const guard = (outcome, reasons = [], warnings = []) => known({ outcome, text: "in a line", autonomous_m: 5, of_vessel: false, reasons, warnings });
const START = { maneuver: "Path 1", code: "start-unknown", text: "" };

test("a verdict is a few words", () => {
  const text = (now, least) => verdictOf(plan, now, least).text;
  assert.equal(text({ kind: "asked" }), "Checking…");
  assert.equal(text({ kind: "failed", text: "no server" }), "Not checked: no server");
  assert.equal(text(known(null)), "Not checked: no chart");
  assert.equal(verdictOf({ ...plan, maneuvers: [] }, known(null)).text, "Nothing is drawn yet");
  assert.equal(text(guard("ok")), "Safe from Path 1 on");
  assert.equal(text(guard("warnings", [], [START]), { depth_m: 6.24, place: at(63.02) }), "Safe from Path 1 on: least depth 6.2\u00a0m");
  assert.equal(text(guard("warnings", [], [START, { maneuver: "Goto 1", code: "unchecked", text: "" }])), "Partly checked: 1 warning");
  assert.equal(text(known(null, [{ maneuver: "Goto 1", text: "too fast" }])), "Cannot be sailed: 1 problem, first in Goto 1");
});

test("of what is refused the worst leg is told, with its place", () => {
  const land = reason({ maneuver: "Goto 1", part: "transit", code: "land", depth_m: null, ...at(63.025) });
  const refused = verdictOf(plan, guard("refused", [reason({}), land]));
  assert.deepEqual([refused.state, refused.text], ["unsafe", "Not safe: the way to Goto 1 crosses land, and 1 more leg"]);
  assert.deepEqual(refused.spot, { vertex: { step: 1, point: 0 }, place: at(63.025) });
  const shallow = verdictOf(plan, guard("refused", [reason({ depth_m: 2 }), reason({ number: 1, depth_m: -0.5 })]));
  assert.equal(shallow.text, "Not safe: leg 2 of Path 1 is too shallow, dries 0.5 m, and 1 more leg");
  assert.deepEqual(shallow.spot.vertex, { step: 0, point: 1 }, "the point of the path that is nearest");
  const first = verdictOf(plan, guard("refused", [reason({ part: "transit", code: "land", from: at(63), to: at(63) })]));
  assert.equal(first.text, "Not safe: Path 1 is on land");
  assert.equal(worstOf([]), undefined);
  assert.equal(verdictOf(plan, guard("refused")).text, "Not safe: in a line");
});

test("a safe plan leads to its least depth, on whose way that is", () => {
  const { spot, state } = verdictOf(plan, guard("ok"), { depth_m: 6, place: at(63.029) });
  assert.deepEqual([state, spot], ["safe", { vertex: { step: 1, point: 0 }, place: at(63.029) }]);
  assert.deepEqual(verdictOf(plan, guard("ok"), { depth_m: 6, place: at(63.011, 10.001) }).spot.vertex, { step: 0, point: 1 });
});

test("a list says also what is needed, the area and the chart", () => {
  const full = (more) => reasonInFull(plan, reason({ area: null, cell: "XX5LUTRA", ...more }));
  assert.equal(full({ margin_m: -3.8 }), "leg 1 of Path 1 is too shallow, 1.2 m; needs 5.0 m (XX5LUTRA)");
  assert.equal(full({ code: "entry-prohibited", depth_m: 9, margin_m: 4, area: "Birds" }), "leg 1 of Path 1 enters an area where entry is prohibited (Birds, XX5LUTRA)");
  assert.equal(full({ part: "circle", code: "land", depth_m: null, cell: null }), "the circle of Path 1 crosses land");
});

test("what was not checked is said by its code; a code that is not known, as the server said it", () => {
  const say = (code, about = null) => warningWords({ maneuver: "Path 1", code, about, text: "as the server said it" });
  assert.match(say("unchecked", "follow reference"), /where a follow reference leads/);
  assert.equal(say("poor-chart", "XX5LUTRA"), "deep enough by a survey of poor or unknown quality (XX5LUTRA)");
  assert.equal(say("entry-restricted", "Birds (XX5LUTRA)"), "enters an area where entry is restricted: Birds (XX5LUTRA)");
  assert.equal(say("something later"), "as the server said it");
});
