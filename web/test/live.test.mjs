// STOP by the live socket: with a socket and a clock of this test's own.

import assert from "node:assert/strict";
import { test } from "node:test";
import { load } from "../testing/bundled.mjs";

let nowMs = 0;
let timers = [];
const sockets = [];
const setTimer = (done, ms) => (timers.push({ done, atMs: nowMs + ms }), timers.at(-1));
/** Lets time pass, with what falls due in it. */
function pass(ms) {
  const untilMs = nowMs + ms;
  for (;;) {
    const next = timers.filter(({ atMs }) => atMs <= untilMs).sort((one, other) => one.atMs - other.atMs)[0];
    if (!next) break;
    timers = timers.filter((timer) => timer !== next);
    nowMs = next.atMs;
    next.done();
  }
  nowMs = untilMs;
}
class FakeSocket {
  static OPEN = 1;
  readyState = 0;
  said = [];
  constructor() {
    sockets.push(this);
  }
  open() {
    this.readyState = 1;
    this.onopen();
  }
  send(text) {
    this.said.push(JSON.parse(text));
  }
  close() {
    this.readyState = 3;
  }
  stops() {
    return this.said.filter(({ stop }) => stop).map(({ stop }) => stop.key);
  }
}
const nothing = () => {};
globalThis.WebSocket = FakeSocket;
globalThis.performance.now = () => nowMs;
Date.now = () => 1_700_000_000_000 + nowMs;
globalThis.location = { protocol: "http:", host: "shore" };
globalThis.document = { querySelector: () => null, addEventListener: nothing, removeEventListener: nothing };
globalThis.window = { setTimeout: setTimer, clearTimeout: (timer) => (timers = timers.filter((one) => one !== timer)), setInterval: () => 0, clearInterval: nothing, addEventListener: nothing, removeEventListener: nothing };
globalThis.fetch = () => new Promise(nothing);
const { Live } = await load("api/live");

/** A page whose live socket is open and was heard just now. */
function page() {
  sockets.length = 0;
  timers = [];
  const live = new Live({ vessel: 1 }, { frame: nothing, lost: nothing, loggedOut: nothing, stopped: nothing });
  sockets[0].open();
  live.heardMs = nowMs;
  return live;
}
const stop = { key: "k1", vessel: 1 };

test("a stop on a connection that says nothing goes by a new one after 1.5 s", () => {
  const live = page();
  live.stop(stop);
  assert.deepEqual(sockets[0].stops(), ["k1"]);
  pass(1_499);
  assert.equal(sockets.length, 1);
  pass(1);
  assert.equal(sockets.length, 2);
  assert.equal(sockets[0].readyState, 3);
  sockets[1].open();
  assert.deepEqual(sockets[1].stops(), ["k1"]);
});

test("a connection that is heard, or whose stop is answered, is kept", () => {
  for (const name of ["heard", "answered"]) {
    const live = page();
    live.stop(stop);
    pass(100);
    if (name === "heard") live.heardMs = nowMs;
    else live.giveUp("k1");
    pass(1_500);
    assert.equal(sockets.length, 1, name);
    live.close();
  }
});

test("a second connection that says nothing is replaced too, each further one after a longer time", () => {
  const live = page();
  live.stop(stop);
  const begun = [];
  for (let step = 0; step < 400; step += 1) {
    pass(50);
    if (sockets.at(-1).readyState === 0 && begun.length < sockets.length - 1) {
      begun.push(nowMs);
      sockets.at(-1).open();
    }
  }
  const between = begun.slice(1).map((ms, at) => ms - begun[at]);
  assert.ok(begun.length >= 3, `${begun}`);
  assert.deepEqual(sockets.slice(1, 4).map((socket) => socket.stops()), [["k1"], ["k1"], ["k1"]]);
  assert.ok(between[1] > between[0] + 1_000, `${between}`);
  live.close();
});
