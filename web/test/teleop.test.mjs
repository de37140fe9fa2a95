// Steering by hand, decided without a screen.

import assert from "node:assert/strict";
import { test } from "node:test";
import { load } from "../testing/bundled.mjs";

const { guardOf } = await load("state/guard");
const { isNeutral, limited, offNeutral, ofKeys, ofPad, PadLife, padText, ofTouch, standing, tripText, Vigil, VIGIL_MS, vigilText } = await load("state/teleop");

const told = (more) => ({ stamp_us: 1, phase: "locked", why: "", remedy: "", round_trip_ms: 40, with_vessel: true, slow: false, cap: 1, ...more });

test("keys steer only while Space is held, and opposite ones cancel each other", () => {
  assert.deepEqual(ofKeys(new Set(["KeyW", "ArrowRight"]), 7), { held: false, thrust: 1, turn: 0.5, change: 7 });
  assert.deepEqual(ofKeys(new Set(["Space", "ArrowUp", "KeyS", "KeyA"]), 8), { held: true, thrust: 0, turn: -0.5, change: 8 });
});

test("a touch steers by how far it went, a gamepad by its left stick while a trigger is held, and nonsense by nothing", () => {
  assert.deepEqual(ofTouch(50, -200, 100, 1), { held: true, thrust: 1, turn: 0.5, change: 1 });
  const pad = { index: 0, connected: true, timestamp: 12.5, axes: [0.25, -1], buttons: Array.from({ length: 8 }, (_, at) => ({ pressed: at === 5, value: 0 })) };
  assert.deepEqual(ofPad(pad, 12.5), { held: true, thrust: 1, turn: 0.25, change: 12.5 });
  assert.equal(ofPad({ ...pad, buttons: [] }, 1).held, false);
  assert.deepEqual(ofPad({ ...pad, axes: [NaN, 0.5] }, 12.5), { held: true, thrust: -0.5, turn: 0, change: 12.5 });
  // The server takes 0.08 off for its dead zone: what is left of it is the share that was chosen.
  const beyond = (value) => Math.max(0, Math.abs(value) - 0.08) / 0.92;
  for (const most of [0.1, 0.4, 1]) assert.ok(Math.abs(beyond(limited(ofPad(pad, 1), most).thrust) - most) < 1e-9, String(most));
  const hands = { held: true, thrust: 0.8, turn: 0.5, change: 1 };
  assert.ok(limited(hands, 0.1).thrust > 0.08 && limited(hands, 0.1).turn > 0.08, "what is not in neutral is not reported to be");
  assert.equal(limited({ ...hands, thrust: 0.05 }, 0.1).thrust, 0.05);
});

test("keys and a finger that show no change are asked for one, and count as gone 10 s after the last", () => {
  const vigil = new Vigil();
  const after = (fromMs, toMs) => {
    let said;
    for (let ms = fromMs + 50; ms <= toMs; ms += 50) said = vigil.look(ms);
    return said;
  };
  vigil.changed(5_000);
  assert.equal(after(5_000, 11_950), "alive");
  assert.equal(vigil.look(12_000), "asked");
  vigil.changed(14_990);
  assert.equal(after(14_990, 15_040), "alive", "a change renews");
  assert.equal(after(15_040, 14_990 + VIGIL_MS - 50), "asked");
  assert.equal(vigil.look(14_990 + VIGIL_MS), "gone");
  assert.equal(vigil.look(14_990 + VIGIL_MS + 60_000), "gone", "until something changes");
  // A clock that jumps is told as such by the server, and neither takes nor gives much here.
  for (const jumpMs of [3_600_000, -3_600_000]) {
    vigil.changed(0);
    assert.equal(vigil.look(jumpMs), "alive");
    assert.equal(after(jumpMs, jumpMs + VIGIL_MS), "gone");
  }
  assert.match(vigilText("keys"), /Press or let go any key.* 10 s /);
  assert.match(vigilText("touch"), /Move your finger/);
});

test("why it stopped is told with what to do, and not any more while it moves", () => {
  const frozen = standing(told({ why: "the input device shows no sign of life", remedy: "Plug it in again." }), true, true, "");
  assert.equal(frozen.why, "It stopped: the input device shows no sign of life.");
  assert.match(frozen.remedy, /^Plug it in again\. Release the dead-man/);
  assert.match(standing(told({ phase: "ready" }), true, true, "").remedy, /^Hold the dead-man/);
  assert.deepEqual(standing(told({ phase: "steering", why: "old" }), true, false, ""), { state: "STEERING. Let go to stop.", why: "", remedy: "" });
  assert.match(standing(told({ phase: "steering" }), true, true, "").state, /^HELD IN NEUTRAL\. Motors stand still/, "what is held in neutral moves nothing");
  assert.match(standing(undefined, true, true, "").state, /^STOPPED\. The server is not heard/);
  assert.match(standing(undefined, false, true, "").state, /^Connecting/);
});

