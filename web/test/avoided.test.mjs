// Areas to avoid are kept beside the draft of a plan, and what was kept is not believed.

import assert from "node:assert/strict";
import { test } from "node:test";
import { build } from "esbuild";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { mkdtemp } from "node:fs/promises";

const folder = await mkdtemp(join(tmpdir(), "lutra-avoided-"));
const outfile = join(folder, "avoided.mjs");
await build({ entryPoints: ["src/state/avoided.ts"], bundle: true, format: "esm", outfile, logLevel: "warning" });
const { keepAreas, keptAreas, zonesOf } = await import(outfile);

function store() {
  const kept = new Map();
  return { getItem: (key) => kept.get(key) ?? null, setItem: (key, text) => kept.set(key, text), removeItem: (key) => kept.delete(key), kept };
}

const area = [[63, 10], [63.1, 10], [63.1, 10.2]].map(([lat_deg, lon_deg]) => ({ lat_deg, lon_deg }));

test("areas come back for their plan, and leave nothing when there are none", () => {
  const local = store();
  keepAreas(local, "/api/v1/plans/1", [area]);
  assert.deepEqual(keptAreas(local, "/api/v1/plans/1"), [area]);
  assert.deepEqual(keptAreas(local, "/api/v1/plans/2"), []);
  assert.deepEqual(zonesOf([area]), [{ kind: "avoid", corners: [[63, 10], [63.1, 10], [63.1, 10.2]] }]);
  keepAreas(local, "/api/v1/plans/1", []);
  assert.equal(local.kept.size, 0);
});

test("what is kept and is no area is left out", () => {
  for (const text of ["{", "5", "[[1,2,3]]", JSON.stringify([[area[0], area[1]]]), JSON.stringify([[...area, { lat_deg: 95, lon_deg: 0 }]])]) {
    const local = store();
    local.setItem("lutra.avoid.p", text);
    assert.deepEqual(keptAreas(local, "p"), [], text);
  }
});
