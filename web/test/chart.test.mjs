// What a chart shows, decided without drawing.

import assert from "node:assert/strict";
import { test } from "node:test";
import { load } from "../testing/bundled.mjs";

const chart = await load("state/chart");

const LIMITS = { navigable_m: 1, autonomous_m: 5 };

test("shades are parted by the limits, and what is not known is the worst of waters", () => {
  for (const [depth, shade] of [[-0.1, "drying"], [0, "very-shallow"], [0.9, "very-shallow"], [1, "shallow"], [4.9, "shallow"], [5, "safe"], [19.9, "safe"], [20, "deep"], [undefined, "unknown"]]) {
    assert.equal(chart.shadeOf(depth, LIMITS), shade, String(depth));
  }
  assert.equal(chart.shadeOf(25, { navigable_m: 1, autonomous_m: 15 }), "safe");
});

test("the safety contour is the shallowest charted one that is deep enough", () => {
  assert.equal(chart.safetyContour([0, 2, 5, 10], LIMITS), 5);
  assert.equal(chart.safetyContour([0, 2, 10, 20], LIMITS), 10);
  assert.equal(chart.safetyContour([0, 2], LIMITS), undefined);
});

test("a safety depth may be chosen, and never one that the guard would not take", () => {
  for (const [chosen, safe] of [[null, 5], ["", 5], [" ", 5], ["8.5", 8.5], ["3", 5], ["-1", 5], ["Infinity", 5], ["1e9", 5], ["deep", 5]]) {
    assert.deepEqual(chart.drawnLimits(LIMITS, chosen), { navigable_m: 1, autonomous_m: safe }, String(chosen));
  }
});

test("what is drawn goes by both guards, the vessel's own as it told it", () => {
  const told = (...parameters) => ({ recorded: false, entities: [{ entity: "Grounding Supervisor", parameters: parameters.map(([name, value]) => ({ name, value })) }] });
  assert.equal(chart.ownLimits({ recorded: false, entities: [] }), undefined);
  assert.equal(chart.ownLimits(told(["Navigable Depth", "1"], ["Autonomous Depth", ""])), undefined);
  const own = chart.ownLimits(told(["Navigable Depth", "0.5"], ["Autonomous Depth", " 8 "]));
  assert.deepEqual(own, { navigable_m: 0.5, autonomous_m: 8 });
  assert.deepEqual(chart.guarded(LIMITS, own), { navigable_m: 1, autonomous_m: 8 });
  assert.deepEqual(chart.guarded(LIMITS, undefined), LIMITS);
});

test("a danger is an isolated one in otherwise safe water only", () => {
  for (const [depth, watlev, around, isolated] of [
    [2, 3, 10, true],
    [2, 3, 5, true],
    [2, 3, 3, false],
    [2, 3, undefined, false],
    [5, 3, 10, true],
    [5.1, 3, 10, false],
    [undefined, 3, 10, true],
    [undefined, undefined, 10, true],
    [undefined, undefined, 0, false],
  ]) {
    assert.equal(chart.isIsolated(depth, watlev, around, LIMITS), isolated, `${depth} m in ${around} m`);
  }
  assert.equal(chart.isIsolated(2, 3, 3, { navigable_m: 1, autonomous_m: 3 }), true);
});

test("soundings are whole metres with decimals set low, never deeper than charted", () => {
  for (const [depth, text] of [[4.5, "4₅"], [0, "0"], [0.4, "0₄"], [30.9, "30₉"], [31.9, "31"], [4.99, "4₉"], [12, "12"], [2.3, "2₃"], [-1.5, "1\u0332₅"], [-12, "1\u03322\u0332"]]) {
    assert.equal(chart.soundingText(depth), text, String(depth));
  }
});

test("bars mark what is overscale beside a better chart, not a picture that is overscale all over", () => {
  const shown = 4_000;
  assert.equal(chart.isBarred(12_000, 12_000, shown), false, "all of it is, and the words say so");
  assert.equal(chart.isBarred(50_000, 12_000, shown), true, "coarser than another part");
  assert.equal(chart.isBarred(50_000, 12_000, 40_000), false, "coarser, but not overscale");
  assert.equal(chart.isBarred(12_000, undefined, shown), false, "nothing is known yet");
});

test("a chart is overscale from twice its scale on", () => {
  const at = (scale) => (scale * 0.00028) / Math.cos((60 * Math.PI) / 180);
  const shown = chart.shownScale(at(12_000), 60);
  assert.ok(Math.abs(shown - 12_000) < 1e-6);
  assert.equal(chart.isOverscale(12_000, shown), false);
  assert.equal(chart.isOverscale(23_999, shown), false);
  assert.equal(chart.isOverscale(24_001, shown), true);
  assert.equal(chart.isOverscale(0, shown), false);
  assert.equal(chart.isOverscale(undefined, shown), false);
});

test("colours come as codes or as words", () => {
  assert.deepEqual(chart.colourWords("3,1,3"), ["red", "white", "red"]);
  assert.deepEqual(chart.colourWords("Black, yellow"), ["black", "yellow"]);
  assert.deepEqual(chart.colourWords(4), ["green"]);
  assert.deepEqual(chart.colourWords("99,,x"), []);
  assert.deepEqual(chart.colourWords(undefined), []);
});

test("shapes of buoys come as numbers or as words", () => {
  for (const [shape, number] of [[1, 1], ["2", 2], ["conical (nun, ogival)", 1], ["can (cylindrical)", 2], ["spar (spindle)", 5], ["super-buoy", 7], ["post", 0], [undefined, 0]]) {
    assert.equal(chart.buoyShape(shape), number, String(shape));
  }
});

test("a reason belongs to the nearest stretch", () => {
  const place = (lat_deg, lon_deg) => ({ lat_deg, lon_deg });
  const line = [place(63, 10), place(63, 10.1), place(63.1, 10.1)];
  assert.equal(chart.nearestStretch(line, place(63.001, 10.05)), 0);
  assert.equal(chart.nearestStretch(line, place(63.05, 10.101)), 1);
  assert.equal(chart.nearestStretch([place(63, 10)], place(63, 10)), undefined);
  assert.equal(chart.nearestStretch([place(63, 10), place(63, 10)], place(64, 10)), 0);
});

test("only what may be left out is", () => {
  assert.deepEqual([...chart.keptSwitches("names,base,aids,")], ["names", "aids"]);
  assert.deepEqual([...chart.keptSwitches(null)], []);
});
