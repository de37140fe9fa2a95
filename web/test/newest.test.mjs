// The newest events of a stretch of time: `npm test` bundles the module for Node and runs this.

import assert from "node:assert/strict";
import { test } from "node:test";
import { build } from "esbuild";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { mkdtemp } from "node:fs/promises";

const folder = await mkdtemp(join(tmpdir(), "lutra-newest-"));
const outfile = join(folder, "newest.mjs");
await build({ entryPoints: ["src/state/newest.ts"], bundle: true, format: "esm", outfile, logLevel: "warning" });
const { lengthened, question, refreshed, within } = await import(outfile);

/** What a server knows, the oldest first: several at one time. */
const server = (count, first = 0) => Array.from({ length: count }, (_, at) => ({ time_us: 10 * Math.floor((first + at) / 3), name: `${first + at}` }));
const key = (one) => one.name;
const STRETCH = { fromUs: 0, toUs: 1_000_000 };
/** Its answer, as the store gives it. */
function answer(all, text) {
  const query = Object.fromEntries(new URLSearchParams(text).entries());
  const [from, to, limit, skip] = ["from_us", "to_us", "limit", "skip"].map((name) => Number(query[name]));
  assert.equal(query.order, "newest");
  const found = all.filter(({ time_us }) => time_us >= from && time_us < to).reverse();
  const rest = found[skip + limit];
  const items = found.slice(skip, skip + limit);
  if (!rest) return { items, next: null };
  const before = found.slice(0, skip + limit).filter(({ time_us }) => time_us === rest.time_us).length;
  return { items, next: { from_us: from, to_us: rest.time_us + 1, skip: before } };
}
const first = (all, before, limit, stretch = STRETCH) => refreshed(before, answer(all, question(stretch, limit, null)), stretch, key);
const older = (all, known, limit) => lengthened(known, answer(all, question(known.stretch, limit, known.next)));
const names = ({ items }) => items.map(key);

test("page by page all are read once, the newest first", () => {
  const all = server(20);
  let known = first(all, undefined, 4);
  while (known.next) known = older(all, known, 4);
  assert.deepEqual(names(known), all.map(key).reverse());
});

test("newer ones join what was read, without a gap and none twice", () => {
  let known = first(server(20), undefined, 4);
  known = older(server(20), known, 4);
  const more = server(23);
  known = first(more, known, 4);
  assert.deepEqual(names(known), more.slice(12).map(key).reverse());
  while (known.next) known = older(more, known, 4);
  assert.deepEqual(names(known), more.map(key).reverse());
});

test("where so many came that nothing meets, it begins anew", () => {
  let known = first(server(20), undefined, 4);
  known = older(server(20), known, 4);
  const more = server(60);
  known = first(more, known, 4);
  assert.deepEqual(names(known), more.slice(56).map(key).reverse());
  assert.deepEqual(names(older(more, known, 4)), more.slice(52).map(key).reverse());
});

test("what the present leaves behind is left behind", () => {
  const all = server(20);
  let known = older(all, first(all, undefined, 4), 8);
  const stretch = { fromUs: 40, toUs: 1_000_000 };
  known = first(all, known, 4, stretch);
  assert.ok(known.items.every(({ time_us }) => time_us >= 40), names(known));
  assert.equal(known.items.length, 8);
  assert.deepEqual(within(all, { fromUs: 40, toUs: 50 }).map(key), ["12", "13", "14"]);
});

test("an answer that is whole is all", () => {
  const known = older(server(20), first(server(20), undefined, 4), 4);
  assert.deepEqual(names(first(server(3), known, 4)), ["2", "1", "0"]);
  assert.deepEqual(first([], known, 4), { items: [], next: null, stretch: STRETCH });
});
