// What alarms say, in both languages: bundled for Node.

import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { test } from "node:test";
import { load } from "../testing/bundled.mjs";

const { adviceOf, alarmText } = await load("state/alarmwords");
const nb = JSON.parse(await readFile("../words/nb.json", "utf8"));
const SINCE_US = 1_780_315_205_000_000;
/** One of each code that crates/api knows, in the order of types.gen.ts. */
const ALL = [
  { code: "part", part: "Left Motor", state: "error", words: "overheated" },
  { code: "no_position", since_us: SINCE_US },
  { code: "hydrophone_silent", since_us: SINCE_US },
  { code: "not_heard", since_us: SINCE_US },
  { code: "never_heard", since_us: SINCE_US },
  { code: "other_source", peer: "10.0.0.9:6002", transport: "udp" },
  { code: "charge", percent: 19 },
  { code: "clock", ahead_ms: -340 },
  { code: "chart", held: true, difference: { stage: "fetching", percent: 43 } },
  { code: "log_book", part: "Logger", words: "the leak sensor is wet" },
  { code: "server", words: "no space left" },
  { code: "disk", free_mib: 1_536 },
  { code: "certificate_ends", file: "/etc/lutra/server.pem", until_us: SINCE_US },
  { code: "certificate_ended", file: "/etc/lutra/server.pem", until_us: SINCE_US },
  { code: "certificate_refused", words: "tls.key /etc/lutra/key.pem: no such file" },
  { code: "no_go_areas", words: "area 3 cannot be read" },
  { code: "too_many", count: 3, most: 1_000 },
];
const said = (...says) => alarmText({ says, text: "as the server said it" });

async function inBokmal(does) {
  globalThis.lutraWords = (english) => nb[english];
  try {
    return await does();
  } finally {
    delete globalThis.lutraWords;
  }
}

test("codes and figures become words", () => {
  assert.equal(said(ALL[6], ALL[0]), "19 % charge left; Left Motor: error: overheated");
  assert.equal(said({ ...ALL[0], words: "" }), "Left Motor: error");
  assert.equal(said(ALL[3]), "not heard since 12:00:05Z");
  assert.equal(said(ALL[4]), "not heard since the server started at 2026-06-01 12:00:05Z");
  assert.equal(said(ALL[7]), "the vessel's clock is 0.3 s behind the server's");
  assert.equal(said({ code: "clock", ahead_ms: 2_000 }), "the vessel's clock is 2.0 s ahead of the server's");
  assert.equal(said(ALL[11]), "1.5 GiB are free on the server's disk");
  assert.equal(said(ALL[12]), "the certificate /etc/lutra/server.pem ends on 2026-06-01 at 12:00:05Z");
  assert.equal(said(), "as the server said it", "kept by an older server");
});

test("every code has words", async () => {
  const types = await readFile("src/api/types.gen.ts", "utf8");
  const declared = /export type AlarmSaying = ([\s\S]*?);\n\nexport/.exec(types)?.[1] ?? "";
  assert.deepEqual(ALL.map(({ code }) => code), [...declared.matchAll(/"code": "(\w+)"/g)].map(([, code]) => code));
  for (const one of ALL) assert.ok(said(one) && !/undefined|\{/.test(said(one)), said(one));
});

test("who reads Bokmål reads alarms and their advice in it, and a vessel's words as they are", async () => {
  await inBokmal(async () => {
    // The tables of a module are made when it is loaded.
    const { adviceOf: advice, alarmText: text } = await load("state/alarmwords", "nb");
    assert.equal(text({ says: [ALL[6], ALL[0]], text: "" }), "19 % lading igjen; Left Motor: feil: overheated");
    assert.equal(text({ says: [ALL[3]], text: "" }), "ikke hørt siden 12:00:05Z");
    assert.equal(text({ says: [ALL[13]], text: "" }), "sertifikatet /etc/lutra/server.pem gikk ut 2026-06-01 kl. 12:00:05Z");
    assert.deepEqual(advice({ cause: "No fish are heard meanwhile.", consequence: "Of a newer server.", action: "It may happen again." }), { cause: "Ingen fisk høres imens.", consequence: "Of a newer server.", action: "Det kan skje igjen." });
  });
  assert.equal(adviceOf({ cause: "No fish are heard meanwhile.", consequence: "", action: "" }).cause, "No fish are heard meanwhile.");
});

test("each way in which a chart differs from the shore's has words, in Bokmål too", async () => {
  const stages = [{ stage: "other" }, { stage: "fetching", percent: 43 }, { stage: "waiting", why: "sailing" }, { stage: "failed", why: "disk full" }, { stage: "declined" }, { stage: "none_ashore" }];
  const all = stages.flatMap((difference) => [true, false].map((held) => ({ code: "chart", held, difference })));
  const english = all.map((one) => said(one));
  assert.equal(new Set(english).size, all.length);
  assert.equal(english[2], "another sea chart than ashore; 43 % of the shore's is transferred");
  assert.equal(english[7], "no sea chart aboard; the chart from shore could not be used: disk full");
  await inBokmal(async () => {
    for (const [at, one] of all.entries()) assert.notEqual(said(one), english[at]);
  });
});
