// Areas: lines in a polygon, and drawing one. Bundled for Node.

import assert from "node:assert/strict";
import { test } from "node:test";
import { load } from "../testing/bundled.mjs";

const [{ linesInPolygon }, { groundAt }, { PlanEditing }] = await Promise.all(["state/sweep", "state/ground", "plan/editing"].map(load));

const HOME = { lat_deg: 63.4465, lon_deg: 10.35 };
const ground = groundAt(HOME);
const at = (north, east) => ground.place([north, east]);
const metres = (places) => places.map((place) => ground.metres(place).map((one) => Math.round(one * 100) / 100 || 0));
const swept = (shape, spacing, bearing) => linesInPolygon(shape.map(([north, east]) => at(north, east)), spacing, bearing);

/** Whether a point lies within a shape. */
function inside(shape, [north, east]) {
  let odd = false;
  shape.forEach(([n, e], index) => {
    const [n2, e2] = shape[(index + 1) % shape.length];
    if (e > east !== e2 > east && north < ((n2 - n) * (east - e)) / (e2 - e) + n) odd = !odd;
  });
  return odd;
}
function distance([n, e], [[n1, e1], [n2, e2]]) {
  const [dn, de] = [n2 - n1, e2 - e1];
  const part = Math.max(0, Math.min(1, ((n - n1) * dn + (e - e1) * de) / (dn * dn + de * de || 1)));
  return Math.hypot(n - n1 - part * dn, e - e1 - part * de);
}

test("a rectangle is swept to and fro along its longer side, from near its first corner", () => {
  const { points, bearing_deg, lines } = swept([[0, 0], [100, 0], [100, 40], [0, 40]], 20);
  assert.ok(Math.min(bearing_deg, 180 - bearing_deg) < 0.001, `${bearing_deg}`);
  assert.equal(lines, 2);
  assert.deepEqual(metres(points), [[0, 10], [100, 10], [100, 30], [0, 30]]);
  assert.deepEqual(metres(swept([[0, 0], [100, 0], [100, 40], [0, 40]], 50, 90).points), [[25, 0], [25, 40], [75, 40], [75, 0]]);
});

test("no place inside is farther from a line than half the spacing along the lines' breadth", () => {
  const shapes = [
    [[0, 0], [120, 30], [90, 140], [-20, 100]],
    [[0, 0], [150, 10], [150, 160], [100, 160], [100, 60], [50, 60], [50, 160], [0, 160]],
    [[0, 0], [80, 80], [0, 160], [30, 80]],
  ];
  for (const shape of shapes) {
    for (const bearing of [undefined, 0, 37, 90]) {
      const { points } = swept(shape, 12, bearing);
      const way = points.map((place) => ground.metres(place));
      const lines = way.flatMap((point, index) => (index % 2 ? [] : [[point, way[index + 1]]]));
      for (const [from, to] of lines) assert.ok(inside(shape, [(from[0] + to[0]) / 2, (from[1] + to[1]) / 2]), "lines lie inside");
      for (let n = -20; n < 160; n += 4)
        for (let e = 0; e < 165; e += 4)
          if (inside(shape, [n, e])) assert.ok(Math.min(...lines.map((line) => distance([n, e], line))) < 12, `${n} ${e} is not covered`);
    }
  }
});

test("the arms of a polygon are swept one after the other, not line by line across the gap", () => {
  // A U that is open to the east: two arms of lines along east.
  const shape = [[0, 0], [150, 0], [150, 160], [100, 160], [100, 60], [50, 60], [50, 160], [0, 160]];
  const way = swept(shape, 10, 0).points.map((place) => ground.metres(place));
  const edges = shape.map((corner, index) => [corner, shape[(index + 1) % shape.length]]);
  const beside = (point) => !inside(shape, point) && edges.every((edge) => distance(point, edge) > 1);
  const crossings = way.slice(1).filter(([n, e], index) => beside([(way[index][0] + n) / 2, (way[index][1] + e) / 2])).length;
  assert.ok(crossings <= 1, `${crossings} legs leave the polygon`);
});

