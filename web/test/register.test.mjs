// The register's forms and names: bundled for Node.

import assert from "node:assert/strict";
import { test } from "node:test";
import { load } from "../testing/bundled.mjs";

const { FIELDS, KINDS, calledBy, draftOf, recordOf, registerWrong, tagNames } = await load("state/register");

const tag = (part) => ({ id: 1, revision: 1, may_change: true, written: { by: "k", time_us: 0 }, record: { ...recordOf("tag", draftOf("tag")), ...part } });
const heard = (part) => ({ protocol: 6, protocol_name: "S256", tag_id: 101, frequency_khz: 69, heard_us: 5_000_000, time_us: 9_000_000, ...part });

test("an entry that nobody touched is sent as it was, also what a picker cuts", () => {
  const before = { ...recordOf("animal", draftOf("animal")), name: "A", release_us: 1_795_161_600_123_456, length_mm: 51.25, aphia_id: 127_186 };
  assert.deepEqual(recordOf("animal", draftOf("animal", before), before), before);
  const changed = recordOf("animal", { ...draftOf("animal", before), length_mm: "52,5", release_time: "" }, before);
  assert.deepEqual([changed.length_mm, changed.release_us, changed.aphia_id], [52.5, null, 127_186]);
});

test("what is missing or no number is told at its field", () => {
  const wrong = (kind, part) => registerWrong(kind, { ...draftOf(kind), ...part })?.field;
  assert.equal(wrong("tag", {}), "protocol");
  assert.equal(wrong("tag", { protocol: "S256", tag_id: "1.5" }), "tag_id");
  assert.equal(wrong("tag", { protocol: "S256", tag_id: "101", sensor_slope: "1,2,3" }), "sensor_slope");
  assert.equal(wrong("tag", { protocol: "S256", tag_id: "101", sensor_slope: "0,2" }), undefined);
  assert.equal(wrong("deployment", { receiver: "r", vessel: "7" }), "from_time");
});

test("every kind has a name and no field twice", () => {
  for (const kind of KINDS) {
    const names = FIELDS[kind].map(({ name }) => name);
    assert.equal(new Set(names).size, names.length, kind);
    assert.equal(names[0], "name", kind);
  }
});

test("a detection is called by the tag that had its code then", () => {
  const names = tagNames([
    tag({ name: "S256-101", protocol: "s256", tag_id: 101, animal: "Salmon 12", to_us: 6_000_000 }),
    tag({ name: "Second", protocol: "S256", tag_id: 101, animal: "", from_us: 6_000_000, frequency_khz: 69 }),
  ]);
  assert.equal(calledBy(names, heard({})), "Salmon 12", "a name that is the code itself says nothing");
  assert.equal(calledBy(names, heard({ heard_us: null })), "Second", "without a clock by when it was reported");
  assert.equal(calledBy(names, heard({ heard_us: 6_000_000, frequency_khz: 71 })), "");
  assert.equal(calledBy(names, heard({ heard_us: 6_000_000, frequency_khz: null })), "Second", "of an unknown carrier");
  assert.equal(calledBy(names, heard({ tag_id: 102 })), "");
});
