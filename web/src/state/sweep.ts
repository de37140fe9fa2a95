// Lines to and fro over a polygon, as one path: parallel, at a spacing, cut at its edges. Pure.

import type { PlanPlace } from "../api/types.gen";
import { t } from "../words/words";
import { bearingTo, groundAt, type Metres, turned, turnedBack, within360 } from "./ground";

/** A path has no more points. */
const MOST_POINTS = 2_000;
/** A piece of a line that is shorter only touches a corner, m. */
const LEAST_M = 0.5;

/** An area that is wider by such a part of the spacing needs no further line. */
const SLACK = 0.01;

/** A piece of a line inside the polygon: how far across, and from where to where along. */
interface Piece {
  readonly right: number;
  readonly from: number;
  readonly to: number;
}

export interface Sweep {
  readonly points: readonly PlanPlace[];
  /** Along which the lines run, °. */
  readonly bearing_deg: number;
  /** In how many pieces all lines are. */
  readonly lines: number;
}

/**
 * A path over a polygon: along `bearing_deg`, or along what makes for the fewest lines. No place inside is farther from a line
 * than half the spacing. It begins near the first corner. Between parts of a polygon that is not convex it may leave the
 * polygon. Where there is none, a text says why.
 */
export function linesInPolygon(corners: readonly PlanPlace[], spacing_m: number, bearing_deg?: number): Sweep | string {
  const [first] = corners;
  if (!first || corners.length < 3) return t("a polygon has three corners or more");
  const ground = groundAt(first);
  const shape = corners.map((corner) => ground.metres(corner));
  const bearing = within360(bearing_deg ?? bestBearing(shape));
  const chains = chainsOf(shape.map((point) => turnedBack(point, bearing)), spacing_m);
  if (typeof chains === "string") return chains;
  const way = joined(chains);
  if (way.length > MOST_POINTS) return tooMany();
  return { points: way.map(([along, right]) => ground.place(turned(along, right, bearing))), bearing_deg: bearing, lines: way.length / 2 };
}

function tooMany(): string {
  return t("more lines than a path can have ({most}): choose a wider spacing", { most: MOST_POINTS / 2 });
}

/** The direction across which a shape is narrowest: that of one of its hull's edges. */
function bestBearing(shape: readonly Metres[]): number {
  let [best, narrowest] = [0, Infinity];
  for (const one of shape) {
    for (const other of shape) {
      const way: Metres = [other[0] - one[0], other[1] - one[1]];
      if (Math.hypot(...way) < LEAST_M) continue;
      const bearing = bearingTo(way);
      const across = shape.map((point) => turnedBack(point, bearing)[1]);
      const width = Math.max(...across) - Math.min(...across);
      if (width < narrowest - 1e-6) [best, narrowest] = [bearing, width];
    }
  }
  return best % 180;
}

/** Pieces of lines that lie beside each other, so that they are swept to and fro without leaving the polygon much. */
function chainsOf(shape: readonly Metres[], spacing_m: number): Piece[][] | string {
  const across = shape.map(([, right]) => right);
  const [least, width] = [Math.min(...across), Math.max(...across) - Math.min(...across)];
  if (!(spacing_m > 0) || width < LEAST_M) return t("it is too narrow");
  const count = Math.max(1, Math.ceil(width / spacing_m - SLACK));
  if (count > MOST_POINTS / 2) return tooMany();
  const begin = least + (width - (count - 1) * spacing_m) / 2;
  const chains: Piece[][] = [];
  let before: Piece[] = [];
  for (let line = 0; line < count; line++) {
    const pieces = piecesAt(shape, begin + line * spacing_m);
    for (const piece of pieces) {
      const above = before.filter((one) => beside(one, piece));
      // It goes on with the one before it, if that is not shared with another.
      const only = above.length === 1 && above[0] && pieces.filter((one) => beside(above[0]!, one)).length === 1 ? above[0] : undefined;
      const chain = only && chains.find((one) => one.at(-1) === only);
      if (chain) chain.push(piece);
      else chains.push([piece]);
    }
    before = pieces;
  }
  return chains.length ? chains : t("it is too narrow");
}

function beside(one: Piece, other: Piece): boolean {
  return one.from < other.to && other.from < one.to;
}

/** The pieces of a line that lie inside. */
function piecesAt(shape: readonly Metres[], right: number): Piece[] {
  const cuts: number[] = [];
  shape.forEach(([along, across], at) => {
    const [nextAlong, nextAcross] = shape[(at + 1) % shape.length] ?? [along, across];
    if (across <= right === nextAcross <= right) return;
    cuts.push(along + ((right - across) / (nextAcross - across)) * (nextAlong - along));
  });
  cuts.sort((one, other) => one - other);
  const pieces: Piece[] = [];
  for (let at = 0; at + 1 < cuts.length; at += 2) {
    const [from = 0, to = 0] = [cuts[at], cuts[at + 1]];
    if (to - from >= LEAST_M) pieces.push({ right, from, to });
  }
  return pieces;
}

/** All chains one after the other: always the one that begins nearest, from the end that is nearest; first near the origin. */
function joined(chains: readonly Piece[][]): Metres[] {
  const left = [...chains];
  const way: Metres[] = [];
  while (left.length) {
    const [along, right] = way.at(-1) ?? [0, 0];
    let best: { chain: Piece[]; swept: Metres[]; away: number } | undefined;
    for (const chain of left) {
      for (const ordered of [chain, [...chain].reverse()]) {
        for (const up of [true, false]) {
          const swept = toAndFro(ordered, up);
          const away = swept[0] ? Math.hypot(swept[0][0] - along, swept[0][1] - right) : Infinity;
          if (!best || away < best.away) best = { chain, swept, away };
        }
      }
    }
    if (!best) break;
    way.push(...best.swept);
    left.splice(left.indexOf(best.chain), 1);
  }
  return way;
}

function toAndFro(chain: readonly Piece[], up: boolean): Metres[] {
  return chain.flatMap(({ right, from, to }, at): Metres[] => ((at % 2 === 0) === up ? [[from, right], [to, right]] : [[to, right], [from, right]]));
}
