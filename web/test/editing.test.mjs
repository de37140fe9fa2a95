// A plan while it is edited: bundled for Node.

import assert from "node:assert/strict";
import { test } from "node:test";
import { build } from "esbuild";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { mkdtemp } from "node:fs/promises";

const folder = await mkdtemp(join(tmpdir(), "lutra-editing-"));
async function load(path) {
  const outfile = join(folder, `${path.replaceAll("/", "-")}.mjs`);
  await build({ entryPoints: [`src/${path}.ts`], bundle: true, format: "esm", outfile, logLevel: "warning" });
  return import(outfile);
}
const { PlanEditing } = await load("plan/editing");

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
