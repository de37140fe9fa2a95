// A plan while it is edited: bundled for Node.

import assert from "node:assert/strict";
import { test } from "node:test";
import { load } from "../testing/bundled.mjs";

const { PlanEditing } = await load("plan/editing");
const { wholeKeyOf } = await load("plan/toolbar");

const at = (north, east = 0) => ({ lat_deg: 63 + north / 111_111, lon_deg: 10 + east / 50_000 });
const step = (id, north) => ({ id, speed: { value: 1, unit: "mps" }, task: { kind: "goto", at: at(north) } });
const plan = (...maneuvers) => ({ name: "p", description: "", vessel: null, repeat: false, maneuvers });
function editing(first, writable = true) {
  const told = { changed: 0, drawn: 0, revealed: 0 };
  const made = new PlanEditing(first, writable, { changed: () => told.changed++, draw: () => told.drawn++, centre: () => at(0), reveal: () => told.revealed++ });
  return { made, told, ids: () => made.plan.maneuvers.map(({ id }) => id) };
}

test("a click adds with the tool in hand after what is chosen, and lets go without one", () => {
  const { made, ids } = editing(plan(step("a", 0), step("b", 100)));
  made.select({ step: 0, point: 0 });
  made.press("goto");
  made.clicked(at(50));
  assert.equal(ids().length, 3);
  assert.deepEqual([ids()[0], ids()[2]], ["a", "b"]);
  assert.deepEqual(made.selected, { step: 1, point: 0 });
  made.press("goto");
  assert.equal(made.tool, undefined, "a second press puts the tool away");
  made.clicked(at(10));
  assert.equal(made.selected, undefined);
  assert.equal(ids().length, 3);
});

test("a path that is open goes on with each click", () => {
  const { made } = editing(plan());
  made.add("follow_path", at(0));
  const before = made.plan.maneuvers[0].task.points?.length ?? 0;
  made.add("follow_path", at(40));
  assert.equal(made.plan.maneuvers.length, 1);
  assert.equal(made.plan.maneuvers[0].task.points.length, before + 1);
});

test("what is done is undone and done again, and a choice that is gone is let go", () => {
  const { made, told, ids } = editing(plan(step("a", 0)));
  made.insert({ step: 0, point: 0 });
  assert.deepEqual([ids().length, made.selected.step], [2, 1]);
  made.travel(true);
  assert.deepEqual([ids(), made.selected, made.canUndo, made.canRedo], [["a"], undefined, false, true]);
  const changed = told.changed;
  made.travel(true);
  assert.equal(told.changed, changed, "there is nothing before");
  made.travel(false);
  assert.equal(ids().length, 2);
});

test("nudges that follow each other are undone as one", () => {
  const { made } = editing(plan(step("a", 0)));
  made.select({ step: 0, point: 0 });
  for (let times = 0; times < 5; times++) assert.ok(made.nudge(1, 0));
  assert.ok(Math.abs((made.plan.maneuvers[0].task.at.lat_deg - 63) * 111_111 - 5) < 0.1);
  made.travel(true);
  assert.equal(made.plan.maneuvers[0].task.at.lat_deg, 63);
  made.letGo();
  assert.equal(made.nudge(1, 0), false, "nothing is chosen");
});

test("what is chosen stays chosen when the order changes, and its neighbour when it is removed", () => {
  const { made, ids } = editing(plan(step("a", 0), step("b", 100), step("c", 200)));
  made.select({ step: 1, point: 0 });
  made.order(1, -1);
  assert.deepEqual([ids(), made.selected.step], [["b", "a", "c"], 0]);
  made.order(1, -1);
  assert.deepEqual([ids(), made.selected.step], [["a", "b", "c"], 1], "it gave way");
  made.order(0, -1);
  assert.deepEqual([ids(), made.selected.step], [["a", "b", "c"], 1], "before the first there is nothing");
  made.remove({ step: 2, point: 0 }, true);
  assert.deepEqual([ids(), made.selected], [["a", "b"], { step: 1, point: 0 }]);
  for (const _ of "ab") made.remove({ step: 0, point: 0 }, true);
  assert.deepEqual([ids(), made.selected], [[], undefined]);
});

test("a drag is drawn at once and counts when it is let go", () => {
  const { made, told } = editing(plan(step("a", 0)));
  const dragged = made.drag({ step: 0, point: 0 }, at(30), false);
  assert.equal(made.shown, dragged);
  assert.equal(made.plan.maneuvers[0].task.at.lat_deg, 63, "nothing to keep yet");
  assert.equal(told.changed, 0);
  assert.equal(made.drag({ step: 0, point: 0 }, at(40), true), undefined);
  assert.deepEqual([told.changed, made.shown === made.plan], [1, true]);
});

test("who may only look changes nothing", () => {
  const { made, told, ids } = editing(plan(step("a", 0)), false);
  made.press("goto");
  made.clicked(at(10));
  made.select({ step: 0, point: 0 });
  assert.equal(made.nudge(1, 0), false);
  assert.equal(made.drag({ step: 0, point: 0 }, at(30), true), undefined);
  assert.deepEqual(made.between({ step: 0, point: 0 }, at(5)), { step: 0, point: 0 });
  made.remove({ step: 0, point: 0 }, true);
  assert.deepEqual([ids(), told.changed], [["a"], 0]);
});

