// The words of the pages in the reader's language. The English text is the key: code stays readable, and what the catalogue
// lacks is shown in English. `words/nb.json` has the words of scripts and of the server's templates; a page's bundle of them
// (`nb.ts`) comes before the others where a person reads Bokmål, so that texts may be made as soon as a module is loaded.

import type { Wording } from "../api/types.gen";

declare global {
  /** An English text in the page's language, put there by the bundle of a language; absent in English. */
  var lutraWords: ((english: string) => string | undefined) | undefined;
  /** Fetches the words of parts that come after the map and STOP, once; it never fails. Absent in English. */
  var lutraSoonWords: (() => Promise<void>) | undefined;
  /** The same of refusals and of parts that few open. */
  var lutraMoreWords: (() => Promise<void>) | undefined;
  /** A text was said in English; `again` says it once more, when words have come. Absent in English. */
  var lutraMissed: ((text: string, again: () => string) => void) | undefined;
}

/** The places for values in a text: `"{n} of {all}"` has `n` and `all`. */
type Places<Text extends string> = Text extends `${string}{${infer Name}}${infer Rest}` ? Name | Places<Rest> : never;
type Value = string | number;
type Values<Text extends string> = [Places<Text>] extends [never] ? [] : [values: Readonly<Record<Places<Text>, Value>>];
type Others<Text extends string> = [Exclude<Places<Text>, "n">] extends [never] ? [] : [values: Readonly<Record<Exclude<Places<Text>, "n">, Value>>];

/** `english` in the page's language, with values in its places. Only texts written out here can be found in the catalogue. */
export function t<const Text extends string>(english: Text, ...[values]: Values<Text>): string {
  return inPlace(english, values);
}

/** One text for one, the other for every other count; `{n}` is the count in both. */
export function tn<const One extends string, const More extends string>(n: number, one: One, more: More, ...[values]: Others<One | More>): string {
  return inPlace(n === 1 ? one : more, { ...values, n });
}

/** How many, with the language's mark between thousands: `5,200`, in Bokmål `5 200` with a space that does not break. */
export function count(n: number): string {
  const english = n.toLocaleString("en");
  return globalThis.lutraWords ? english.replaceAll(",", "\u00a0") : english;
}

/** A text that the server sent, with the values in its places where it has any; what the catalogue lacks is English. */
export function fromServer(english: string, values?: Readonly<Record<string, Value | undefined>>): string {
  return inPlace(english, values);
}

/** What the server says, by its wording; without one, a fixed sentence is its own. Not for what may be a vessel's own words. */
export function worded({ text, says }: { readonly text: string; readonly says?: Wording | undefined }): string {
  return says ? inWords(says) : fromServer(text);
}

/** Loads a part of a page that few open, when its words are here: texts are made as soon as it is loaded. */
export async function later<Part>(load: () => Promise<Part>): Promise<Part> {
  if (globalThis.lutraMoreWords) await Promise.race([globalThis.lutraMoreWords(), elapsed(PART_MS)]);
  return load();
}

/** Loads a part that each such page shows after what matters more, with its words (`scripts/words.mjs` has it among SOON). */
export async function soon<Part>(load: () => Promise<Part>): Promise<Part> {
  if (globalThis.lutraSoonWords) await Promise.race([globalThis.lutraSoonWords(), elapsed(PART_MS)]);
  return load();
}

/** A part of a page waits this long for its words at most, ms; then its texts are English. */
const PART_MS = 20_000;

/** A refusal waits this long for its words at most, ms. */
const WORDS_MS = 2_000;

/** Returns when the words of `says` are here, or do not come in time: then it is said in English. */
export async function withWords(...says: readonly (Wording | undefined)[]): Promise<void> {
  const lacks = ({ template, parts = {} }: Wording): boolean => /\p{L}/u.test(template.replace(/\{\w+\}/g, "")) && globalThis.lutraWords?.(template) === undefined || Object.values(parts).flatMap((texts) => texts ?? []).some(lacks);
  if (!globalThis.lutraMoreWords || !says.some((one) => one && lacks(one))) return;
  await Promise.race([globalThis.lutraMoreWords(), elapsed(WORDS_MS)]);
}

function elapsed(ms: number): Promise<void> {
  return new Promise((late) => setTimeout(late, ms));
}

/** A place holds a value, or texts with words of their own, each on a line. */
function inWords({ template, values, parts = {} }: Wording): string {
  const lines = Object.entries(parts).map(([name, texts]) => [name, (texts ?? []).map(inWords).join("\n")]);
  return fromServer(template, { ...values, ...Object.fromEntries(lines) });
}

function inPlace(english: string, values: Readonly<Record<string, Value | undefined>> | undefined): string {
  const words = globalThis.lutraWords?.(english);
  const text = filled(words ?? english, values);
  if (words === undefined) globalThis.lutraMissed?.(text, () => filled(globalThis.lutraWords?.(english) ?? english, values));
  return text;
}

/** Each place once, from the left: what a value contains is never taken for a place. */
function filled(text: string, values: Readonly<Record<string, Value | undefined>> | undefined): string {
  return values ? text.replace(/\{(\w+)\}/g, (whole, name: string) => (Object.hasOwn(values, name) ? String(values[name]) : whole)) : text;
}
