// What is sent until it is answered: bundled for Node, with a server and pauses of this test's own.

import assert from "node:assert/strict";
import { test } from "node:test";
import { load } from "../testing/bundled.mjs";

const { pauseMs, postUntilAnswered } = await load("api/retry");

globalThis.document = { querySelector: () => null };
const pauses = [];
let nowMs = 0;
globalThis.performance.now = () => nowMs;
globalThis.window = { setTimeout: (done, ms) => (pauses.push(ms), (nowMs += ms), queueMicrotask(done)), clearTimeout() {}, addEventListener() {}, removeEventListener() {} };
const answer = (status, body) => () => Promise.resolve(new Response(JSON.stringify(body), { status }));
const silence = () => Promise.reject(new TypeError("network"));
const refusal = (code) => ({ error: { code, text: `words of ${code}` } });

/** Sends to a server that answers in this way, one after another. */
async function sent(answers, withinMs = 120_000) {
  const [bodies, told] = [[], []];
  nowMs = 0;
  globalThis.fetch = (path, { body }) => {
    bodies.push(`${path} ${body}`);
    return answers[bodies.length - 1]();
  };
  const outcome = await postUntilAnswered(() => `/note?key=a&at=${nowMs}`, 1_000, withinMs, { text: "x" }, (tries) => told.push(tries)).catch((error) => error);
  return { outcome, bodies, told };
}

test("what nobody answers is sent again with the same key and words, by a path of that moment", async () => {
  const { outcome, bodies, told } = await sent([silence, answer(503, refusal("unavailable")), answer(200, { id: 7 })]);
  assert.deepEqual([outcome, told], [{ id: 7 }, [1, 2]]);
  assert.deepEqual(bodies, [0, 1_000, 3_000].map((at) => `/note?key=a&at=${at} {"text":"x"}`));
  assert.deepEqual(pauses.splice(0), [1_000, 2_000]);
});

test("what is refused is not sent again", async () => {
  const { outcome, bodies, told } = await sent([answer(403, refusal("forbidden"))]);
  assert.deepEqual([outcome.code, outcome.message, bodies.length, told], ["forbidden", "words of forbidden", 1, []]);
});

test("after the time for it the last trouble is told", async () => {
  const { outcome, bodies } = await sent([silence, silence, silence], 1_500);
  assert.ok(outcome instanceof TypeError);
  assert.equal(bodies.length, 2, "another pause of 2 s would end too late");
  assert.deepEqual([1, 2, 5, 50].map(pauseMs), [1_000, 2_000, 15_000, 15_000]);
});
