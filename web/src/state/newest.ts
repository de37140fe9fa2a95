// Events of a stretch of time as they are read: the newest first, older ones when somebody asks for them. Pure.

import type { Next } from "../api/types.gen";

/** From a time on and before another, µs since 1970 UTC. */
export interface Stretch {
  readonly fromUs: number;
  readonly toUs: number;
}

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

/** The newest of a stretch, and after them what was known before where both meet. `key` tells events of one time apart. */
export function refreshed<T extends Event>(before: Known<T> | undefined, part: Part<T>, stretch: Stretch, key: (one: T) => string): Known<T> {
  const last = part.items.at(-1);
  const alone = { ...part, stretch };
  // Where nothing older is, or all is new since, there is nothing to go on with.
  if (part.next === null || !last || !before?.items[0] || before.items[0].time_us < last.time_us) return alone;
  const told = new Set(part.items.map(key));
  const older = before.items.filter((one) => one.time_us >= stretch.fromUs && one.time_us <= last.time_us && !told.has(key(one)));
  return older.length ? { items: [...part.items, ...older], next: before.next, stretch } : alone;
}

/** With older ones. */
export function lengthened<T extends Event>(known: Known<T>, part: Part<T>): Known<T> {
  return { ...known, items: [...known.items, ...part.items], next: part.next };
}

/** Of what is known, what lies in another stretch: the rest of that is not known. */
export function within<T extends Event>(items: readonly T[], { fromUs, toUs }: Stretch): readonly T[] {
  return items.filter((one) => one.time_us >= fromUs && one.time_us < toUs);
}

/** The question for a part. */
export function question({ fromUs, toUs }: Stretch, limit: number, next: Next | null): string {
  const { from_us, to_us, skip } = next ?? { from_us: fromUs, to_us: toUs, skip: 0 };
  return `order=newest&limit=${limit}&skip=${skip}&from_us=${from_us}&to_us=${to_us}`;
}
