// Whole maneuvers and rows: bundled for Node.

import assert from "node:assert/strict";
import { test } from "node:test";
import { join } from "node:path";
import { load } from "../testing/bundled.mjs";

const [rows, wholes, { groundAt }] = await Promise.all(["state/rows", "state/wholes", "state/ground"].map(load));

const HOME = { lat_deg: 63.4465, lon_deg: 10.35 };
const plainRows = { kind: "rows", at: HOME, bearing_deg: 0, cross_angle_deg: 0, width_m: 40, length_m: 100, step_m: 20, curve_offset_m: 10, alternation_percent: 100, square_curve: false, curve_right: true };
const speed = { value: 1, unit: "mps" };
const plan = (...tasks) => ({ name: "p", description: "", vessel: null, repeat: false, maneuvers: tasks.map((task, at) => ({ id: `M ${at + 1}`, speed, task })) });
const ground = groundAt(HOME);
const metres = (places) => places.map((place) => ground.metres(place));
const close = (found, wanted, within = 1e-6) => {
  assert.equal(found.length, wanted.length, JSON.stringify(found));
  found.forEach(([north, east], at) => assert.ok(Math.abs(north - wanted[at][0]) < within && Math.abs(east - wanted[at][1]) < within, `${at}: ${found[at]} in place of ${wanted[at]}`));
};
const way = (task) => metres(rows.rowsWay(task));

test("rows are laid out as the vessel does it", () => {
  // The same numbers as in crates/mission/src/maneuver/tests/pointwise.rs.
  const upAndDown = [[-10, 0], [0, 0], [110, 0], [100, 20], [-10, 20], [0, 40], [110, 40]];
  close(way(plainRows), upAndDown);
  close(way({ ...plainRows, square_curve: true }), [[-10, 0], [0, 0], [110, 0], [110, 20], [100, 20], [-10, 20], [-10, 40], [0, 40], [110, 40]]);
  close(way({ ...plainRows, alternation_percent: 50, curve_right: false }), [[-10, 0], [0, 0], [110, 0], [100, -10], [-10, -10], [0, -40], [110, -40]]);
  close(way({ ...plainRows, width_m: 19 }), [[-10, 0], [0, 0], [110, 0]]);
  close(way({ ...plainRows, bearing_deg: 90, width_m: 19 }), [[0, -10], [0, 0], [0, 110]]);
  assert.deepEqual(rows.rowsWay({ ...plainRows, step_m: 0.001, width_m: 5_000 }), [HOME], "too many");
});

test("rows lie where the server's answer puts them", () => {
  // What POST /api/v1/plans/check gave for these.
  const answer = [[63.4464223078, 10.3498997942], [63.4465, 10.35], [63.4489084595, 10.3531063784], [63.4488259921, 10.3532609648], [63.4487482998, 10.353160759], [63.4463398404, 10.3500543807], [63.4461474165, 10.3504150824], [63.4462251087, 10.3505152881], [63.4486335682, 10.3536216665]];
  const task = { ...plainRows, bearing_deg: 30, cross_angle_deg: 20, width_m: 50, length_m: 300, alternation_percent: 60, square_curve: true };
  const found = rows.rowsWay(task).map(({ lat_deg, lon_deg }) => [lat_deg, lon_deg]);
  close(found, answer, 2e-9);
});

/** A line without the points that lie on a straight stretch of it. */
function straight(points) {
  const [first, ...rest] = points.filter((point, at) => !at || Math.hypot(point[0] - points[at - 1][0], point[1] - points[at - 1][1]) > 1e-6);
  const kept = [first];
  rest.forEach((point, at) => {
    const [a, b] = [kept.at(-1), rest[at + 1]];
    const bends = b && Math.abs((point[0] - a[0]) * (b[1] - point[1]) - (point[1] - a[1]) * (b[0] - point[0])) > 1e-4;
    if (!b || bends) kept.push(point);
  });
  return kept;
}

test("rows are sailed backwards along the same lines, where that is possible", () => {
  const square = { ...plainRows, square_curve: true, bearing_deg: 33, cross_angle_deg: -20, width_m: 70 };
  for (const task of [square, { ...square, width_m: 50 }, { ...square, curve_right: false }, { ...square, alternation_percent: 40 }, { ...square, width_m: 10, alternation_percent: 40, square_curve: false, step_m: 30 }, { ...square, square_curve: false, curve_offset_m: 0 }]) {
    assert.equal(rows.whyNotBack(task), undefined);
    const back = rows.rowsBack(task);
    close(straight(way(back)), straight(way(task)).reverse(), 1e-2);
    close(straight(way(rows.rowsBack(back))), straight(way(task)), 1e-2);
  }
  assert.match(rows.whyNotBack(plainRows), /diagonal turns/);
  const uneven = { ...square, width_m: 45, alternation_percent: 50 };
  assert.equal(rows.rowsCount(uneven) % 2, 1);
  assert.match(rows.whyNotBack(uneven), /odd number/);
  assert.equal(rows.rowsBack(uneven), uneven, "and stay as they are");
});

