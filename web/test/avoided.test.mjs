// Areas to avoid are kept beside the draft of a plan, and what was kept is not believed.

import assert from "node:assert/strict";
import { test } from "node:test";
import { load } from "../testing/bundled.mjs";

const { crosses, hasRoom, keepAreas, keepSlow, keptAreas, keptSlow, limitWrong, zonesOf } = await load("state/avoided");

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
  assert.deepEqual(zonesOf([area], []), [{ kind: "avoid", corners: [[63, 10], [63.1, 10], [63.1, 10.2]], most_mps: null }]);
  keepAreas(local, "/api/v1/plans/1", []);
  assert.equal(local.kept.size, 0);
});

test("what is kept and is not an area is left out", () => {
  for (const text of ["{", "5", "[[1,2,3]]", JSON.stringify([[area[0], area[1]]]), JSON.stringify([[...area, { lat_deg: 95, lon_deg: 0 }]])]) {
    const local = store();
    local.setItem("lutra.avoid.p", text);
    assert.deepEqual(keptAreas(local, "p"), [], text);
  }
});

test("an area whose sides cross is told from one whose sides do not", () => {
  const at = (lat_deg, lon_deg) => ({ lat_deg, lon_deg });
  const square = [at(63, 10), at(63, 10.1), at(63.1, 10.1), at(63.1, 10)];
  assert.equal(crosses(square), false);
  assert.equal(crosses([square[0], square[2], square[1], square[3]]), true);
  assert.equal(crosses(square.slice(0, 3)), false);
});

test("there is room for as many areas and corners as the server takes", () => {
  const area = (corners) => Array.from({ length: corners }, () => ({ lat_deg: 63, lon_deg: 10 }));
  assert.equal(hasRoom([], area(199)), true);
  assert.equal(hasRoom([], area(200)), false);
  assert.equal(hasRoom(Array.from({ length: 50 }, () => area(3)), []), false);
  assert.equal(hasRoom(Array.from({ length: 5 }, () => area(199)), area(5)), false, "1000 in all");
});

test("areas with a speed limit are kept beside them, and a limit out of range is refused in words", () => {
  const local = store();
  const slow = { corners: area, most_mps: 0.8 };
  keepSlow(local, "/api/v1/plans/1", [slow, { corners: area, most_mps: 0 }, { corners: [], most_mps: 1 }]);
  assert.deepEqual(keptSlow(local, "/api/v1/plans/1"), [slow]);
  assert.deepEqual(keptAreas(local, "/api/v1/plans/1"), []);
  const corners = [[63, 10], [63.1, 10], [63.1, 10.2]];
  assert.deepEqual(zonesOf([area], [slow]), [{ kind: "avoid", corners, most_mps: null }, { kind: "limit", corners, most_mps: 0.8 }]);
  for (const good of ["0.05", "1", "20"]) assert.equal(limitWrong(good), "");
  for (const bad of ["", " ", "0", "-1", "21", "fast", "NaN"]) assert.equal(limitWrong(bad), "Give a speed of 0.05 to 20 m/s.");
});
