// How features of the chart are drawn: bundled for Node, with features of this test's own.

import assert from "node:assert/strict";
import { test } from "node:test";
import { build } from "esbuild";
import { join } from "node:path";
import { folder } from "../testing/bundled.mjs";

globalThis.document = { documentElement: { dataset: { palette: "day" } } };
const outfile = join(folder, "chartstyle-style.mjs");
await build({ entryPoints: ["src/map/chart/style.ts"], bundle: true, format: "esm", outfile, logLevel: "warning", platform: "neutral", mainFields: ["module", "main"] });
const { createStyles } = await import(outfile);

const feature = (says) => ({ get: (name) => says[name], getGeometry: () => undefined });
const contour = (valdco) => feature({ layer: "contour", valdco });

test("a contour tells its depth along the line, the safety contour in bold, and can be left out", () => {
  const styles = createStyles(() => {});
  styles.limits({ navigable_m: 1, autonomous_m: 5 });
  for (const depth of [5, 10]) styles.base(contour(depth), 5);
  assert.equal(styles.safety_m(), 5);
  const told = (depth) => styles.points(contour(depth), 5)?.getText();
  assert.deepEqual([told(10).getText(), told(10).getPlacement()], ["10", "line"]);
  assert.equal(told(2.5).getText(), "2.5");
  assert.ok(told(5).getFont().startsWith("700") && told(10).getFont().startsWith("400"));
  assert.equal(styles.points(contour(undefined), 5), undefined, "what the chart does not tell");
  // Soundings keep their room.
  assert.ok(styles.order(feature({ layer: "sounding", depth_m: 400 }), contour(5)) < 0);
  styles.without(new Set(["contours"]));
  assert.equal(styles.points(contour(10), 5), undefined);
});
