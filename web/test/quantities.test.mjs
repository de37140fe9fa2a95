// Names of quantities: each of a field that IMC has, found by people's words.

import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { test } from "node:test";
import { load } from "../testing/bundled.mjs";

const { QUANTITIES, quantity } = await load("state/quantities");

test("each named field is a field of IMC, or one that the history makes", async () => {
  const { messages } = JSON.parse(await readFile("../crates/imc/catalogue/messages.json", "utf8"));
  const made = { EstimatedState: ["true_lat_deg", "true_lon_deg"] };
  for (const [abbrev, fields] of Object.entries(QUANTITIES)) {
    const message = messages.find((one) => one.abbrev === abbrev);
    assert.ok(message, abbrev);
    const known = [...message.fields.map((field) => field.abbrev), ...(made[abbrev] ?? [])];
    for (const field of Object.keys(fields)) assert.ok(known.includes(field), `${abbrev}.${field}`);
  }
});

test("within a message no two fields have the same name", () => {
  for (const [abbrev, fields] of Object.entries(QUANTITIES)) {
    const names = Object.values(fields).map((name) => name());
    assert.equal(new Set(names).size, names.length, abbrev);
  }
});

test("what is not known has no words, whatever it is called", () => {
  assert.equal(quantity("GpsFix", "sog"), "speed over ground");
  assert.equal(quantity("GpsFix", "toString"), "");
  assert.equal(quantity("constructor", "name"), "");
});
