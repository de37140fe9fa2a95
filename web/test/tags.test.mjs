// Tags are told apart by protocol and number, counted, found and left out.

import assert from "node:assert/strict";
import { test } from "node:test";
import { load } from "../testing/bundled.mjs";

const { countsOf, tagSeries, tagsFound, withHidden } = await load("state/tags");

const heard = (protocol_name, tag_id, protocol = null) => ({ protocol, protocol_name, tag_id });

test("tags are counted by protocol and number, the one that was heard most first", () => {
  const all = [heard("S256", 101), heard("R64K", 101), heard("S256", 101), heard(null, 7, 12), heard(null, 8)];
  assert.deepEqual(countsOf(all).map(({ tag, count }) => [tag, count]), [["S256-101", 2], ["?-8", 1], ["12-7", 1], ["R64K-101", 1]]);
});

test("a tag keeps its colour, whichever others are there", () => {
  const [alone, among] = [countsOf([heard("S256", 103)]), countsOf([1, 2, 103, 4].map((id) => heard("S256", id)))];
  assert.equal(tagSeries(alone[0].id), tagSeries(among.find(({ tag }) => tag === "S256-103").id));
  for (const id of [0, 1, 255, 16_777_215]) assert.ok(tagSeries(id) >= 0 && tagSeries(id) < 4);
});

test("tags are found by parts of their names, and left out and taken back by name", () => {
  const tags = countsOf([heard("S256", 101), heard("S256", 20), heard("R64K", 101)]);
  const names = (words) => tagsFound(tags, words).map(({ tag }) => tag);
  assert.deepEqual([names("").length, names("s256").length, names("20, r64k"), names("x")], [3, 2, ["R64K-101", "S256-20"], []]);
  const hidden = withHidden(new Set(["other-1"]), ["S256-101", "S256-20"], true);
  assert.deepEqual([...hidden], ["other-1", "S256-101", "S256-20"], "a tag that is not heard now stays out");
  assert.deepEqual([...withHidden(hidden, ["S256-20"], false)], ["other-1", "S256-101"]);
});
