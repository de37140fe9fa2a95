// Several vessels in one view, the pure parts: `npm test` bundles them for Node and runs this.

import assert from "node:assert/strict";
import { test } from "node:test";
import { load } from "../testing/bundled.mjs";

const { likewise } = await load("plot/model");
const { besideFrom } = await load("replay/beside");
const { seriesColour } = await load("map/palette");

const series = (message, entity, count, ...names) => ({ message, entity, count, fields: names.map((name) => ({ name })) });

test("the same field of another vessel is of the part that is called the same", () => {
  const theirs = [series("Rpm", 3, 10, "value"), series("Rpm", 7, 900, "value"), series("Voltage", 3, 5, "value")];
  const labels = new Map([[3, "Motor Starboard"], [7, "Motor Port"]]);
  const source = { message: "Rpm", entity: 3, field: "value" };
  assert.deepEqual(likewise(source, "Motor Port", theirs, labels), { message: "Rpm", entity: 7, field: "value" });
  assert.equal(likewise(source, "Torqeedo", theirs, labels).entity, 3, "else of the same number");
  assert.equal(likewise({ ...source, entity: 9 }, "", theirs, labels).entity, 7, "else of the one that said it most often");
  assert.equal(likewise({ ...source, field: "u" }, "Motor Port", theirs, labels), undefined);
});

test("an address tells who is beside, three at most and nobody twice", () => {
  const of = (text) => besideFrom(new URLSearchParams({ with: text }), 7);
  assert.deepEqual(of("1,2,2,7,3,4"), [1, 2, 3]);
  assert.deepEqual(of("x,-1,65535,99999,0x10,"), []);
  assert.deepEqual(besideFrom(new URLSearchParams(), 7), []);
});

test("vessels in one view have colours of their own", () => {
  const palette = { ink: "black", series: ["a", "b", "c", "d"], first: [0x28d1, 0x28d5] };
  assert.deepEqual([0x28d1, 0x28d5, 0x28d2].map((address) => seriesColour(palette, address)), ["a", "b", "c"]);
});
