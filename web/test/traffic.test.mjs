// The way of requests and of STOP to the server, with a network that a test leads: `npm test` bundles the modules for Node
// and runs this.

import assert from "node:assert/strict";
import { beforeEach, test } from "node:test";
import { build } from "esbuild";
import { join } from "node:path";
import { writeFile } from "node:fs/promises";
import { folder } from "../testing/bundled.mjs";

const entry = join(folder, "entry.ts");
const source = new URL("../src/", import.meta.url).pathname;
await writeFile(entry, ["api/http", "api/signal", "api/traffic", "control/stopping"].map((one) => `export * from ${JSON.stringify(source + one)};`).join("\n"));
const outfile = join(folder, "traffic.mjs");
await build({ entryPoints: [entry], bundle: true, format: "esm", outfile, logLevel: "warning" });

globalThis.window = globalThis;
globalThis.addEventListener = () => undefined;
globalThis.sessionStorage = { getItem: () => "w", removeItem: () => undefined };
globalThis.document = { querySelector: () => null };

/** Requests that are under way: each hangs until the test answers it or its sender gives it up. */
let open = [];
globalThis.fetch = (path, { signal, method = "GET" }) =>
  new Promise((done, failed) => {
    const one = { path, method, signal };
    const end = () => (open = open.filter((other) => other !== one));
    one.answer = (body, status = 200) => {
      end();
      done(new Response(JSON.stringify(body), { status }));
    };
    one.fail = () => {
      end();
      failed(new TypeError("no network"));
    };
    if (signal.aborted) return failed(signal.reason);
    signal.addEventListener("abort", () => {
      end();
      failed(signal.reason);
    });
    open.push(one);
  });
/** Lets everything go on that can. */
const settle = async () => {
  for (let turns = 0; turns < 50; turns++) await Promise.resolve();
  await new Promise((done) => setImmediate(done));
};

let it;
let copies = 0;
beforeEach(async () => {
  // A page of its own.
  it = await import(`${outfile}?${copies++}`);
  open = [];
});
const paths = () => open.map(({ path }) => path);
const many = (count) => Array.from({ length: count }, (_, at) => it.getJson(`/q${at}`));

test("questions share four connections, and STOP waits for none of them", async () => {
  const asked = many(9);
  const told = it.postJson("/act", 60_000);
  await settle();
  assert.deepEqual(paths(), ["/q0", "/q1", "/q2", "/q3"]);
  const stopped = it.postStop(2068, "w", "k", new AbortController().signal);
  await settle();
  assert.equal(paths().at(-1), "/api/v1/vessels/2068/abort?window=w&key=k");
  open.at(-1).answer({ id: 1 });
  assert.deepEqual(await stopped, { id: 1 });
  // What a person does comes before what a page asks.
  open[0].answer(0);
  await settle();
  assert.deepEqual(paths(), ["/q1", "/q2", "/q3", "/act"]);
  while (open.length) {
    assert.ok(open.length <= 4, `${open.length} at once`);
    open[0].answer("x");
    await settle();
  }
  assert.deepEqual(await Promise.all([...asked, told]), [0, ..."x".repeat(9)]);
});

test("what hangs when the link is lost is given up, and asked again when the server is heard", async () => {
  it.linkIs(true);
  const asked = many(6);
  await settle();
  const hung = [...open];
  it.linkIs(false);
  await settle();
  assert.ok(hung.every(({ signal }) => signal.aborted), "the connections are free");
  // What is asked meanwhile tries the network as it is, and may hang as well.
  asked.push(it.getJson("/q6"));
  await settle();
  assert.deepEqual(paths(), ["/q6"]);
  const [meanwhile] = open;
  it.linkIs(true);
  await settle();
  assert.ok(meanwhile.signal.aborted);
  assert.equal(open.length, 4, "asked again, four at once");
  while (open.length) {
    const [one] = open;
    one.answer(one.path);
    await settle();
  }
  assert.deepEqual(await Promise.all(asked), ["/q0", "/q1", "/q2", "/q3", "/q4", "/q5", "/q6"]);
});

