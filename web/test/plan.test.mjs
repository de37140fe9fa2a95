// The pure parts of the plan editor.

import assert from "node:assert/strict";
import { test } from "node:test";
import { load } from "../testing/bundled.mjs";

const state = await load("state/plan");
const units = await load("state/units");

const SPEED = { value: 1.5, unit: "mps" };
const at = (lat_deg, lon_deg) => ({ lat_deg, lon_deg });
const empty = { name: "p", description: "", vessel: null, repeat: false, maneuvers: [] };
/** A Goto, a path of three points, a Goto. */
function drawn() {
  let plan = state.withNew(empty, "goto", at(63.44, 10.4), SPEED);
  plan = state.withNew(plan, "follow_path", at(63.45, 10.4), SPEED);
  plan = state.withPoint(plan, { step: 1, point: 1 }, at(63.46, 10.4));
  plan = state.withPoint(plan, { step: 1, point: 2 }, at(63.47, 10.4));
  return state.withNew(plan, "goto", at(63.48, 10.4), SPEED);
}
const ids = (plan) => plan.maneuvers.map((step) => step.id);

test("angles are read as people type them", () => {
  for (const [text, axis, deg] of [
    ["63.44", "lat", 63.44],
    ["-63,44", "lat", -63.44],
    ["−63.44", "lat", -63.44],
    ["63.44 N", "lat", 63.44],
    ["s 63.5", "lat", -63.5],
    ["63° 26.4′ N", "lat", 63.44],
    ["63 26 24", "lat", 63.44],
    ["010° 24′ 0″ W", "lon", -10.4],
    ["10:24", "lon", 10.4],
    ["180", "lon", 180],
    ["0", "lat", 0],
  ])
    assert.equal(units.readAngle(text, axis), deg, text);
  for (const [text, axis] of [["", "lat"], ["91", "lat"], ["181", "lon"], ["63 61", "lat"], ["63.5 20", "lat"], ["10 E", "lat"], ["-10 N", "lat"], ["1e1", "lat"], ["abc", "lon"], ["1 2 3 4", "lon"], ["NaN", "lat"], ["--5", "lat"]])
    assert.equal(units.readAngle(text, axis), undefined, text);
});

test("what is written is read again", () => {
  for (const deg of [0, 63.4400001, -63.9999999, 89.99999, -0.00001])
    for (const axis of ["lat", "lon"]) {
      assert.ok(Math.abs(units.readAngle(units.writeAngle(deg, axis, true), axis) - deg) < 1e-6, `${deg}`);
      assert.equal(units.readAngle(units.writeAngle(deg, axis, false), axis), deg);
    }
  assert.equal(units.writeAngle(-10.4, "lon", true), "010° 24.0000′ W");
});

test("maneuvers get names of their own", () => {
  assert.deepEqual(ids(drawn()), ["Goto 1", "Path 1", "Goto 2"]);
  const without = state.withoutStep(drawn(), 0);
  assert.deepEqual(ids(state.withNew(without, "goto", at(1, 1), SPEED)), ["Path 1", "Goto 2", "Goto 1"]);
});

test("a place between two is a point of a path, and a Goto between maneuvers", () => {
  const inside = state.withBetween(drawn(), { step: 1, point: 0 }, at(63.455, 10.5));
  assert.deepEqual(inside.vertex, { step: 1, point: 1 });
  assert.equal(inside.plan.maneuvers[1].task.points.length, 4);
  const outside = state.withBetween(drawn(), { step: 1, point: 2 }, at(63.475, 10.5));
  assert.deepEqual([outside.vertex, ids(outside.plan)], [{ step: 2, point: 0 }, ["Goto 1", "Path 1", "Goto 3", "Goto 2"]]);
});

test("the last point of a path takes the maneuver along", () => {
  let plan = drawn();
  for (const left of [2, 1]) {
    plan = state.withoutVertex(plan, { step: 1, point: 0 });
    assert.equal(plan.maneuvers[1].task.points.length, left);
  }
  assert.deepEqual(ids(state.withoutVertex(plan, { step: 1, point: 0 })), ["Goto 1", "Goto 2"]);
});

test("the way of a plan goes once round its circles", () => {
  const circling = state.withNew(drawn(), "loiter", at(63.49, 10.4), SPEED);
  const { task } = circling.maneuvers.at(-1);
  const round = state.wayOfAll(circling, []).slice(state.wayOfAll(drawn(), []).length);
  assert.ok(round.length > 12 && JSON.stringify(round[0]) === JSON.stringify(round.at(-1)), "it ends where it began");
  for (const place of round) {
    const [north, east] = [(place.lat_deg - 63.49) * 111_195, (place.lon_deg - 10.4) * 111_195 * Math.cos((63.49 * Math.PI) / 180)];
    assert.ok(Math.abs(Math.hypot(north, east) - task.radius_m) < 0.5, `${north} ${east} of ${task.radius_m}`);
  }
  assert.equal(round[1].lon_deg > 10.4, task.clockwise, "the way round that was chosen");
});

test("order changes within the plan only", () => {
  const plan = drawn();
  assert.deepEqual(ids(state.withOrder(plan, 2, -1)), ["Goto 1", "Goto 2", "Path 1"]);
  assert.equal(state.withOrder(plan, 0, -1), plan);
  assert.equal(state.withOrder(plan, 2, 1), plan);
});

test("places stay on earth", () => {
  assert.deepEqual(state.displaced(at(89.999999, 179.9999999), 1_000, 1_000).lat_deg, 90);
  assert.ok(Math.abs(state.displaced(at(0, 179.9999), 0, 100).lon_deg + 179.9992) < 1e-3);
  const north = state.displaced(at(63.44, 10.4), 10, 0);
  assert.ok(Math.abs((north.lat_deg - 63.44) * 111_195 - 10) < 0.02);
});

test("undo and redo go through all states, quick nudges together", () => {
  const history = new state.History(empty);
  const plans = [empty];
  for (let at = 0; at < 3; at++) {
    history.push({ ...empty, name: `p${at}` }, "name", at * 100);
    plans.push(history.plan);
  }
  history.push({ ...empty, name: "late" }, "name", 9_000);
  assert.ok(history.undo());
  assert.equal(history.plan, plans[3]);
  assert.ok(history.undo() && !history.undo());
  assert.equal(history.plan, empty);
  assert.ok(history.redo() && history.redo() && !history.redo());
  assert.equal(history.plan.name, "late");
  history.undo();
  history.push({ ...empty, name: "other" });
  assert.ok(!history.canRedo && history.canUndo);
  for (let at = 0; at < 500; at++) history.push({ ...empty, name: `n${at}` });
  let steps = 0;
  while (history.undo()) steps++;
  assert.equal(steps, 200);
});

test("plans are compared by what they say", () => {
  const plan = drawn();
  assert.ok(state.same(plan, JSON.parse(JSON.stringify(plan))));
  assert.ok(state.same({ a: 1, b: [{ c: null }] }, { b: [{ c: null }], a: 1 }));
  for (const [one, other] of [[{ a: 1 }, { a: 1, b: undefined }], [[1], { 0: 1 }], [{ a: null }, { a: 0 }], [[1, 2], [2, 1]], [plan, state.withoutStep(plan, 0)]]) assert.ok(!state.same(one, other));
});
