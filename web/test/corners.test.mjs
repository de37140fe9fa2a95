// Corners of an area: what is taken of a text, and what can be taken back.

import assert from "node:assert/strict";
import { test } from "node:test";
import { join } from "node:path";
import { load } from "../testing/bundled.mjs";

const { Corners, cornersOfText, textOfCorners } = await load("state/corners");

const places = (text) => cornersOfText(text).corners?.map(({ lat_deg, lon_deg }) => [Number(lat_deg.toFixed(6)), Number(lon_deg.toFixed(6))]);
const at = (lat_deg, lon_deg = 10) => ({ lat_deg, lon_deg });

test("a line is a place, as people write them", () => {
  for (const line of ["63.4455, 10.344", "63.4455 10.344", "63.4455\t10.344", "63.4455;10.344", "63.4455,10.344", "63.4455°N 10.344°E", "63°26.73'N 010°20.64'E", "63° 26.73′ N, 010° 20.64′ Ø", "63°26'43.8\"N 10°20'38.4\"E", "63.4455n 10.344e"]) {
    assert.deepEqual(places(line), [[63.4455, 10.344]], line);
  }
  assert.deepEqual(places("-33.5, −18.25\n\n33°30'S 18°15'W"), [[-33.5, -18.25], [-33.5, -18.25]], "south and west, empty lines left out");
  assert.deepEqual(places(""), []);
});

test("what is not a place is named by its line", () => {
  for (const line of ["x", "63.4455", "91, 10", "63, 181", "63,4455 10,344", "63°61'N 10°E", "63.5°26'N 10°E", "-63S 10", "63, 10, 5", "10°E 63°N"]) {
    assert.match(cornersOfText(`63, 10\n${line}`).wrong, /^Line 2 is not a place/, line);
  }
  assert.match(cornersOfText(Array.from({ length: 201 }, (_, n) => `63, ${n / 10}`).join("\n")).wrong, /201 corners, at most 200/);
});

test("a ring that ends where it began has its corner once", () => {
  assert.equal(places("63, 10\n63, 11\n64, 11\n63, 10").length, 3);
});

test("text and corners lead to each other", () => {
  const corners = [at(63.4455123, 10.3441234), at(-1, 179.5), at(0, 0)];
  assert.equal(textOfCorners(corners), "63.4455123, 10.3441234\n-1.00000, 179.50000\n0.00000, 0.00000");
  assert.deepEqual(cornersOfText(textOfCorners(corners)).corners, corners);
});

test("each step is taken back: a corner, one on a side, a drag as a whole, and all removed", () => {
  const corners = new Corners();
  const lats = () => corners.now.value.map(({ lat_deg }) => lat_deg);
  corners.begin([at(1), at(2)]);
  assert.ok(!corners.changed);
  corners.add(at(3));
  for (const [lat, done] of [[7, false], [8, false], [9, true]]) corners.move(0, at(lat), done);
  const held = corners.insert(2, at(4));
  assert.equal(held, 3, "on the side that leads back to the first");
  for (const [lat, done] of [[5, false], [6, true]]) corners.move(held, at(lat), done);
  assert.deepEqual(lats(), [9, 2, 3, 6]);
  corners.set([]);
  const back = [];
  for (; corners.changed; corners.undo()) back.push(lats());
  assert.deepEqual([...back, lats()], [[], [9, 2, 3, 6], [9, 2, 3], [1, 2, 3], [1, 2]]);
  corners.undo();
  assert.deepEqual(lats(), [1, 2]);
});

test("there are no more corners than an area may have", () => {
  const corners = new Corners();
  corners.begin(Array.from({ length: 200 }, (_, n) => at(n / 10)));
  corners.add(at(50));
  assert.equal(corners.insert(1, at(50)), -1);
  corners.move(-1, at(50), false);
  assert.equal(corners.now.value.length, 200);
  assert.ok(!corners.changed);
});

test("what is typed is taken or stays, and never stands beside other corners", () => {
  const corners = new Corners();
  corners.begin([at(1), at(2), at(3)]);
  corners.typed.value = "63, 10\n63,4 10,3";
  assert.equal(corners.take(), false);
  assert.match(corners.wrong.value, /^Line 2/);
  assert.deepEqual(corners.now.value, [at(1), at(2), at(3)]);
  corners.add(at(4));
  assert.deepEqual([corners.typed.value, corners.wrong.value], [undefined, ""], "a click shows what there is");
  corners.typed.value = "5, 10\n6, 10\n7, 11";
  assert.equal(corners.take(), true);
  assert.equal(corners.typed.value, undefined);
  corners.undo();
  assert.deepEqual(corners.now.value, [at(1), at(2), at(3), at(4)]);
});