test("who gives up a question leaves its turn to the next", async () => {
  const first = many(4);
  const [leaves, leave] = [new AbortController(), "gone"];
  const waits = it.getJson("/waits", leaves.signal);
  const last = it.getJson("/last");
  await settle();
  leaves.abort(new Error(leave));
  await assert.rejects(waits, { message: leave });
  for (const one of [...open]) one.answer(1);
  await settle();
  assert.deepEqual(paths(), ["/last"]);
  open[0].answer(2);
  assert.deepEqual([...(await Promise.all(first)), await last], [1, 1, 1, 1, 2]);
  // A refusal of the server is none of the network, and not asked again.
  const refused = it.getJson("/refused");
  await settle();
  open[0].answer({ error: { code: "forbidden", text: "no" } }, 403);
  await assert.rejects(refused, { message: "no", status: 403 });
  assert.deepEqual(paths(), []);
});

/** A STOP whose news are kept, and what the live socket was given. */
function stop() {
  const [news, line] = [[], { sent: [], open: new Set(), stop: (one) => (line.sent.push(one), line.open.add(one.key)), giveUp: (key) => line.open.delete(key) }];
  const keep = (kind) => (what) => news.push([kind, what]);
  const one = it.createStopping(line, 2068, { answered: keep("answered"), refused: keep("refused"), unanswered: keep("unanswered") });
  return { one, news, line };
}

test("STOP goes both ways with one key, and the first answer counts", async (t) => {
  t.mock.timers.enable({ apis: ["setTimeout"] });
  const { one, news, line } = stop();
  await settle();
  const [{ vessel, key }] = line.sent;
  assert.equal(vessel, 2068);
  assert.ok(open[0].path.endsWith(`key=${key}`), open[0].path);
  one.heard({ vessel: 2068, key: "another", ordered: { id: 7 }, refused: null });
  assert.deepEqual(news, []);
  const request = open[0];
  one.heard({ vessel: 2068, key, ordered: { id: 8 }, refused: null });
  await settle();
  assert.deepEqual(news, [["answered", { id: 8 }]]);
  assert.ok(request.signal.aborted && line.open.size === 0, "nothing of it is left");
  t.mock.timers.tick(60_000);
  await settle();
  assert.deepEqual([open.length, line.sent.length, news.length], [0, 1, 1]);
});

test("STOP is sent again by both ways until it is answered", async (t) => {
  t.mock.timers.enable({ apis: ["setTimeout"] });
  const { one, news, line } = stop();
  for (let tries = 1; tries <= 3; tries++) {
    await settle();
    assert.deepEqual([open.length, line.sent.length], [1, tries]);
    open[0].fail();
    await settle();
    t.mock.timers.tick(1_000);
  }
  await settle();
  // Who presses again waits for no pause.
  open[0].fail();
  await settle();
  one.again();
  await settle();
  assert.equal(new Set(line.sent.map(({ key }) => key)).size, 1);
  open[0].answer({ error: { code: "internal", text: "The server failed." } }, 500);
  await settle();
  t.mock.timers.tick(1_000);
  await settle();
  open[0].answer({ id: 3 });
  await settle();
  assert.deepEqual(news.map(([kind]) => kind), [...Array(5).fill("unanswered"), "answered"]);
});

test("STOP that one way refuses may go by the other, and given up it is over", async (t) => {
  t.mock.timers.enable({ apis: ["setTimeout"] });
  const refusal = { error: { code: "bad_csrf_token", text: "too old" } };
  const first = stop();
  await settle();
  open[0].answer(refusal, 403);
  await settle();
  assert.deepEqual(first.news, []);
  first.one.heard({ vessel: 2068, key: first.line.sent[0].key, ordered: { id: 9 }, refused: null });
  assert.deepEqual(first.news, [["answered", { id: 9 }]]);
  const second = stop();
  await settle();
  open[0].answer(refusal, 403);
  await settle();
  t.mock.timers.tick(2_000);
  assert.deepEqual(second.news, [["refused", "too old"]]);
  const third = stop();
  await settle();
  third.one.giveUp();
  await settle();
  t.mock.timers.tick(60_000);
  await settle();
  assert.deepEqual([third.news, open.length, third.line.open.size], [[], 0, 0]);
});

test("signals end together where the browser cannot join them", () => {
  const any = AbortSignal.any;
  AbortSignal.any = undefined;
  try {
    const [one, other] = [new AbortController(), new AbortController()];
    const joined = it.anyOf(one.signal, other.signal);
    assert.equal(joined.aborted, false);
    other.abort("over");
    assert.deepEqual([joined.aborted, joined.reason], [true, "over"]);
    assert.equal(it.anyOf(one.signal, other.signal).aborted, true);
  } finally {
    AbortSignal.any = any;
  }
});
