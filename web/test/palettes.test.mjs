// What the palettes promise holds for every pair of colours in each of them, and nothing else names colours or sizes.

import assert from "node:assert/strict";
import { readdirSync, readFileSync } from "node:fs";
import { test } from "node:test";
import { load } from "../testing/bundled.mjs";

const { contrast, hexRgb, PAIRS } = await load("state/contrast");

const folder = new URL("../src/style/", import.meta.url);
const sheet = (name) => readFileSync(new URL(name, folder), "utf8");

/** The values of each palette, by name. */
function palettes() {
  const found = {};
  for (const [, name, body] of sheet("palettes.css").matchAll(/:root\[data-palette="([a-z]+)"\] \{([^}]*)\}/g)) {
    found[name] = Object.fromEntries([...body.matchAll(/--([a-z0-9-]+): ([^;]+);/g)].map(([, key, value]) => [key, value]));
  }
  return found;
}

test("contrast is that of WCAG", () => {
  assert.equal(contrast([0, 0, 0], [255, 255, 255]), 21);
  assert.equal(contrast([9, 9, 9], [9, 9, 9]), 1);
  // #777777 on white is the well-known one that just fails.
  assert.equal(contrast(hexRgb("#777777"), hexRgb("#ffffff")).toFixed(2), "4.48");
  assert.equal(hexRgb("rgb(0 0 0)"), undefined);
});

test("each ink is read on each of its grounds, in every palette", () => {
  const all = palettes();
  assert.deepEqual(Object.keys(all).toSorted(), ["auto", "day", "dusk", "night", "sun"]);
  const poor = [];
  for (const [palette, colours] of Object.entries(all)) {
    for (const [ink, ground, least, leastInSun] of PAIRS) {
      const [one, other] = [hexRgb(colours[ink] ?? ""), hexRgb(colours[ground] ?? "")];
      assert.ok(one && other, `${palette} has ${ink} and ${ground}`);
      const [found, wanted] = [contrast(one, other), palette === "sun" ? leastInSun : least];
      if (found < wanted) poor.push(`${palette}: ${ink} on ${ground} ${found.toFixed(2)}, not ${wanted}`);
    }
  }
  assert.deepEqual(poor, []);
});

test("the palettes name the same colours; where the computer is dark, dusk is in force", () => {
  const { auto, day, dusk, night, sun } = palettes();
  for (const other of [dusk, night, sun]) assert.deepEqual(Object.keys(other).filter((name) => name !== "weight").toSorted(), Object.keys(day).toSorted());
  assert.deepEqual(auto, dusk);
});

test("sizes of text, corners, shadows and colours have names", () => {
  const bare = /(font-size|border-radius): \d+px|#[0-9a-f]{3,8}\b|rgba?\(/g;
  for (const name of readdirSync(folder).filter((one) => !["palettes.css", "tokens.css", "main.css"].includes(one))) {
    assert.deepEqual(sheet(name).match(bare) ?? [], [], name);
  }
});
