// The catalogue of words against what scripts, templates and the server's pages ask of it: `npm test` runs this.

import assert from "node:assert/strict";
import { test } from "node:test";
import { build } from "esbuild";
import { readdir, readFile } from "node:fs/promises";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { keysOfAlarms, keysOfSaid, keysOfScripts, keysOfServer, placesOf } from "../scripts/keys.mjs";
import { OWN, reached, SHARED, SOON, wordsByBundle } from "../scripts/words.mjs";
import { pack, unpack } from "../src/words/packed.mjs";
import { folder } from "../testing/bundled.mjs";

const web = dirname(dirname(fileURLToPath(import.meta.url)));
const text = await readFile(join(web, "../words/nb.json"), "utf8");
const nb = JSON.parse(text);
const scripts = keysOfScripts(web);
const server = await keysOfServer(join(web, "../server"));
const alarms = await keysOfAlarms(join(web, ".."));
const refusals = await keysOfSaid(join(web, ".."));
const asked = new Map([...scripts.keys, ...server, ...alarms, ...refusals]);

test("texts are found in scripts, templates and the server's code", () => {
  assert.ok(scripts.keys.length > 1_000, `${scripts.keys.length} in scripts`);
  for (const [key, where] of [
    ["STOP ALL", "src/ui/stopall.ts"],
    ["{n} note.", "src/pages/logbook.tsx"],
    ["Log out", "templates/base.html"],
    ["{role} on {place}", "src/pages/rows.rs"],
    ["Acknowledge alarm", "src/pages/actions.rs"],
    ["No fish are heard meanwhile.", "crates/operations/src/alarms/kind.rs"],
    ["There is no person {name}.", "shore/src/identity/persons.rs"],
    ["it came too late", "crates/hub/src/downlink.rs"],
    ["the vessel has it and does not answer", "crates/operations/src/commands/mod.rs"],
    ["`{name}` stands in line {first} too; keep one", "crates/research/src/csv.rs"],
    ["name of the receiver", "crates/research/src/fields.rs"],
    ["the dead-man was released", "crates/operations/src/teleop/mod.rs"],
    ["You asked for this message under your name on the pages, Messages about alarms.", "shore/src/notices/content.rs"],
  ]) {
    assert.ok([...scripts.keys, ...server, ...alarms, ...refusals].some((one) => one[0] === key && one[1] === where), `${key} in ${where}`);
  }
  assert.deepEqual(scripts.unreadable, [], "t and tn take texts that are written out, or nobody finds them");
});

test("alarms have the same words in scripts as in the server's mails and logs", () => {
  const inScripts = new Set(scripts.keys.map(([key]) => key));
  const templates = alarms.filter(([, where]) => where === "crates/api/src/alarms.rs").map(([key]) => key);
  assert.ok(templates.length > 8, templates.join());
  assert.deepEqual(templates.filter((key) => !inScripts.has(key)), []);
});

test("Bokmål has every text", () => {
  const missing = [...asked].filter(([key]) => !Object.hasOwn(nb, key)).map(([key, where]) => `${where}: ${key}`);
  assert.deepEqual(missing, [], "words/nb.json lacks these");
});

test("each page has its words in a bundle, and the server sends that one", async () => {
  const main = await readFile(join(web, "src/main.ts"), "utf8");
  const pages = [...main.matchAll(/import\("\.\/pages\/(\w+)"\)/g)].map(([, page]) => page);
  assert.deepEqual([...OWN, ...SHARED].sort(), pages.sort());
  const frame = await readFile(join(web, "../server/src/pages/frame.rs"), "utf8");
  const bundles = [...frame.slice(frame.indexOf("fn bundle_of("), frame.indexOf("_ => return None")).matchAll(/=> "(\w+)",/g)].map(([, page]) => page);
  assert.deepEqual(bundles.sort(), [...OWN].sort());
});

test("what is loaded with a page is known, without what it loads later", () => {
  const inputs = {
    "src/main.ts": { imports: [{ path: "a", kind: "import-statement" }, { path: "src/pages/x.ts", kind: "dynamic-import" }] },
    "src/pages/x.ts": { imports: [{ path: "b", kind: "import-statement" }, { path: "c", kind: "dynamic-import" }] },
    a: { imports: [] }, b: { imports: [{ path: "a", kind: "import-statement" }] }, c: { imports: [] },
  };
  assert.deepEqual([...reached(inputs, ["src/main.ts"])].sort(), ["a", "src/main.ts"]);
  assert.deepEqual([...reached(inputs, ["src/main.ts", "src/pages/x.ts"])].sort(), ["a", "b", "src/main.ts", "src/pages/x.ts"]);
});