test("what has no lines says why", () => {
  assert.match(swept([[0, 0], [10, 10]], 5), /three corners/);
  assert.match(swept([[0, 0], [10, 0], [20, 0]], 5, 0), /narrow/);
  assert.match(swept([[0, 0], [5000, 0], [5000, 5000]], 0.1), /wider spacing/);
});

const plan = { name: "p", description: "", vessel: null, repeat: false, maneuvers: [] };
const editing = (writable = true) => new PlanEditing(plan, writable, { changed: () => undefined, draw: () => undefined, centre: () => HOME, reveal: () => undefined });

test("a rectangle is dragged, or two corners are clicked; then its tool is put away, and it is one step of undo", () => {
  const made = editing();
  made.press("rows_rectangle");
  const from = at(0, 0);
  for (const far of [50, 150]) made.stretch(from, at(far, 60), false);
  assert.equal(made.plan.maneuvers.length, 0);
  assert.match(made.sketch.view("rows_rectangle").told, /^4 rows of 150 m, 60 m wide; turns go 10 m beyond\.$/);
  made.stretch(from, at(200, 60), true);
  const [{ id, task }] = made.plan.maneuvers;
  assert.deepEqual([id, task.length_m, task.width_m, task.bearing_deg, task.step_m, made.tool, made.selected], ["Rows 1", 200, 60, 0, 20, undefined, { step: 0, point: 0 }]);
  made.travel(true);
  assert.deepEqual([made.plan.maneuvers.length, made.canUndo], [0, false]);
  made.press("rows_rectangle");
  [made.sketch.spacing_m, made.sketch.bearing_deg] = [7.5, 45];
  made.clicked(at(0, 0));
  made.clicked(at(100, 20));
  assert.deepEqual([made.plan.maneuvers[0].task.step_m, made.plan.maneuvers[0].task.bearing_deg], [7.5, 45]);
});

test("a slip makes no rectangle, and the next drag starts over", () => {
  const made = editing();
  made.press("rows_rectangle");
  made.stretch(at(0, 0), at(0.5, 80), true);
  assert.deepEqual([made.plan.maneuvers.length, made.tool], [0, "rows_rectangle"]);
  made.stretch(at(100, 0), at(200, 40), true);
  assert.deepEqual(metres([made.plan.maneuvers[0].task.at]), [[100, 0]]);
});

test("corners of a polygon are undone one by one, and what becomes of it as one", () => {
  const made = editing();
  made.press("lines_polygon");
  for (const [north, east] of [[0, 0], [100, 0], [100, 80]]) made.clicked(at(north, east));
  made.travel(true);
  assert.equal(made.sketch.corners.length, 2);
  assert.equal(made.finish(), false, "two corners are none");
  made.travel(false);
  made.clicked(at(0, 80));
  assert.equal(made.sketch.corners.length, 4);
  assert.ok(made.finish());
  const [{ id, task }] = made.plan.maneuvers;
  assert.deepEqual([id, task.kind, task.points.length, made.tool, made.sketch.corners.length], ["Lines 1", "follow_path", 8, undefined, 0]);
  made.travel(true);
  assert.equal(made.plan.maneuvers.length, 0);
  made.travel(false);
  assert.equal(made.plan.maneuvers.length, 1);
});

test("another tool and Escape put the area away; who may only look draws none", () => {
  const made = editing();
  made.press("lines_polygon");
  made.clicked(at(0, 0));
  made.press("goto");
  assert.deepEqual([made.sketch.corners.length, made.sketching], [0, undefined]);
  made.press("lines_polygon");
  made.clicked(at(0, 0));
  made.letGo();
  assert.deepEqual([made.sketch.corners.length, made.tool, made.canUndo], [0, undefined, false]);
  const looking = editing(false);
  looking.press("rows_rectangle");
  looking.clicked(at(0, 0));
  assert.deepEqual([looking.sketch.corners.length, looking.sketching], [0, undefined]);
});
