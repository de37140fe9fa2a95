// Tags as people tell them apart: by protocol and number, each in a colour of its own on every map, in every table and plot.

import type { Detection } from "../api/types.gen";
import { tagName } from "../ui/format";

/** A tag and how often it was heard. */
export interface TagCount {
  readonly tag: string;
  readonly id: number;
  readonly count: number;
}

/** How many colours tags have. */
const COLOURS = 4;

/** Which of the series' colours a tag has: that of its number, wherever and with whichever others it is shown. */
export function tagSeries(id: number): number {
  return id % COLOURS;
}

/** By tag, the one that was heard most first. */
export function countsOf(detections: readonly Detection[]): readonly TagCount[] {
  const counts = new Map<string, { tag: string; id: number; count: number }>();
  for (const one of detections) {
    const tag = tagName(one);
    const known = counts.get(tag);
    if (known) known.count += 1;
    else counts.set(tag, { tag, id: one.tag_id, count: 1 });
  }
  return [...counts.values()].sort((one, other) => other.count - one.count || one.tag.localeCompare(other.tag));
}

/** Those whose name has one of the words that are looked for; all where none is. */
export function tagsFound<T extends { readonly tag: string }>(tags: readonly T[], words: string): readonly T[] {
  const wanted = words.toLowerCase().split(/[\s,]+/).filter(Boolean);
  return wanted.length ? tags.filter(({ tag }) => wanted.some((word) => tag.toLowerCase().includes(word))) : tags;
}

/** The names that are left out, with these also, or no longer. */
export function withHidden(hidden: ReadonlySet<string>, tags: readonly string[], out: boolean): ReadonlySet<string> {
  const next = new Set(hidden);
  for (const tag of tags) {
    if (out) next.add(tag);
    else next.delete(tag);
  }
  return next;
}
