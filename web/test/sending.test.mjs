// Keys of what is on its way: bundled for Node.

import assert from "node:assert/strict";
import { test } from "node:test";
import { load } from "../testing/bundled.mjs";

const { Keys } = await load("state/sending");

test("what is sent again as it was has the key of before; what was changed, and the next, have another", () => {
  let made = 0;
  let nowMs = 1_000;
  const keys = new Keys(() => `k${++made}`, () => nowMs);
  const draft = { text: "swell", lat: "" };
  assert.equal(keys.of(draft).key, "k1");
  assert.equal(keys.of({ ...draft }).key, "k1", "nobody answered, and it is pressed again");
  assert.equal(keys.of({ ...draft, lat: "63" }).key, "k2", "other words are another note: nothing that was typed is lost");
  assert.equal(keys.of({ ...draft, lat: "63" }).key, "k2");
  nowMs += 600_000;
  assert.equal(keys.waitedMs(keys.of({ ...draft, lat: "63" })), 600_000, "it means the moment of the first try");
  nowMs += 9_000_000;
  assert.equal(keys.waitedMs(keys.of({ ...draft, lat: "63" })), 3_600_000);
  nowMs = 0;
  assert.equal(keys.waitedMs(keys.of({ ...draft, lat: "63" })), 0, "a clock that was set back");
  keys.answered();
  assert.equal(keys.of({ ...draft, lat: "63" }).key, "k3", "the same words once more are meant");
});