const path = (id, ...norths) => ({ id, speed: { value: 1, unit: "mps" }, task: { kind: "follow_path", points: norths.map((north) => at(north)) } });
const rows = (id) => ({ id, speed: { value: 1, unit: "mps" }, task: { kind: "rows", at: at(0), bearing_deg: 0, cross_angle_deg: 0, width_m: 40, length_m: 100, step_m: 20, curve_offset_m: 10, alternation_percent: 100, square_curve: true, curve_right: true } });
const norths = ({ task }) => (task.points ?? [task.at]).map(({ lat_deg }) => Math.round((lat_deg - 63) * 111_111));

test("a whole maneuver is pulled in one step of undo", () => {
  const { made, told } = editing(plan(path("a", 0, 100, 200), step("b", 300)));
  const before = made.plan;
  for (const north of [10, 20]) assert.equal(made.pull({ kind: "move", step: 0 }, at(100), at(100 + north), false), made.shown);
  assert.deepEqual([norths(made.shown.maneuvers[0]), made.plan, told.changed], [[20, 120, 220], before, 0]);
  made.pull({ kind: "move", step: 0 }, at(100), at(130), true);
  assert.deepEqual([norths(made.plan.maneuvers[0]), norths(made.plan.maneuvers[1]), told.changed], [[30, 130, 230], [300], 1]);
  made.travel(true);
  assert.equal(made.plan, before);
});

test("a rectangle is turned and resized by its grips", () => {
  const { made } = editing(plan(rows("a"), path("b", 0, 10)));
  made.pull({ kind: "turn", step: 0 }, at(100, 20), at(50, 200), true);
  assert.ok(Math.abs(made.plan.maneuvers[0].task.bearing_deg - 90) < 3, `${made.plan.maneuvers[0].task.bearing_deg}`);
  made.travel(true);
  made.pull({ kind: "size", step: 0 }, at(100, 40), at(200, -60), true);
  const { length_m, width_m, curve_right } = made.plan.maneuvers[0].task;
  assert.ok(Math.abs(length_m - 200) < 2 && Math.abs(width_m - 60) < 2 && !curve_right, `${length_m} ${width_m} ${curve_right}`);
  assert.equal(made.pull({ kind: "turn", step: 1 }, at(0), at(5), true), undefined, "a path has no bearing");
});

test("a copy is chosen, comes after its original and is undone as one", () => {
  const { made, ids } = editing(plan(path("Path 1", 0, 100), step("b", 300)));
  assert.ok(made.duplicate(0, 10));
  assert.deepEqual([ids(), made.selected, norths(made.plan.maneuvers[1])], [["Path 1", "Path 2", "b"], { step: 1, point: 0 }, [-10, 90]]);
  made.travel(true);
  assert.deepEqual(ids(), ["Path 1", "b"]);
  assert.equal(made.duplicate(7, 10), false);
});

test("a maneuver and a plan are turned back, and the chosen place stays chosen", () => {
  const { made, ids } = editing(plan(step("g", 0), path("a", 0, 100, 200), rows("r")));
  made.select({ step: 1, point: 0 });
  assert.ok(made.back(1));
  assert.deepEqual([norths(made.plan.maneuvers[1]), made.selected], [[200, 100, 0], { step: 1, point: 2 }]);
  assert.equal(made.back(0), false, "one place has no way back");
  assert.ok(made.allBack());
  assert.deepEqual([ids(), norths(made.plan.maneuvers[1]), made.selected], [["r", "a", "g"], [0, 100, 200], { step: 1, point: 0 }]);
  made.travel(true);
  made.travel(true);
  assert.deepEqual([ids(), norths(made.plan.maneuvers[1])], [["g", "a", "r"], [0, 100, 200]]);
});

test("the whole chosen maneuver is nudged, and quick nudges are one step", () => {
  const { made } = editing(plan(path("a", 0, 100)));
  assert.equal(made.nudgeWhole(1, 0), false, "nothing is chosen");
  made.select({ step: 0, point: 1 });
  for (let times = 0; times < 3; times++) made.nudgeWhole(10, 0);
  assert.deepEqual(norths(made.plan.maneuvers[0]), [30, 130]);
  made.travel(true);
  assert.deepEqual(norths(made.plan.maneuvers[0]), [0, 100]);
});

test("who may only look moves, copies and turns nothing", () => {
  const { made, told } = editing(plan(path("a", 0, 100)), false);
  made.select({ step: 0, point: 0 });
  assert.deepEqual([made.duplicate(0, 1), made.back(0), made.allBack(), made.nudgeWhole(1, 0)], [false, false, false, false]);
  assert.equal(made.pull({ kind: "move", step: 0 }, at(0), at(5), true), undefined);
  assert.equal(told.changed, 0);
});

test("letters copy and turn, and Shift that is locked does not turn the whole plan", () => {
  const key = (key, more = {}) => wholeKeyOf({ key, shiftKey: false, ctrlKey: false, metaKey: false, altKey: false, ...more });
  assert.deepEqual([key("d"), key("r"), key("R", { shiftKey: true })], ["duplicate", "back", "allBack"]);
  assert.deepEqual([key("R"), key("D")], ["back", "duplicate"], "with Caps Lock");
  assert.deepEqual([key("r", { ctrlKey: true }), key("d", { metaKey: true }), key("r", { altKey: true }), key("x"), key("D", { shiftKey: true })], [undefined, undefined, undefined, undefined, undefined]);
});