test("a rectangle is swept from its first corner along its longer side", () => {
  const like = { kind: "rows", cross_angle_deg: 0, step_m: 20, curve_offset_m: 10, alternation_percent: 100, square_curve: true };
  const between = (north, east, bearing) => rows.rowsBetween(HOME, ground.place([north, east]), like, bearing);
  const told = ({ bearing_deg, length_m, width_m, curve_right }) => [bearing_deg, length_m, width_m, curve_right];
  assert.deepEqual(told(between(200, 60)), [0, 200, 60, true]);
  assert.deepEqual(told(between(200, -60)), [0, 200, 60, false]);
  assert.deepEqual(told(between(-200, 60)), [180, 200, 60, false]);
  assert.deepEqual(told(between(-60, 200)), [90, 200, 60, true]);
  assert.deepEqual(told(between(60, -200)), [270, 200, 60, true]);
  assert.deepEqual(told(between(60, -200, 0)), [0, 60, 200, false], "along another bearing");
  assert.equal(between(1, 200), undefined, "that was a slip");
  close(metres(rows.rowsCorners(between(200, -60))), [[0, 0], [200, 0], [200, -60], [0, -60]]);
});

test("a rectangle turns around its middle, and its far corner follows a hand", () => {
  const task = { ...plainRows, width_m: 60, length_m: 200, bearing_deg: 350 };
  const turned = rows.rowsTurned(task, 40);
  assert.equal(turned.bearing_deg, 30);
  close(metres([rows.rowsCentre(turned)]), metres([rows.rowsCentre(task)]), 1e-2);
  const by = rows.turnBetween(task, rows.rowsHead(task), rows.rowsHead(turned));
  assert.ok(Math.abs(((by + 540) % 360) - 180 - 40) < 0.01, `${by}`);
  for (const cross_angle_deg of [0, 25]) {
    const slanted = { ...task, cross_angle_deg };
    const corner = rows.rowsCorners({ ...slanted, length_m: 120, width_m: 45.5 })[2];
    const sized = rows.rowsTo(slanted, corner);
    assert.deepEqual([sized.length_m, sized.width_m, sized.curve_right], [120, 45.5, true]);
    const other = rows.rowsTo(slanted, rows.rowsCorners({ ...slanted, length_m: 120, width_m: 45.5, curve_right: false })[2]);
    assert.deepEqual([other.length_m, other.width_m, other.curve_right], [120, 45.5, false], "over to the other side");
  }
});

const at = (north, east) => ground.place([north, east]);
const path = { kind: "follow_path", points: [at(0, 0), at(100, 0), at(100, 50)] };

test("a maneuver moves with all its points, and keeps its shape", () => {
  for (const [north, east] of [[30, -20], [90_000, 4_000]]) {
    const moved = wholes.withMoved(plan(path, plainRows), 0, HOME, at(north, east));
    const there = groundAt(moved.maneuvers[0].task.points[0]);
    close(moved.maneuvers[0].task.points.map((point) => there.metres(point)), [[0, 0], [100, 0], [100, 50]], 2e-2);
    close(metres([moved.maneuvers[0].task.points[0]]), [[north, east]], 2e-2);
    assert.deepEqual(moved.maneuvers[1].task, plainRows, "the others stay");
  }
  const moved = wholes.withMovedBy(plan(plainRows), 0, [10, 0]);
  close(way(moved.maneuvers[0].task), way(plainRows).map(([n, e]) => [n + 10, e]), 2e-2);
});

test("a copy has a name of its own and lies beside", () => {
  const two = wholes.withCopy(plan(path, plainRows), 0, 12);
  assert.deepEqual(two.maneuvers.map(({ id }) => id), ["M 1", "M 3", "M 2"]);
  close(metres(two.maneuvers[1].task.points), [[-12, 12], [88, 12], [88, 62]], 2e-2);
  const long = "Ålesund ".repeat(7).trim();
  const named = wholes.withCopy({ ...plan(path), maneuvers: [{ id: long, speed, task: path }] }, 0, 5);
  const [, copy] = named.maneuvers;
  assert.ok(new TextEncoder().encode(copy.id).length <= 60 && copy.id !== long, copy.id);
  const once = plan(path);
  assert.equal(wholes.withCopy(once, 4, 5), once);
});

test("paths, rows and circles have a way back; single places have none", () => {
  const loiter = { kind: "loiter", at: HOME, radius_m: 20, duration_s: 60, clockwise: true };
  const all = plan(path, { kind: "goto", at: HOME }, loiter, { ...plainRows, square_curve: true });
  assert.deepEqual(wholes.withBack(all, 0).maneuvers[0].task.points, [...path.points].reverse());
  assert.equal(wholes.withBack(all, 1), all);
  assert.equal(wholes.withBack(all, 2).maneuvers[2].task.clockwise, false);
  assert.deepEqual(wholes.withBack(wholes.withBack(all, 0), 0), all);
  const back = wholes.withAllBack(all);
  assert.deepEqual(back.maneuvers.map(({ id }) => id), ["M 4", "M 3", "M 2", "M 1"]);
  assert.deepEqual([back.maneuvers[0].task.bearing_deg, back.maneuvers[1].task.clockwise], [180, true]);
  const twice = wholes.withAllBack(back);
  assert.deepEqual(twice.maneuvers[0], all.maneuvers[0]);
  close(way(twice.maneuvers[3].task), way(all.maneuvers[3].task), 2e-2);
});

test("what one takes hold of lies beside what it moves", () => {
  const all = plan(path, { kind: "goto", at: HOME }, { kind: "loiter", at: HOME, radius_m: 20, duration_s: 60, clockwise: true }, plainRows);
  assert.deepEqual([0, 1, 2, 3, 9].map((step) => wholes.gripsOf(all, step).map(({ kind }) => kind).join()), ["move", "", "move", "move,turn,size", ""]);
  close(metres([wholes.gripsOf(all, 0)[0].place]), [[0, 50]], 1e-3);
});
