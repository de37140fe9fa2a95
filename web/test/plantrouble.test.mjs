// What is wrong about a plan, in words: bundled for Node.

import assert from "node:assert/strict";
import { test } from "node:test";
import { load } from "../testing/bundled.mjs";

const { troubleText } = await load("state/plantrouble");
const told = (code, values = {}, about = null) => troubleText({ maneuver: null, code, about, values, text: "in English" });

test("troubles are said by their codes and figures, and what has none as the server said it", () => {
  assert.equal(told("other"), "in English");
  assert.equal(told("a code of a newer server"), "in English");
  assert.equal(told("speed", { mps: 3.0867, rpm: 980, percent: 100 }), "This speed is not possible. Choose one above 0 and up to 3.09 m/s, 980 rpm or 100 %.");
  assert.equal(told("range", { value: -3, least: 0, most: 1000 }, "radius"), "radius -3 m is not within 0 to 1000 m");
  assert.equal(told("range", { least: 0, most: 1000 }, "step"), "distance between rows is not a number");
  assert.equal(told("range", { value: 1.2, least: 0, most: 1 }, "alternation"), "alternation 120 % is not within 0 to 100 %");
  assert.equal(told("outside-area", { by_m: 12.6 }), "It leaves the area of operation by 13 m");
});
