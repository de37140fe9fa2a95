// Events of a stretch of time: as they are read, the newest first and older ones when somebody asks for them, and as they
// come by themselves. Pure.

import type { Detection, Next } from "../api/types.gen";

/** From a time on and before another, µs since 1970 UTC. */
export interface Stretch {
  readonly fromUs: number;
  readonly toUs: number;
  /** Whether it ends with the present, and has what a vessel tells whose clock is ahead of the server's. */
  readonly open?: boolean;
}

/** A vessel's clock is not further ahead, µs. */
const AHEAD_US = 60_000_000;

/** A part of an answer, the newest first. */
export interface Part<T> {
  readonly items: readonly T[];
  /** How to ask for older ones; null when these are all. */
  readonly next: Next | null;
}

export interface Event {
  readonly time_us: number;
}

/** What is known of a stretch: its newest, without a gap up to where `next` begins. */
export interface Known<T> extends Part<T> {
  readonly stretch: Stretch;
}

/** What tells events apart, and what two reports of one tell together: `before` itself where `next` adds nothing. */
export interface Identity<T> {
  key(one: T): string;
  merged(before: T, next: T): T;
}

/** So many are held of those that come by themselves; beyond that the oldest go. */
export const HELD = 20_000;

/** The newest of a stretch, and after them what was known before where both meet. */
export function refreshed<T extends Event>(before: Known<T> | undefined, answer: Part<T>, stretch: Stretch, { key, merged }: Identity<T>): Known<T> {
  const held = new Map(before?.items.map((one) => [key(one), one]));
  const part = { ...answer, items: answer.items.map((one) => mergedWith(held.get(key(one)), one, merged)) };
  const last = part.items.at(-1);
  const alone = { ...part, stretch };
  // Where nothing older is, or all is new since, there is nothing to go on with.
  if (part.next === null || !last || !before?.items[0] || before.items[0].time_us < last.time_us) return alone;
  const told = new Set(part.items.map(key));
  const older = before.items.filter((one) => one.time_us >= stretch.fromUs && one.time_us <= last.time_us && !told.has(key(one)));
  return older.length ? { items: [...part.items, ...older], next: before.next, stretch } : alone;
}

/** With older ones. */
export function lengthened<T extends Event>(known: Known<T>, part: Part<T>, { key }: Identity<T>): Known<T> {
  const held = new Set(known.items.map(key));
  return { ...known, items: [...known.items, ...part.items.filter((one) => !held.has(key(one)))], next: part.next };
}

/**
 * With some that came by themselves, each once, and without those that the stretch has left behind. `most` are held: where
 * older ones went, `next` tells how to get them again. The same list where nothing changed.
 */
export function joined<T extends Event>(known: Known<T>, fresh: readonly T[], stretch: Stretch, most: number, { key, merged }: Identity<T>): Known<T> {
  const last = known.next ? known.items.at(-1) : undefined;
  // The stretch has left behind where the unknown began.
  const whole = !last || last.time_us < stretch.fromUs;
  // Beyond the last one the history has others that are not in hand: what lies there comes with them.
  const fromUs = whole ? stretch.fromUs : last.time_us;
  const held = new Map(known.items.filter((one) => one.time_us >= stretch.fromUs).map((one) => [key(one), one]));
  for (const one of fresh) {
    const before = held.get(key(one));
    if (before || (one.time_us >= fromUs && one.time_us < endUs(stretch))) held.set(key(one), mergedWith(before, one, merged));
  }
  const items = [...held.values()].sort((one, other) => other.time_us - one.time_us);
  const same = items.length === known.items.length && items.every((one, at) => one === known.items[at]);
  const next = whole ? null : known.next;
  const first = items[most];
  if (!first) return { items: same ? known.items : items, next, stretch };
  const kept = items.slice(0, most);
  const skip = kept.filter(({ time_us }) => time_us === first.time_us).length;
  return { items: kept, next: { from_us: stretch.fromUs, to_us: first.time_us + 1, skip }, stretch };
}

function mergedWith<T>(before: T | undefined, next: T, merged: (before: T, next: T) => T): T {
  return before === undefined ? next : merged(before, next);
}

/** What two reports of one thing tell together: what is null in the first is taken from the second. */
export function completed<T extends object>(before: T, next: T): T {
  const lacks = (Object.keys(next) as (keyof T)[]).filter((name) => before[name] === null && next[name] !== null);
  return lacks.length ? { ...before, ...Object.fromEntries(lacks.map((name) => [name, next[name]])) } : before;
}

/** The same of detections: whether others confirm one changes with what comes, and the newer answer counts. */
export function detectionCompleted(before: Detection, next: Detection): Detection {
  const whole = completed(before, next);
  return next.flags === null ? whole : { ...whole, flags: next.flags, min_lag_s: next.min_lag_s };
}

/** Of what is known, what lies in another stretch: the rest of that is not known. */
export function within<T extends Event>(items: readonly T[], stretch: Stretch): readonly T[] {
  return items.filter((one) => one.time_us >= stretch.fromUs && one.time_us < endUs(stretch));
}

function endUs({ toUs, open }: Stretch): number {
  return open ? toUs + AHEAD_US : toUs;
}

/** The question for a part. */
export function question(stretch: Stretch, limit: number, next: Next | null): string {
  const { from_us, to_us, skip } = next ?? { from_us: stretch.fromUs, to_us: endUs(stretch), skip: 0 };
  return `order=newest&limit=${limit}&skip=${skip}&from_us=${from_us}&to_us=${to_us}`;
}

/**
 * A list, the newest first, with its newest told again: of what was known the older ones stay, where `more` follow. What did
 * not change stays the same object.
 */
export function toldAgain<T extends { readonly id: number }>(before: readonly T[], fresh: readonly T[], more: boolean, timeUs: (one: T) => number): readonly T[] {
  const known = new Map(before.map((one) => [one.id, one]));
  const newest = fresh.map((one) => {
    const same = known.get(one.id);
    return same && JSON.stringify(same) === JSON.stringify(one) ? same : one;
  });
  const last = fresh.at(-1);
  if (!more || !last) return newest;
  const lastUs = timeUs(last);
  return [...newest, ...before.filter((one) => timeUs(one) < lastUs || (timeUs(one) === lastUs && one.id < last.id))];
}