test("what one page has from the start and another later is among the words that come later", async () => {
  const source = (page) => `src/pages/${page}.ts`;
  const inputs = Object.fromEntries([...OWN, ...SHARED].map((page) => [source(page), { imports: [] }]));
  const refusal = (kind) => ({ imports: [{ path: "src/state/refusal.ts", kind }] });
  Object.assign(inputs, { "src/main.ts": { imports: [] }, "src/state/refusal.ts": { imports: [] }, [source("plan")]: refusal("import-statement"), [source("vessel")]: refusal("dynamic-import") });
  const bundles = await wordsByBundle(web, inputs, source);
  assert.deepEqual(["plan", "vessel", "rest"].map((name) => "the chosen place" in bundles[name]), [true, false, true]);
});

test("a part that is loaded later waits for its words", async () => {
  const at = [];
  for (const name of await readdir(join(web, "src"), { recursive: true })) {
    if (!/\.tsx?$/.test(name) || name === "main.ts") continue;
    const source = await readFile(join(web, "src", name), "utf8");
    for (const [call] of source.matchAll(/(?:\w+\(\(\) => )?\bimport\("[^"]*"\)/g)) {
      const isSoon = call.startsWith("soon(() => ") && SOON.includes(`src/${join(dirname(name), call.slice(call.indexOf('"') + 1, -2))}.ts`);
      if (!isSoon && !call.startsWith("later(() => ")) at.push(`${name}: ${call}`);
    }
  }
  assert.deepEqual(at, [], "load it by later(() => import(…)), or by soon where scripts/words.mjs has it among SOON");
});

test("only foreign words are said as they are", async () => {
  const own = [];
  for (const folder of ["crates/api/src", "crates/operations/src", "crates/research/src", "shore/src", "server/src"]) {
    for (const name of await readdir(join(web, "..", folder), { recursive: true })) {
      if (!name.endsWith(".rs") || /tests?\b/.test(name)) continue;
      const [text] = (await readFile(join(web, "..", folder, name), "utf8")).split(/^#\[cfg\(test\)\]\nmod tests \{/m);
      for (const [call] of text.matchAll(/\bas_is\(\s*(?:"[^"]*"|&?format!\([^)]*\))/g)) own.push(`${folder}/${name}: ${call}`);
    }
  }
  assert.deepEqual(own, [], "word these by say(\"…\") with values: Said::as_is is for what vessels, systems and other programs say");
});

test("Bokmål has no text that nobody asks for", () => {
  assert.deepEqual(Object.keys(nb).filter((key) => !asked.has(key)), [], "take these out of words/nb.json");
});

test("a text in Bokmål has the places and the marks of the English one", () => {
  const marks = (one) => [...one.matchAll(/<[^>]+>/g)].map(([mark]) => mark).sort();
  for (const [english, bokmal] of Object.entries(nb)) {
    assert.deepEqual(placesOf(bokmal), placesOf(english), english);
    assert.deepEqual(marks(bokmal), marks(english), english);
    assert.ok(bokmal.trim() === bokmal && bokmal !== "", english);
  }
});

test("the catalogue is in the order of its keys, each once", () => {
  const keys = [...text.matchAll(/^ "((?:[^"\\]|\\.)*)":/gm)].map(([, key]) => JSON.parse(`"${key}"`));
  assert.equal(keys.length, Object.keys(nb).length);
  assert.deepEqual(keys, [...keys].sort((one, other) => (one < other ? -1 : one > other ? 1 : 0)));
});

test("a text is said in the page's language, its values put in once", async () => {
  const outfile = join(folder, "words-words.mjs");
  await build({ entryPoints: [join(web, "src/words/words.ts")], bundle: true, format: "esm", outfile, logLevel: "warning" });
  const { t, tn } = await import(outfile);
  assert.equal(t("{name} has control.", { name: "{name} {by}" }), "{name} {by} has control.");
  assert.equal(tn(1, "{n} note.", "{n} notes."), "1 note.");
  globalThis.lutraWords = unpack(pack(nb));
  try {
    assert.equal(t("STOP {name}", { name: "otter-1" }), "STOPP otter-1");
    assert.deepEqual([0, 1, 2].map((n) => tn(n, "{n} note.", "{n} notes.")), ["0 notater.", "1 notat.", "2 notater."]);
    assert.equal(t("Nobody wrote this down: {n}.", { n: 3 }), "Nobody wrote this down: 3.");
    for (const inherited of ["constructor", "toString"]) assert.equal(t(inherited), inherited);
  } finally {
    delete globalThis.lutraWords;
  }
});

test("a text within a text has its own words, and what has none stays as it is", async () => {
  const outfile = join(folder, "worded-words.mjs");
  await build({ entryPoints: [join(web, "src/words/words.ts")], bundle: true, format: "esm", outfile, logLevel: "warning" });
  const { worded, withWords } = await import(outfile);
  const field = (name, template) => ({ template: "{field}: {text}", values: { field: name }, parts: { text: [{ template, values: { count: "3", most: "2" } }] } });
  const says = { template: "{lines}", values: {}, parts: { lines: [field("tags", "there are {count}; at most {most} are allowed"), { template: "{text}", values: { text: "the disk says {text}" } }] } };
  assert.equal(worded({ text: "", says }), "tags: there are 3; at most 2 are allowed\nthe disk says {text}");
  let fetched = 0;
  globalThis.lutraWords = () => undefined;
  globalThis.lutraMoreWords = async () => {
    fetched += 1;
    globalThis.lutraWords = unpack(pack(nb));
  };
  try {
    await withWords(undefined, says);
    assert.equal(worded({ text: "", says }), "tags: det er 3; høyst 2 er tillatt\nthe disk says {text}");
    await withWords(says);
    assert.equal(fetched, 1, "nothing is fetched for what is known");
  } finally {
    delete globalThis.lutraWords;
    delete globalThis.lutraMoreWords;
  }
});

/** Bokmål as a page has it: its own words, those that come soon, and the rest. */
async function speaking(t, soon, rest) {
  t.mock.timers.enable({ apis: ["setTimeout"] });
  t.after(() => {
    for (const name of ["lutraWords", "lutraSoonWords", "lutraMoreWords", "lutraMissed"]) delete globalThis[name];
  });
  const outfile = join(folder, "speak-nb.mjs");
  await build({ entryPoints: [join(web, "src/words/nb.ts")], bundle: true, format: "esm", outfile, logLevel: "warning" });
  (await import(outfile)).speak(pack({ Vessel: "Fartøy" }), soon, rest);
}

const failing = () => Promise.reject(new TypeError("no network"));

test("words that failed to load are asked for at the next need", async (t) => {
  const answers = [failing, () => Promise.resolve(pack({ "{n} note.": "{n} notat." }))];
  let asked = 0;
  await speaking(t, failing, () => answers[asked++]());
  await globalThis.lutraMoreWords();
  assert.deepEqual(["Vessel", "{n} note."].map(globalThis.lutraWords), ["Fartøy", undefined]);
  await Promise.all([globalThis.lutraMoreWords(), globalThis.lutraMoreWords()]);
  assert.equal(globalThis.lutraWords("{n} note."), "{n} notat.");
  await globalThis.lutraMoreWords();
  assert.equal(asked, 2, "each file is fetched once");
});

test("words that failed to load are asked for by themselves, ever later", async (t) => {
  let asked = 0;
  await speaking(t, () => (++asked > 2 ? Promise.resolve(pack({ "Add a field": "Legg til felt" })) : failing()), failing);
  await globalThis.lutraSoonWords();
  const settled = async () => { for (let turn = 0; turn < 8; turn++) await undefined; };
  for (const [after, wanted] of [[4_999, 1], [1, 2], [9_999, 2], [1, 3], [100_000, 3]]) {
    t.mock.timers.tick(after);
    await settled();
    assert.equal(asked, wanted, `${after} ms later`);
  }
  assert.equal(globalThis.lutraWords("Add a field"), "Legg til felt");
});

test("texts that were said in English are said again once their words are here", async () => {
  const outfile = join(folder, "reword-reword.mjs");
  await build({ entryPoints: [join(web, "src/words/reword.ts")], bundle: true, format: "esm", outfile, logLevel: "warning" });
  const reworder = new (await import(outfile)).Reworder();
  reworder.missed("there are 3 tags", () => "det er 3 merker");
  reworder.missed("there are 3 tags; at most 2 are allowed", () => "det er 3 merker; høyst 2 er tillatt");
  reworder.missed("land", () => "land (no)");
  reworder.missed("the disk is full", () => "the disk is full");
  for (const [before, wanted] of [
    ["there are 3 tags", "det er 3 merker"],
    ["Ikke lagret: there are 3 tags.", "Ikke lagret: det er 3 merker."],
    ["x: there are 3 tags; at most 2 are allowed", "x: det er 3 merker; høyst 2 er tillatt"],
    ["land", "land (no)"],
    ["iceland", "iceland"],
    ["the disk is full", "the disk is full"],
    ["something else", "something else"],
  ]) {
    assert.equal(reworder.said(before), wanted);
  }
});

test("a packed catalogue gives each of its texts again and nothing else", () => {
  const said = unpack(pack(nb));
  for (const [english, text] of Object.entries(nb)) assert.equal(said(english), text);
  assert.equal(said("Nobody wrote this down."), undefined);
  assert.throws(() => pack({ costarring: "a", liquid: "b" }), /word one of them differently/, "two texts that are known to share their 32 bits");
});