test("a stick that does not rest in neutral is named, with its value and what to do", () => {
  const pad = { index: 0, connected: true, id: "worn pad", mapping: "standard", timestamp: 1, axes: [0.02, 0.131], buttons: [] };
  const stuck = offNeutral(pad);
  assert.match(stuck, /stick for ahead and astern is not in neutral.*Let go of it.*worn.*keys or touch/);
  assert.match(offNeutral({ ...pad, axes: [-0.5, 0.5] }), /stick for port and starboard and for ahead and astern/);
  assert.equal(offNeutral({ ...pad, axes: [0.08, -0.08] }), "");
  assert.equal(offNeutral({ ...pad, axes: [] }), "");
  assert.match(padText(pad), /axis 1 \(ahead and astern\) 0\.13; up to 0\.08 counts as neutral/);
  for (const phase of ["locked", "ready"]) assert.equal(standing(told({ phase }), true, false, stuck).remedy, stuck);
  assert.equal(standing(told({ phase: "steering" }), true, false, stuck).remedy, "");
  assert.ok(!isNeutral(ofPad(pad, 1)) && isNeutral({ thrust: 0.08, turn: -0.08 }));
});

test("a gamepad whose order of buttons nobody knows says so, and what is pressed", () => {
  const buttons = Array.from({ length: 8 }, (_, at) => ({ pressed: at === 2 || at === 5, value: 0 }));
  const pad = { index: 0, connected: true, id: "odd pad", mapping: "", timestamp: 1, axes: [0, 0], buttons };
  assert.match(padText(pad), /does not know the order of its buttons: numbers 4 to 7 are taken for the dead-man.*pressed now: 2, 5\./);
  assert.match(padText({ ...pad, buttons: [] }), /pressed now: none/);
  assert.doesNotMatch(padText({ ...pad, mapping: "standard" }), /does not know/);
});

test("the round trip tells what it covers, that it is slow and what it limits", () => {
  assert.equal(tripText(undefined), "Round trip: unknown");
  assert.equal(tripText(told({})), "Round trip 40 ms to the vessel and back");
  assert.match(tripText(told({ round_trip_ms: 620, slow: true, cap: 0.3 })), /SLOW: steer with care\. Thrust is limited to 30 %\.$/);
  assert.match(tripText(told({ with_vessel: false })), /the vessel's part is not known/);
});

test("the guard is what the vessel's grounding supervisor says at present", () => {
  const labels = new Map([[9, "Grounding Supervisor"]]);
  const says = (data, received_us = 1_000_000, description = "land 12 m ahead") => {
    const of = (abbrev, fields) => ({ abbrev, entity: 9, received_us, time_us: received_us, period_s: 1, fields });
    const state = of("EntityState", [{ name: "state", value: 1, meaning: "NORMAL" }, { name: "description", value: description }]);
    const event = of("Event", [{ name: "topic", value: "EntityStateValues" }, { name: "data", value: data }]);
    return new Map([["a", state], ...(data ? [["b", event]] : [])]);
  };
  const now = 1_500_000;
  assert.equal(guardOf(new Map(), labels, now), undefined);
  assert.equal(guardOf(says("on=0;blocks=0"), labels, now), undefined, "without a chart it guards nobody");
  assert.equal(guardOf(says("", 1_000_000, "thrust towards danger is blocked"), labels, now), undefined, "sentences are for people");
  const blocks = guardOf(says("on=1;blocks=1"), labels, now);
  assert.deepEqual([blocks.blocks, blocks.lifted, blocks.text], [true, false, "land 12 m ahead"]);
  assert.equal(guardOf(says("on=1;blocks=0;unguarded_s=52"), labels, now).lifted, true);
  assert.equal(guardOf(says("on=1;blocks=0"), labels, 3_600_000_000), undefined, "what is old guards nobody");
});

test("a gamepad lives by what it says, not by the moment that a browser stamps it with", () => {
  const life = new PadLife();
  const pad = (x, pressed, timestamp) => ({ index: 0, connected: true, id: "p", mapping: "standard", timestamp, axes: [x, 0], buttons: [{ pressed, value: pressed ? 1 : 0 }] });
  const first = life.look(pad(0.5, true, 1));
  assert.equal(life.look(pad(0.5, true, 2)), first, "stamped again, but it says the same");
  const moved = life.look(pad(0.501, true, 3));
  assert.notEqual(moved, first);
  assert.notEqual(life.look(pad(0.501, false, 3)), moved, "a button");
});
