// The time that a vessel's page tells of, and when its history is asked: bundled for Node, with the browser's parts stood in.

import assert from "node:assert/strict";
import { test } from "node:test";
import { join } from "node:path";
import { load } from "../testing/bundled.mjs";

const frames = [];
globalThis.requestAnimationFrame = (then) => frames.push(then);
const next = (ms) => frames.splice(0).forEach((then) => then(ms));
const { PageTime } = await load("vessel/time");

const NOW = 1_800_000_000_000_000;
function page(range, play = null) {
  const told = [];
  const on = Object.fromEntries(["pointed", "ranged", "played", "remember"].map((name) => [name, (...what) => void told.push([name, ...what].join(" "))]));
  return { told, time: new PageTime({ nowUs: () => NOW, ...on }, { range, play }) };
}

test("the present has no time of its own; what is pointed to has", () => {
  const { time, told } = page({ spanUs: 900e6 });
  assert.equal(time.atUs, null);
  time.hover(NOW - 5e6);
  assert.equal(time.atUs, NOW - 5e6);
  time.hover(null);
  assert.equal(time.atUs, null);
  assert.deepEqual(told, ["pointed", "pointed"]);
});

test("who picks a time of the present stands still in a stretch that does not move", () => {
  const { time } = page({ spanUs: 900e6 });
  time.pick(NOW - 60e6);
  assert.deepEqual(time.range, { fromUs: NOW - 900e6, toUs: NOW });
  assert.deepEqual([time.play.atUs, time.play.playing], [NOW - 60e6, false]);
  assert.equal(time.atUs, NOW - 60e6);
  time.hover(NOW - 30e6);
  assert.equal(time.atUs, NOW - 30e6, "a standing replay gives way to the pointer");
  time.step(1e6);
  assert.equal(time.atUs, NOW - 59e6, "and a step goes on from where it stood");
});

test("a replay plays by its speed, and ends with its stretch", () => {
  const toUs = NOW - 3_600e6;
  const { time, told } = page({ fromUs: toUs - 10e6, toUs }, { atUs: toUs - 10e6, playing: false, speed: 10 });
  time.toggle();
  assert.equal(time.play.playing, true);
  const began = performance.now();
  next(began + 200);
  assert.ok(time.play.atUs > toUs - 10e6 && time.play.atUs < toUs - 7e6, String(time.play.atUs - toUs));
  for (let at = 1; at < 8; at++) next(began + 200 + at * 400);
  assert.deepEqual([time.play.atUs, time.play.playing], [toUs, false], "it stands at the end");
  assert.ok(told.includes("remember true"), "the address tells where");
  const ended = told.length;
  next(began + 9_000);
  assert.equal(told.length, ended, "nothing goes on");
});

test("a replay that comes to the present goes on with it", () => {
  const { time } = page({ fromUs: NOW - 10e6, toUs: NOW - 1e6 }, { atUs: NOW - 1.1e6, playing: false, speed: 1 });
  time.toggle();
  const began = performance.now();
  next(began + 500);
  next(began + 900);
  assert.equal(time.play, null);
  assert.deepEqual(time.range, { spanUs: 9e6 });
});

test("who drags has the address changed in the end only", () => {
  const { time, told } = page({ fromUs: NOW - 20e6, toUs: NOW - 10e6 }, { atUs: NOW - 15e6, playing: false, speed: 1 });
  time.seek(NOW - 12e6);
  time.pan(0.1);
  assert.deepEqual(told.filter((one) => one.startsWith("remember")), ["remember false", "remember false"]);
});
