// Grids of currents from CSV.

import assert from "node:assert/strict";
import { test } from "node:test";
import { build } from "esbuild";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { mkdtemp, readFile } from "node:fs/promises";

const folder = await mkdtemp(join(tmpdir(), "lutra-currents-"));
const outfile = join(folder, "currents.mjs");
await build({ entryPoints: ["src/state/currents.ts"], bundle: true, format: "esm", outfile, logLevel: "warning" });
const { currentsOfCsv } = await import(outfile);

test("the file that the command line reads gives the same grid", async () => {
  const { grid, wrong } = currentsOfCsv(await readFile("../fuzz/seeds/geofile/currents.csv", "utf8"));
  assert.equal(wrong, "");
  assert.deepEqual(grid, {
    times_us: [Date.UTC(2026, 10, 21, 6) * 1000, Date.UTC(2026, 10, 21, 7) * 1000],
    lats_deg: [63, 63.1],
    lons_deg: [10, 10.2],
    east_mps: [0.1, 0.2, 0.3, null, 0.5, 0.6, null, 0.8],
    north_mps: [-0.1, -0.1, -0.1, null, 0, 0, null, 0],
  });
  // Without an offset it is UTC.
  const rows = (time) => [[63, 10], [63, 11], [64, 10], [64, 11]].map(([lat, lon]) => `${time},${lat},${lon},1,0`).join("\n");
  assert.deepEqual(currentsOfCsv(`time,lat,lon,east_mps,north_mps\n${rows("2026-11-21 06:00")}`).grid.times_us, [Date.UTC(2026, 10, 21, 6) * 1000]);
});

test("what is no grid is refused with its line", () => {
  assert.match(currentsOfCsv("time,lat,lon,u,v").wrong, /Line 1: there is no column east_mps/);
  const of = (...rows) => currentsOfCsv(["time,lat,lon,east_mps,north_mps", ...rows].join("\n")).wrong;
  assert.match(of("", "now,63,10,0,0"), /^Line 3: /);
  assert.match(of("2026-11-21T06:00:00Z,63,,0,0"), /^Line 2: /);
  assert.match(of("2026-11-21T06:00:00Z,63,10,fast,0"), /^Line 2: /);
  assert.match(of("2026-11-21T06:00:00Z,63,10,0,0"), /two latitudes/);
  assert.match(of(...Array.from({ length: 400 }, (_, n) => `2026-11-21T06:00:00Z,${63 + n / 1000},${10 + n / 1000},0,0`)), /160000 crossings/);
});
