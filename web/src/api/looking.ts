// Detections by pages: the server looks at so many at once, so that a page may end, with a place to go on, before any was found.

import type { Detections, Detection } from "./types.gen";
import type { Resource } from "./resource";

/** Pages that are asked for one after another, before a person is asked whether to go on. */
const PAGES = 25;

/** What was found so far. */
export interface Looked {
  readonly rows: readonly Detection[];
  /** The question for the rest; empty where nothing is left. */
  readonly rest: string;
}

/** The question for what comes after a page; empty at the end. */
export function restOf({ next }: Pick<Detections, "next">, query: string): string {
  if (!next) return "";
  const rest = new URLSearchParams(query);
  for (const [name, value] of Object.entries(next)) rest.set(name, String(value));
  return rest.toString();
}

/** How far back a question that goes on has been looked, µs. */
export function lookedBackTo(rest: string): number {
  return Number(new URLSearchParams(rest).get("to_us"));
}

/** Asks page by page until there are `enough` rows, or no more, or it has taken many pages; `told` hears of each that is not the
 * last. Undefined where a newer question ended this one, or it failed. */
export async function look(answer: Pick<Resource<Detections>, "ask">, query: string, enough: number, told: (looked: Looked) => void): Promise<Looked | undefined> {
  let looked: Looked = { rows: [], rest: query };
  for (let page = 1; ; page++) {
    const found = await answer.ask(`/api/v1/detections?${looked.rest}`);
    if (!found) return undefined;
    looked = { rows: [...looked.rows, ...found.detections], rest: restOf(found, looked.rest) };
    if (!looked.rest || looked.rows.length >= enough || page >= PAGES) return looked;
    told(looked);
  }
}
