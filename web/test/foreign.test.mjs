// What of foreign text stands on a page: `npm test` bundles the module for Node and runs this.

import assert from "node:assert/strict";
import { test } from "node:test";
import { load } from "../testing/bundled.mjs";

const { named, tame } = await load("state/foreign");
const { asCalled, systemName } = await load("ui/format");
const { csv } = await load("ui/csv");

test("text is bounded and what nobody sees in it is gone", () => {
  assert.equal(tame("otter-1: 24.1 V\n", 100), "otter-1: 24.1 V\n");
  assert.equal(tame("a\u0000\u001b[31mb\u007f\u0085", 100), "a\ufffd\ufffd[31mb\ufffd\ufffd");
  assert.equal(tame("\u202egnp\u2066\u200b.exe\u2028", 100), "gnp.exe");
  assert.equal(tame(`z${"\u0335".repeat(500)}`, 1_000), "z\u0335\u0335\u0335");
  assert.equal(tame("x".repeat(500), 100), `${"x".repeat(99)}…`);
  assert.equal(tame("\u{1f6a4}".repeat(500), 100), `${"\u{1f6a4}".repeat(49)}…`);
  // What people write stays as it is.
  for (const text of ["Gløshaugen", "Ålesund 1", "हिन्दी", "tiếng Việt"]) assert.equal(tame(text, 100), text);
});

test("a long name is short, keeps its end, and two are never taken for one", () => {
  assert.equal(named("otter-1"), "otter-1");
  assert.equal(named(" \n otter\t\n1 "), "otter 1");
  const [one, other] = ["1", "2"].map((end) => `${"N".repeat(100)}-otter-${end}`);
  assert.equal([...named(one)].length, 32);
  assert.ok(named(one).endsWith("-otter-1") && named(one) !== named(other));
  assert.equal(named("\u202e\u200b"), "");
  assert.equal(systemName({ address: 0x814, name: "\u200b" }), "unknown 0x0814");
  // Two that differ in what is left out are told apart by their addresses.
  const alike = asCalled([["a", 1], ["b", 2]].map(([letter, address]) => ({ address, name: `${"N".repeat(50)}${letter}${"N".repeat(50)}` })), {});
  assert.equal(new Set(alike.map(({ name }) => name)).size, 2);
  assert.ok(alike.every(({ name, address }) => name.endsWith(`(0x000${address})`)));
});

test("no cell is a formula", () => {
  const risky = ["=1+1", "+1", "-1", "@a", "\t=1", "\r=1", "\n=1", "＝1+1", "＋1", "－1", "＠a", "'a"];
  assert.equal(csv(["a"], risky.map((text) => [text])), `a\n${risky.map((text) => (/[\r\n]/.test(text) ? `"'${text}"` : `'${text}`)).join("\n")}\n`);
});
