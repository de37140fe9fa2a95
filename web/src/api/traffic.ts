// The way that every request but STOP's takes to the server.
//
// A browser opens six connections to a server, and a path that swallows what is sent holds each of them for minutes.
// So only some are used here, that one is always free for STOP; and what is asked while the live socket is lost, or
// when it is lost, is given up and asked again by a new connection when the server is heard.

import { anyOf } from "./signal";

/** Requests that are under way at once. */
const AT_ONCE = 4;
/** A question has so long, with all its tries, ms. */
const PATIENCE_MS = 60_000;

/** Whose turn is first: what a person does, what a page asks, what only draws a map. */
export type Rank = "act" | "ask" | "tile";
const RANKS: readonly Rank[] = ["act", "ask", "tile"];

/** What waits for its turn. Its page asks for no more than it shows, and each gives up by its own time. */
const waiting: Readonly<Record<Rank, (() => void)[]>> = { act: [], ask: [], tile: [] };
let busy = 0;

/** Ends what is under way when the link is lost or comes back. */
let present = new AbortController();
/** Resolves when the server is heard again; undefined while it is, and before it was for the first time. */
let absence: { readonly over: Promise<void>; readonly end: () => void } | undefined;

/** The live socket was lost, or is there. */
export function linkIs(up: boolean): void {
  // Questions that began while the server was not heard may hang like those before.
  if (!up || absence) {
    present.abort();
    present = new AbortController();
  }
  if (up) {
    absence?.end();
    absence = undefined;
  } else if (!absence) {
    let end = (): void => undefined;
    const over = new Promise<void>((done) => (end = done));
    absence = { over, end };
  }
}

/** Does `work` when it is its turn; `signal` ends the wait as well as the work. */
export async function inTurn<T>(rank: Rank, signal: AbortSignal, work: () => Promise<T>): Promise<T> {
  await turn(rank, signal);
  try {
    return await work();
  } finally {
    next();
  }
}

/**
 * Asks the server something. `read` takes what is wanted from the answer. What the loss of the link cut off is asked
 * again when the server is heard.
 */
export async function question<T>(rank: Rank, path: string, read: (response: Response) => Promise<T>, signal?: AbortSignal): Promise<T> {
  const patience = AbortSignal.timeout(PATIENCE_MS);
  const mine = signal ? anyOf(patience, signal) : patience;
  for (;;) {
    const cut = present.signal;
    try {
      const all = anyOf(mine, cut);
      return await inTurn(rank, all, async () => read(await fetch(path, { headers: { accept: "application/json" }, signal: all })));
    } catch (error) {
      if (!cut.aborted || mine.aborted) throw error;
      await until(absence?.over ?? Promise.resolve(), mine);
    }
  }
}

/** Waits for a place among those that are under way. */
async function turn(rank: Rank, signal: AbortSignal): Promise<void> {
  signal.throwIfAborted();
  if (busy < AT_ONCE) {
    busy += 1;
    return;
  }
  let mine = (): void => undefined;
  const turned = new Promise<void>((done) => (mine = done));
  waiting[rank].push(mine);
  try {
    await until(turned, signal);
  } catch (error) {
    const at = waiting[rank].indexOf(mine);
    if (at >= 0) waiting[rank].splice(at, 1);
    // The place came at the moment of giving up.
    else next();
    throw error;
  }
}

/** Gives a place that is free to who waits for one. */
function next(): void {
  const first = RANKS.map((rank) => waiting[rank]).find(({ length }) => length)?.shift();
  if (first) first();
  else busy -= 1;
}

/** Waits for what will be, unless `signal` ends the wait. */
function until(what: Promise<void>, signal: AbortSignal): Promise<void> {
  return new Promise((done, failed) => {
    const ended = (): void => failed(signal.reason as Error);
    if (signal.aborted) return ended();
    signal.addEventListener("abort", ended, { once: true });
    void what.then(() => {
      signal.removeEventListener("abort", ended);
      done();
    });
  });
}
