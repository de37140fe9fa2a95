// The words of the pages in the reader's language. The English text is the key: code stays readable, and what the catalogue
// lacks is shown in English. `words/nb.json` has the words of scripts and of the server's templates; its bundle (`nb.ts`)
// comes before the others where a person reads Bokmål, so that texts may be made as soon as a module is loaded.

import type { Wording } from "../api/types.gen";

declare global {
  /** An English text in the page's language, put there by the bundle of a language; absent in English. */
  var lutraWords: ((english: string) => string | undefined) | undefined;
}

/** The places for values in a text: `"{n} of {all}"` has `n` and `all`. */
type Places<Text extends string> = Text extends `${string}{${infer Name}}${infer Rest}` ? Name | Places<Rest> : never;
type Value = string | number;
type Values<Text extends string> = [Places<Text>] extends [never] ? [] : [values: Readonly<Record<Places<Text>, Value>>];
type Others<Text extends string> = [Exclude<Places<Text>, "n">] extends [never] ? [] : [values: Readonly<Record<Exclude<Places<Text>, "n">, Value>>];

/** `english` in the page's language, with values in its places. Only texts written out here can be found in the catalogue. */
export function t<const Text extends string>(english: Text, ...[values]: Values<Text>): string {
  return filled(said(english), values);
}

/** One text for one, the other for every other count; `{n}` is the count in both. */
export function tn<const One extends string, const More extends string>(n: number, one: One, more: More, ...[values]: Others<One | More>): string {
  return filled(said(n === 1 ? one : more), { ...values, n });
}

/** How many, with the language's mark between thousands: `5,200`, in Bokmål `5 200` with a space that does not break. */
export function count(n: number): string {
  const english = n.toLocaleString("en");
  return globalThis.lutraWords ? english.replaceAll(",", "\u00a0") : english;
}

/** A text that the server sent, with the values in its places where it has any; what the catalogue lacks is English. */
export function fromServer(english: string, values?: Readonly<Record<string, Value | undefined>>): string {
  return filled(said(english), values);
}

/** What the server says, by its wording; without one, a fixed sentence is its own. Not for what may be a vessel's own words. */
export function worded({ text, says }: { readonly text: string; readonly says?: Wording | undefined }): string {
  return says ? fromServer(says.template, says.values) : fromServer(text);
}

function said(english: string): string {
  return globalThis.lutraWords?.(english) ?? english;
}

/** Each place once, from the left: what a value contains is never taken for a place. */
function filled(text: string, values: Readonly<Record<string, Value | undefined>> | undefined): string {
  return values ? text.replace(/\{(\w+)\}/g, (whole, name: string) => (Object.hasOwn(values, name) ? String(values[name]) : whole)) : text;
}
