// Very many points as what can be seen of them: least, greatest and mean of each pixel's width. Pure.

import type { Table } from "./model";

/** Up to so many points for each pixel are drawn as they are; of more, so many are summed up once and for all. */
const DENSE = 8;

/** Sums of neighbouring points without a gap between them. */
interface Blocks {
  /** Rows of the first and after the last point. */
  readonly from: number[];
  readonly to: number[];
  readonly max: number[];
  readonly min: number[];
  readonly mean: number[];
}

const known = new WeakMap<Table, Blocks>();

/**
 * The part of `table` from `from` to `to` (s) as it can be seen on so many pixels, with a point to either side where
 * there is one. A row of nulls is a gap and stays one where it is wider than a pixel. A table that is thinned must not
 * change any more.
 */
export function thinned(table: Table, from: number, to: number, pixels: number): Table {
  const [times] = table;
  const dense = DENSE * Math.max(1, pixels);
  if (times.length <= dense) return table;
  const [first, after] = [Math.max(0, rowAt(times, from) - 1), Math.min(times.length, rowAt(times, to) + 2)];
  if (after - first <= dense) return table.map((column) => column.slice(first, after)) as Table;
  return summed(table, blocksOf(table), first, after, (to - from) / Math.max(1, pixels));
}

/** The first row that is not before `time`. */
function rowAt(times: readonly number[], time: number): number {
  let [low, high] = [0, times.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if ((times[middle] ?? Infinity) < time) low = middle + 1;
    else high = middle;
  }
  return low;
}

function blocksOf(table: Table): Blocks {
  const found = known.get(table);
  if (found) return found;
  const [times, maxima, minima, means] = table;
  const blocks: Blocks = { from: [], to: [], max: [], min: [], mean: [] };
  for (let at = 0; at < times.length; ) {
    const begun = at;
    let [max, min, sum] = [-Infinity, Infinity, 0];
    for (; at < times.length && at - begun < DENSE; at++) {
      const [high, low, mean] = [maxima[at], minima[at], means[at]];
      if (typeof high !== "number" || typeof low !== "number") break;
      if (high > max) max = high;
      if (low < min) min = low;
      sum += mean ?? (high + low) / 2;
    }
    if (at > begun) {
      blocks.from.push(begun);
      blocks.to.push(at);
      blocks.max.push(max);
      blocks.min.push(min);
      blocks.mean.push(sum / (at - begun));
    } else at++;
  }
  known.set(table, blocks);
  return blocks;
}

/** The blocks that reach into these rows, those within `wide` (s) of each other as one point. */
function summed([times]: Table, { from, to, max, min, mean }: Blocks, first: number, after: number, wide: number): Table {
  const made: Table = [[], [], [], []];
  const put = (at: number, high: number | null, low: number | null, middle: number | null): void => {
    made[0].push(at);
    made[1].push(high);
    made[2].push(low);
    made[3].push(middle);
  };
  let block = rowAt(to, first + 1);
  let ended = -Infinity;
  while (block < from.length && from[block]! < after) {
    const begun = times[from[block]!]!;
    let [last, high, low, sum, count] = [begun, -Infinity, Infinity, 0, 0];
    // A gap is where a block begins later than in the row after the one before.
    if (block > 0 && from[block]! > to[block - 1]! && begun - ended > wide && ended > -Infinity) put((ended + begun) / 2, null, null, null);
    for (; block < from.length && from[block]! < after; block++) {
      const upTo = times[to[block]! - 1]!;
      const apart = count > 0 && from[block]! > to[block - 1]! && times[from[block]!]! - last > wide;
      if (count > 0 && (apart || upTo - begun > wide)) break;
      const size = to[block]! - from[block]!;
      high = Math.max(high, max[block]!);
      low = Math.min(low, min[block]!);
      sum += mean[block]! * size;
      count += size;
      last = upTo;
    }
    put((begun + last) / 2, high, low, sum / count);
    ended = last;
  }
  return made;
}
