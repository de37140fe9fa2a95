// What is typed of a dataset and of a link, as the server takes it.

import assert from "node:assert/strict";
import { test } from "node:test";
import { load } from "../testing/bundled.mjs";

const { draftOf, draftWrong, EMPTY, fieldsOf, fieldsOfSearch, NEW_SHARE, placeWords, queryWords, shareAsk, shareWrong, wrongOfWords } = await load("state/datasets");

const FROM_US = 1_732_176_000_123_456;

test("the explorer's question is taken over", () => {
  const fields = fieldsOfSearch("?make=1&from=2024-11-21T08:00:00&vessel=2068,2069&tag=S256-101%20102&project=A&project=B;%20north&area=63,10;64,10;64,11");
  assert.deepEqual({ ...EMPTY, from: "2024-11-21T08:00:00", vessels: ["2068", "2069"], tags: "S256-101, 102", projects: ["A", "B; north"], area: "63,10;64,10;64,11" }, fields);
  const { query } = draftOf(fields);
  assert.deepEqual([query.from_us, query.to_us, query.vessels, query.tags], [1_732_176_000_000_000, null, [2068, 2069], ["S256-101", "102"]]);
});

test("a draft comes back as it was, its times as fine as they were", () => {
  const query = { from_us: FROM_US, to_us: null, vessels: [2068], tags: ["S256-101"], projects: [], area: "", without: ["unconfirmed"] };
  const draft = { title: "a", description: "b", publisher: "c", authors: ["d"], licence: "Ask first", embargo_until: "2027-01-31", doi: "10.5281/x", query };
  assert.equal(fieldsOf(draft).licence, "own");
  assert.deepEqual(draftOf(fieldsOf(draft), draft), draft);
  const moved = { ...fieldsOf(draft), from: "2024-11-21T08:00:01" };
  assert.equal(draftOf(moved, draft).query.from_us, 1_732_176_001_000_000);
});

test("what is wrong is said at its field", () => {
  assert.equal(draftWrong(EMPTY).field, "title");
  assert.equal(draftWrong({ ...EMPTY, title: "a", licence: "own" }).field, "licence");
  assert.equal(draftWrong({ ...EMPTY, title: "a", from: "2024-11-21T08:00:01", to: "2024-11-21T08:00:00" }).field, "to_us");
  assert.equal(draftWrong({ ...EMPTY, title: "a" }), undefined);
  assert.deepEqual(wrongOfWords("publisher: write one\nauthors: choose one"), { field: "publisher", text: "write one" });
  assert.deepEqual(wrongOfWords("The server is stopping."), { field: "", text: "The server is stopping." });
  for (const days of ["0", "731", "x", "1.5"]) assert.equal(shareWrong({ ...NEW_SHARE, label: "a", days }).field, "days", days);
  assert.equal(shareWrong({ ...NEW_SHARE, label: " " }).field, "label");
});

test("a link asks for what its fields say", () => {
  const ask = shareAsk({ ...NEW_SHARE, label: " Ola ", precision: "1000", tags: "101,102" }, 2);
  assert.deepEqual(ask, { version: 2, label: "Ola", days: 30, password: "", person: null, from_us: null, to_us: null, tags: ["101", "102"], area: "", precision_m: 1_000 });
  assert.equal(shareAsk({ ...NEW_SHARE, person: " ola " }, 2).person, "ola");
});

test("question and extent are said in words", () => {
  const query = { from_us: FROM_US, to_us: null, vessels: [2068], tags: [], projects: [], area: "63,10;64,10;64,11", without: [] };
  assert.deepEqual(queryWords(query, (address) => `boat ${address}`, String), ["From 2024-11-21 08:00 UTC", "Vessels: boat 2068", "All tags", "In an area of 3 corners"]);
  const covered = { first_us: 0, last_us: 0, south_deg: -1.5, north_deg: 2, west_deg: -0.25, east_deg: 10 };
  assert.equal(placeWords({ covered }), "From 1.5000° S to 2.0000° N, and from 0.2500° W to 10.0000° E.");
  assert.equal(placeWords({ covered: { ...covered, south_deg: null } }), "No place is known.");
});
