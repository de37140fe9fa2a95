// When each tag was heard: a row for each tag, a tick for each detection.

import type { Detection } from "../api/types.gen";
import { tagSeries } from "../state/tags";
import { tagName, utc } from "../ui/format";
import { t, tn } from "../words/words";

export interface TagTimes {
  readonly tag: string;
  readonly id: number;
  /** When, µs since 1970 UTC. */
  readonly all: readonly number[];
}

/** So many rows at most: those that were heard most. */
const ROWS = 24;
const [WIDTH, ROW] = [1_000, 22];

/** By tag, the one that was heard most first. */
export function timesOf(detections: readonly Detection[]): readonly TagTimes[] {
  const groups = new Map<string, { tag: string; id: number; all: number[] }>();
  for (const one of detections) {
    const tag = tagName(one);
    const group = groups.get(tag) ?? { tag, id: one.tag_id, all: [] };
    group.all.push(one.heard_us ?? one.time_us);
    groups.set(tag, group);
  }
  return [...groups.values()].sort((one, other) => other.all.length - one.all.length || one.tag.localeCompare(other.tag));
}

export function Times({ groups }: { readonly groups: readonly TagTimes[] }) {
  const all = groups.flatMap((group) => group.all);
  if (!all.length) return null;
  const [first, last] = [all.reduce((one, other) => Math.min(one, other)), all.reduce((one, other) => Math.max(one, other))];
  const shown = groups.slice(0, ROWS);
  const x = (us: number): number => Math.round(((us - first) / Math.max(1, last - first)) * WIDTH);
  return (
    <figure class="times">
      <ul>
        {shown.map(({ tag, id, all }) => (
          <li key={tag}>
            <span class="num">{tag}</span>
            <svg viewBox={`-4 0 ${WIDTH + 8} ${ROW}`} preserveAspectRatio="none" data-tick={tagSeries(id)} role="img" aria-label={tn(all.length, "{tag}: {n} time, {first} to {last}", "{tag}: {n} times, {first} to {last}", { tag, first: utc(Math.min(...all)), last: utc(Math.max(...all)) })}>
              <path d={[...new Set(all.map(x))].map((at) => `M${at} 3v${ROW - 6}`).join("")} />
            </svg>
          </li>
        ))}
      </ul>
      <figcaption class="num"><span>{utc(first)}</span><span>{utc(last)}</span></figcaption>
      {groups.length > ROWS && <p class="dim">{t("The {shown} tags that were heard most, of {all}.", { shown: ROWS, all: groups.length })}</p>}
    </figure>
  );
}
