// The texts of the pages that are keys of the catalogue of words: in scripts by TypeScript's own parser, in templates and in
// the server's code by how they are written there.

import { readdir, readFile } from "node:fs/promises";
import { API } from "typescript/unstable/sync";
import { isCallExpression, isIdentifier, isNoSubstitutionTemplateLiteral, isStringLiteral } from "typescript/unstable/ast/is";

/** How many of a call's arguments are texts. */
const TEXTS = { t: [0], tn: [1, 2] };

/** Each `[text, where]` of `src`, and where a call has no text that can be read. */
export function keysOfScripts(project) {
  const api = new API({ cwd: project });
  try {
    const config = `${project}/tsconfig.json`;
    const { program, rootFiles } = api.updateSnapshot({ openProject: config }).getProject(config);
    const [keys, unreadable] = [[], []];
    for (const path of rootFiles.filter((one) => !one.endsWith("/words/words.ts"))) {
      const where = path.slice(project.length + 1);
      const visit = (node) => {
        if (isCallExpression(node) && isIdentifier(node.expression) && node.expression.text in TEXTS) {
          for (const at of TEXTS[node.expression.text]) {
            const text = node.arguments[at];
            if (text && (isStringLiteral(text) || isNoSubstitutionTemplateLiteral(text))) keys.push([text.text, where]);
            else unreadable.push(where);
          }
        }
        node.forEachChild(visit);
      };
      visit(program.getSourceFile(path));
    }
    return { keys, unreadable };
  } finally {
    api.close();
  }
}

/** A text as Rust and askama write it. */
const RUST = String.raw`"((?:[^"\\]|\\.)*)"`;
const unescaped = (text) => JSON.parse(`"${text.replace(/\\\n\s*/g, "")}"`);

/** Each `[text, where]` of `.t("…")`, `t(language, "…")` and `word("…")` in the templates and the server's pages. */
export async function keysOfServer(server) {
  const files = [];
  for (const [folder, end] of [["templates", ".html"], ["src/pages", ".rs"]]) {
    for (const name of await readdir(`${server}/${folder}`, { recursive: true })) if (name.endsWith(end)) files.push(`${folder}/${name}`);
  }
  const keys = [];
  for (const where of files.filter((one) => !one.endsWith("/words.rs"))) {
    const text = await readFile(`${server}/${where}`, "utf8");
    const calls = [...text.matchAll(new RegExp(String.raw`\b(?:t|word)\(\s*(?:\w+(?:\.\w+)*,\s*)?${RUST}`, "g"))];
    for (const [, key] of calls) keys.push([unescaped(key), where]);
  }
  return keys;
}

/** Each `[text, where]` of what the server says outside its pages: alarms' words and advice, and messages about alarms. */
export async function keysOfAlarms(root) {
  const keys = [];
  const within = async (where, begin, end) => {
    const text = await readFile(`${root}/${where}`, "utf8");
    const part = text.slice(text.indexOf(begin), text.indexOf(end, text.indexOf(begin)));
    for (const [, key] of part.matchAll(new RegExp(RUST, "gs"))) if (!/^(\{\w+\}[: ]*)+$/.test(key)) keys.push([unescaped(key), where]);
  };
  await within("crates/operations/src/alarms/kind.rs", "pub const fn advice", "Advice { cause");
  await within("crates/api/src/alarms.rs", "pub fn template", "pub fn values");
  const where = "shore/src/notices/content.rs";
  const text = await readFile(`${root}/${where}`, "utf8");
  for (const [, key] of text.matchAll(new RegExp(String.raw`\b(?:t|said|say)\(\s*(?:language,\s*)?${RUST}`, "g"))) keys.push([unescaped(key), where]);
  return keys;
}

/** Whether a template has words beside its places. */
const hasWords = (template) => /\p{L}/u.test(template.replace(/\{\w+\}/g, ""));

const matches = async (root, where, pattern) => (await readFile(`${root}/${where}`, "utf8")).matchAll(pattern);

/** Where refusals and outcomes are worded, and which of these only the server's own pages say. Passwords are of links to datasets too. */
const WORDED = ["crates/operations/src", "crates/hub/src", "crates/research/src", "shore/src", "server/src"];
const ON_PAGES = /^shore\/src\/(identity\/(?!password)|notices\/)|^server\/src\/(pages|transports)\//;

/** Each `[text, where]` of what the server says of refusals and outcomes: `say("…")`, `fixed("…")`, why the downlink sends no order,
 * and why nobody steers by hand. `scripts`: those alone that reach a browser's scripts by the API. */
export async function keysOfSaid(root, { scripts = false } = {}) {
  const keys = [];
  for (const folder of WORDED) {
    for (const name of await readdir(`${root}/${folder}`, { recursive: true })) {
      const where = `${folder}/${name}`;
      // What only messages about alarms say is found with these.
      if (!name.endsWith(".rs") || /tests?\b/.test(name) || where === "shore/src/notices/content.rs" || (scripts && ON_PAGES.test(where))) continue;
      const [text] = (await readFile(`${root}/${where}`, "utf8")).split(/^#\[cfg\(test\)\]\nmod tests \{/m);
      const said = where === "crates/hub/src/downlink.rs" ? "Refused" : "(?:say|fixed)";
      for (const [, key] of text.matchAll(new RegExp(String.raw`\b${said}\(\s*${RUST}`, "gs"))) if (hasWords(key)) keys.push([unescaped(key), where]);
    }
  }
  const fields = "crates/research/src/fields.rs";
  for (const [, key] of await matches(root, fields, new RegExp(String.raw`\bneeded\(\s*"\w+",\s*${RUST}`, "gs"))) keys.push([unescaped(key), fields]);
  for (const [, key] of await matches(root, fields, new RegExp(String.raw`RegisterKind::\w+ => ${RUST}`, "g"))) keys.push([unescaped(key), fields]);
  const where = "crates/operations/src/teleop/mod.rs";
  const text = await readFile(`${root}/${where}`, "utf8");
  const part = text.slice(text.indexOf("pub fn text(self)"), text.indexOf("\n}\n", text.indexOf("pub fn remedy(self)")));
  for (const [, key] of part.matchAll(new RegExp(RUST, "gs"))) if (key) keys.push([unescaped(key), where]);
  return keys;
}

/** The places for values in a text, in the order of the alphabet. */
export const placesOf = (text) => [...new Set([...text.matchAll(/\{(\w+)\}/g)].map(([, name]) => name))].sort();
