// What of very many points is drawn, decided without drawing.

import assert from "node:assert/strict";
import { test } from "node:test";
import { load } from "../testing/bundled.mjs";

const { thinned } = await load("plot/thin");

/** A table with a point each second; rows of nulls where `gaps` says so. */
function made(count, value, gaps = () => false) {
  const table = [[], [], [], []];
  for (let at = 0; at < count; at++) {
    table[0].push(at);
    const one = gaps(at) ? null : value(at);
    for (const column of [1, 2, 3]) table[column].push(one);
  }
  return table;
}

const wave = (at) => Math.sin(at / 50) + (at % 7) / 10;
const known = (column) => column.filter((one) => one !== null);

test("a table of few points is drawn as it is", () => {
  const table = made(800, wave);
  assert.equal(thinned(table, 0, 800, 100), table);
});

test("of many points each pixel shows the least and the greatest of what lies there", () => {
  const table = made(100_000, wave);
  const [times, maxima, minima, means] = thinned(table, 0, 100_000, 500);
  assert.ok(times.length <= 600 && times.length >= 450, String(times.length));
  assert.ok(times.every((time, at) => at === 0 || time > times[at - 1]), "times go up");
  // Every point lies between the least and the greatest of its place.
  const wide = 200;
  for (let at = 0; at < 100_000; at += 37) {
    const near = times.map((time, row) => (Math.abs(time - at) <= wide ? row : -1)).filter((row) => row >= 0);
    assert.ok(near.some((row) => minima[row] <= wave(at) && wave(at) <= maxima[row]), String(at));
  }
  assert.equal(Math.max(...maxima), table[1].reduce((most, one) => Math.max(most, one)));
  assert.equal(Math.min(...minima), table[2].reduce((least, one) => Math.min(least, one)));
  means.forEach((mean, row) => assert.ok(minima[row] <= mean && mean <= maxima[row]));
});

test("a part that has few points is drawn as it is, with one more to either side", () => {
  const table = made(100_000, wave);
  const [times, maxima] = thinned(table, 5_000, 5_100, 500);
  assert.deepEqual([times[0], times.at(-1)], [4_999, 5_101]);
  assert.equal(maxima[1], wave(5_000));
  assert.deepEqual(thinned(table, 200_000, 300_000, 500)[0], [99_999]);
});

test("a gap that can be seen stays one, and a narrow one hides nothing", () => {
  const table = made(100_000, wave, (at) => (at >= 40_000 && at < 50_000) || at % 1_000 === 0);
  const [times, maxima] = thinned(table, 0, 100_000, 500);
  const gaps = times.filter((_, row) => maxima[row] === null);
  assert.deepEqual(gaps.length, 1);
  assert.ok(gaps[0] > 40_000 && gaps[0] < 50_000);
  assert.ok(!times.some((time, row) => maxima[row] !== null && time > 40_200 && time < 49_800));
  assert.equal(Math.max(...known(maxima)), known(table[1]).reduce((most, one) => Math.max(most, one)));
});

test("every point in view is counted by its weight in the mean", () => {
  const table = made(10_000, (at) => (at < 5_000 ? 0 : 1));
  const [, , , means] = thinned(table, 0, 10_000, 10);
  assert.ok(Math.abs(means.reduce((sum, one) => sum + one, 0) / means.length - 0.5) < 0.06);
});
