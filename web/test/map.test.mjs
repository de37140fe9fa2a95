// Whose a click on the map is, what lies over what, and round distances: pure parts, bundled for Node.

import assert from "node:assert/strict";
import { test } from "node:test";
import { build } from "esbuild";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { mkdtemp } from "node:fs/promises";

const folder = await mkdtemp(join(tmpdir(), "lutra-map-"));
async function load(path) {
  const outfile = join(folder, `${path.replaceAll("/", "-")}.mjs`);
  await build({ entryPoints: [`src/${path}.ts`], bundle: true, format: "esm", outfile, logLevel: "warning" });
  return import(outfile);
}
const { createClicks } = await load("map/clicks");
const { over } = await load("map/layers");
const { ringStep_m } = await load("map/scale");

test("a click is taken once: by what is in hand, else by what lies there, else by the place", () => {
  let click = () => undefined;
  const clicks = createClicks({ on: (kind, then) => void (kind === "singleclick" && (click = then)) });
  const took = [];
  const wants = { pick: false, track: true, place: true };
  // In any order of coming.
  for (const claim of ["place", "track", "pick"]) clicks.claim(claim, () => (wants[claim] && took.push(claim), wants[claim]));
  click({});
  assert.deepEqual(took, ["track"], "choosing a time on the track does not ask what is there");
  wants.pick = true;
  click({});
  wants.pick = wants.track = false;
  click({});
  assert.deepEqual(took, ["track", "pick", "place"]);
  wants.place = false;
  click({});
  assert.equal(took.length, 3);
});

test("nothing lies over a vessel", () => {
  for (const layer of ["route", "tags", "cursor", "own", "rings", "planMarks", "measure"]) assert.ok(over("vessel") > over(layer), layer);
});

test("range rings are at round distances that are not too near", () => {
  for (const [least, step] of [[0, 1], [3, 5], [20, 20], [21, 50], [99.9, 100], [100, 100], [6_000, 10_000]]) assert.equal(ringStep_m(least), step, String(least));
});
