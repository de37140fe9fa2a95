// Steering by hand, decided without a screen.

import assert from "node:assert/strict";
import { test } from "node:test";
import { build } from "esbuild";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { mkdtemp } from "node:fs/promises";

const folder = await mkdtemp(join(tmpdir(), "lutra-teleop-"));
const outfile = join(folder, "teleop.mjs");
await build({ entryPoints: ["src/state/teleop.ts"], bundle: true, format: "esm", outfile, logLevel: "warning" });
const { guardOf, limited, ofKeys, ofPad, ofTouch, standing, tripText } = await import(outfile);

const told = (more) => ({ stamp_us: 1, phase: "locked", why: "", remedy: "", round_trip_ms: 40, with_vessel: true, slow: false, cap: 1, ...more });

test("keys steer only while Space is held, and opposite ones cancel each other", () => {
  assert.deepEqual(ofKeys(new Set(["KeyW", "ArrowRight"]), 7), { held: false, thrust: 1, turn: 0.5, change: 7 });
  assert.deepEqual(ofKeys(new Set(["Space", "ArrowUp", "KeyS", "KeyA"]), 8), { held: true, thrust: 0, turn: -0.5, change: 8 });
});

test("a touch steers by how far it went, a gamepad by its left stick while a trigger is held, and nonsense by nothing", () => {
  assert.deepEqual(ofTouch(50, -200, 100, 1), { held: true, thrust: 1, turn: 0.5, change: 1 });
  const pad = { index: 0, connected: true, timestamp: 12.5, axes: [0.25, -1], buttons: Array.from({ length: 8 }, (_, at) => ({ pressed: at === 5, value: 0 })) };
  assert.deepEqual(ofPad(pad), { held: true, thrust: 1, turn: 0.25, change: 12.5 });
  assert.equal(ofPad({ ...pad, buttons: [] }).held, false);
  assert.deepEqual(ofPad({ ...pad, axes: [NaN, 0.5] }), { held: true, thrust: -0.5, turn: 0, change: 12.5 });
  // The server takes 0.08 off for its dead zone: what is left of it is the share that was chosen.
  const beyond = (value) => Math.max(0, Math.abs(value) - 0.08) / 0.92;
  for (const most of [0.1, 0.4, 1]) assert.ok(Math.abs(beyond(limited(ofPad(pad), most).thrust) - most) < 1e-9, String(most));
  const hands = { held: true, thrust: 0.8, turn: 0.5, change: 1 };
  assert.ok(limited(hands, 0.1).thrust > 0.08 && limited(hands, 0.1).turn > 0.08, "what is not in neutral is not told to be");
  assert.equal(limited({ ...hands, thrust: 0.05 }, 0.1).thrust, 0.05);
});

test("why it stopped is told with what to do, and not any more while it moves", () => {
  const frozen = standing(told({ why: "the input device shows no sign of life", remedy: "Plug it in anew." }), true);
  assert.equal(frozen.why, "It stopped: the input device shows no sign of life.");
  assert.match(frozen.remedy, /^Plug it in anew\. Release the dead-man/);
  assert.match(standing(told({ phase: "ready" }), true).remedy, /^Hold the dead-man/);
  assert.deepEqual(standing(told({ phase: "steering", why: "old" }), true), { state: "MOVING. Let go to stop.", why: "", remedy: "" });
  assert.match(standing(undefined, true).state, /^STOPPED\. The server is not heard/);
  assert.match(standing(undefined, false).state, /^Connecting/);
});

test("the round trip tells what it covers, that it is slow and what it limits", () => {
  assert.equal(tripText(undefined), "Round trip: not known");
  assert.equal(tripText(told({})), "Round trip 40 ms to the vessel and back");
  assert.match(tripText(told({ round_trip_ms: 620, slow: true, cap: 0.3 })), /SLOW: steer with care\. Thrust is limited to 30 %\.$/);
  assert.match(tripText(told({ with_vessel: false })), /the vessel's part is not known/);
});

test("the guard is what the vessel's grounding supervisor says at present", () => {
  const labels = new Map([[9, "Grounding Supervisor"]]);
  const says = (description, received_us = 1_000_000) => new Map([["a", { abbrev: "EntityState", entity: 9, received_us, time_us: received_us, period_s: 1, fields: [{ name: "state", value: 1, meaning: "NORMAL" }, { name: "description", value: description }] }]]);
  const now = 1_500_000;
  assert.equal(guardOf(new Map(), labels, now), undefined);
  assert.equal(guardOf(says("off: no chart is configured"), labels, now), undefined);
  const blocks = guardOf(says("land 12 m ahead; thrust towards danger is blocked; by chart x"), labels, now);
  assert.deepEqual([blocks.blocks, blocks.lifted], [true, false]);
  assert.equal(guardOf(says("an operator may steer unguarded for 52 s; by chart x"), labels, now).lifted, true);
  assert.equal(guardOf(says("by chart x"), labels, 3_600_000_000), undefined, "what is old guards nobody");
});
