// Missions that are told again: bundled for Node.

import assert from "node:assert/strict";
import { test } from "node:test";
import { load } from "../testing/bundled.mjs";

const { withNewestMissions } = await load("state/missions");
const { knownVessels } = await load("state/known");

test("who chooses vessels is offered those with a name and recorded ones, but no console and not the server", () => {
  const recorded = [0x2810, 0x4001, 0x4f00, 0x5fff, 0x6000].map((system) => ({ system }));
  assert.deepEqual(knownVessels({ 10448: "otter-0" }, [...recorded, { system: 10448 }]), [10448, 0x2810, 0x6000]);
  assert.deepEqual(knownVessels({ [0x4001]: "simulator" }, recorded).includes(0x4001), true, "a name says that it is a vessel");
});

const mission = (id, from_us, name = "m") => ({ id, revision: 1, mission: { name, people: "", purpose: "", notes: "", vessels: [5], from_us, to_us: null }, withdrawn: null });

test("missions that are told again come before the older ones that are known, and unchanged ones stay the same", () => {
  const before = [mission(1, 50), mission(4, 40), mission(2, 30)];
  const all = withNewestMissions(before, { missions: [mission(9, 60), mission(1, 50, "renamed"), mission(4, 40)], next: "40.4" });
  assert.deepEqual(all.map(({ id, mission: { name } }) => [id, name]), [[9, "m"], [1, "renamed"], [4, "m"], [2, "m"]]);
  assert.equal(all[2], before[1], "the same object");
  assert.deepEqual(withNewestMissions(before, { missions: [mission(9, 60)], next: null }).map(({ id }) => id), [9], "the others were withdrawn");
});
