// Grids of currents from CSV.

import assert from "node:assert/strict";
import { test } from "node:test";
import { join } from "node:path";
import { readFile } from "node:fs/promises";
import { load } from "../testing/bundled.mjs";

const { currentsOfCsv } = await load("state/currents");

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

test("times are ISO 8601, and a time and place stands once", () => {
  const of = (...rows) => currentsOfCsv(["time,lat,lon,east_mps,north_mps", ...rows].join("\n"));
  for (const time of ["11/12/2026", "5", "2026-02-31T06:00:00Z", "2026-11-21T25:00Z", "21 Nov 2026 06:00"]) assert.match(of(`${time},63,10,0,0`).wrong, /^Line 2: /, time);
  const rows = (time) => [[63, 10], [63, 11], [64, 10], [64, 11]].map(([lat, lon]) => `${time},${lat},${lon},0.123456,0`);
  for (const time of ["2026-11-21T07:00+01:00", "2026-11-21T07:00:00+0100", "2026-11-21t06:00:00.0z"]) assert.deepEqual(of(...rows(time)).grid?.times_us, [Date.UTC(2026, 10, 21, 6) * 1000], time);
  assert.deepEqual(of(...rows("2026-11-21T06:00Z")).grid.east_mps, [0.1235, 0.1235, 0.1235, 0.1235]);
  assert.match(of(...rows("2026-11-21T06:00Z"), "2026-11-21T07:00+01:00,64,10,1,1").wrong, /^Line 6: .* line 4/);
});

test("what is not a grid is refused with its line", () => {
  assert.match(currentsOfCsv("time,lat,lon,u,v").wrong, /Line 1: there is no column east_mps/);
  const of = (...rows) => currentsOfCsv(["time,lat,lon,east_mps,north_mps", ...rows].join("\n")).wrong;
  assert.match(of("", "now,63,10,0,0"), /^Line 3: /);
  assert.match(of("2026-11-21T06:00:00Z,63,,0,0"), /^Line 2: /);
  assert.match(of("2026-11-21T06:00:00Z,63,10,fast,0"), /^Line 2: /);
  assert.match(of("2026-11-21T06:00:00Z,63,10,0,0"), /two latitudes/);
  assert.match(of(...Array.from({ length: 400 }, (_, n) => `2026-11-21T06:00:00Z,${63 + n / 1000},${10 + n / 1000},0,0`)), /160000 crossings/);
});
