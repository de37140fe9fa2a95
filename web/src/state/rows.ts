// Rows: how they are laid out, by the same steps as `crates/mission/src/maneuver/rows.rs`, and the rectangle that they sweep,
// made, turned, widened and sailed backwards. Pure.

import type { PlanPlace } from "../api/types.gen";
import { t } from "../words/words";
import { bearingTo, groundAt, type Metres, turned, turnedBack, within360 } from "./ground";
import type { Task } from "./plan";

type Rows = Task<"rows">;

/** Rows with more points than a plan may have are not laid out here. */
const MOST_POINTS = 5_000;
/** A drawn rectangle with a shorter side than this was no rectangle, m. */
export const LEAST_SIDE_M = 2;
const RAD = Math.PI / 180;

interface Layout {
  /** Metres along the bearing and to the right of it, from where the first row starts. */
  readonly points: readonly Metres[];
  /** How many rows there are, and where the last one begins: along and to the right. */
  readonly count: number;
  readonly last: Metres;
}

/** Undefined for what has no end. */
function layOut(rows: Rows): Layout | undefined {
  const { length_m, curve_offset_m: over } = rows;
  if (!(rows.width_m > 0 && length_m > 0 && rows.step_m > 0) || 3 * (rows.width_m / rows.step_m + 2) > MOST_POINTS) return undefined;
  const points: Metres[] = [[-over, 0], [0, 0]];
  let [base, across, sum, count]: [Metres, number, number, number] = [[0, 0], 0, 0, 1];
  for (let up = true; ; up = !up) {
    const turn = (base[0] + (up ? length_m + over : -over));
    points.push([turn, across]);
    const step = sideways(rows, up);
    sum += step.signed;
    if (Math.abs(sum) > rows.width_m * (1 + 1e-9)) return { points, count, last: base };
    across += step.right;
    base = [base[0] + step.along, across];
    points.push(...curve(rows, [turn + step.along, across], up ? -over : over));
    count++;
  }
}

/** The step from one row to the next, at the upper or at the lower end. */
function sideways({ step_m, alternation_percent, cross_angle_deg, curve_right }: Rows, up: boolean): { signed: number; along: number; right: number } {
  const share = up ? alternation_percent / 100 : 2 - alternation_percent / 100;
  const signed = (curve_right ? 1 : -1) * step_m * share;
  return { signed, along: -signed * Math.sin(cross_angle_deg * RAD), right: signed * Math.cos(cross_angle_deg * RAD) };
}

/** Squarely there and then back, or diagonally at once. */
function curve({ square_curve }: Rows, [along, right]: Metres, back: number): Metres[] {
  const end: Metres = [along + back, right];
  return square_curve ? [[along, right], end] : [end];
}

/** Where rows lead, with the way in; the start alone where they cannot be laid out. */
export function rowsWay(rows: Rows): PlanPlace[] {
  const ground = groundAt(rows.at);
  return layOut(rows)?.points.map(([along, right]) => ground.place(turned(along, right, rows.bearing_deg))) ?? [rows.at];
}

/** How many rows there are; 0 where they cannot be laid out. */
export function rowsCount(rows: Rows): number {
  return layOut(rows)?.count ?? 0;
}

/** The place so far along the first row, and so far across, from its start; slanted by the cross angle. */
function inRows(rows: Rows, along: number, across: number): PlanPlace {
  const side = (rows.curve_right ? 1 : -1) * across;
  const slanted = turned(along - side * Math.sin(rows.cross_angle_deg * RAD), side * Math.cos(rows.cross_angle_deg * RAD), rows.bearing_deg);
  return groundAt(rows.at).place(slanted);
}

/** The four corners of what rows sweep, from the start along the first row and round. */
export function rowsCorners(rows: Rows): PlanPlace[] {
  const { length_m, width_m } = rows;
  return [inRows(rows, 0, 0), inRows(rows, length_m, 0), inRows(rows, length_m, width_m), inRows(rows, 0, width_m)];
}

export function rowsCentre(rows: Rows): PlanPlace {
  return inRows(rows, rows.length_m / 2, rows.width_m / 2);
}

/** The middle of the side at which the first row ends. */
export function rowsHead(rows: Rows): PlanPlace {
  return inRows(rows, rows.length_m, rows.width_m / 2);
}

/** Turned around the middle of what they sweep. */
export function rowsTurned(rows: Rows, by_deg: number): Rows {
  const ground = groundAt(rowsCentre(rows));
  const [north, east] = ground.metres(rows.at);
  return { ...rows, at: ground.place(turned(north, east, by_deg)), bearing_deg: within360(rows.bearing_deg + by_deg) };
}

/** By how much somebody who leads a hand from one place to another turns rows around their middle, °. */
export function turnBetween(rows: Rows, from: PlanPlace, to: PlanPlace): number {
  const ground = groundAt(rowsCentre(rows));
  return bearingTo(ground.metres(to)) - bearingTo(ground.metres(from));
}

/** With the corner that is farthest from the start somewhere else; the side may change. */
export function rowsTo(rows: Rows, corner: PlanPlace): Rows {
  const [along, right] = turnedBack(groundAt(rows.at).metres(corner), rows.bearing_deg);
  const side = right / Math.cos(rows.cross_angle_deg * RAD);
  const length = along + right * Math.tan(rows.cross_angle_deg * RAD);
  return { ...rows, length_m: rounded(Math.max(LEAST_SIDE_M, length)), width_m: rounded(Math.max(LEAST_SIDE_M, Math.abs(side))), curve_right: right >= 0 };
}

/**
 * Rows in a rectangle between two corners: they start at the first and run along its longer side, or along `bearing_deg` where
 * that is given. Undefined where it is too narrow to be meant.
 */
export function rowsBetween(from: PlanPlace, to: PlanPlace, like: Omit<Rows, "at" | "bearing_deg" | "length_m" | "width_m" | "curve_right">, bearing_deg?: number): Rows | undefined {
  const way = groundAt(from).metres(to);
  const longer = Math.abs(way[0]) >= Math.abs(way[1]) ? 0 : 90;
  let bearing = within360(bearing_deg ?? longer);
  // Away from the corner where they start.
  if (turnedBack(way, bearing)[0] < 0) bearing = within360(bearing + 180);
  const [along, right] = turnedBack(way, bearing);
  if (along < LEAST_SIDE_M || Math.abs(right) < LEAST_SIDE_M) return undefined;
  return { ...like, at: from, bearing_deg: bearing, length_m: rounded(along), width_m: rounded(Math.abs(right)), curve_right: right >= 0 };
}

/** Why rows cannot be sailed backwards along exactly the same lines; undefined where they can. */
export function whyNotBack(rows: Rows): string | undefined {
  const count = rowsCount(rows);
  if (count === 0) return t("these rows cannot be laid out");
  if (count > 1 && !rows.square_curve && rows.curve_offset_m > 0) return t("diagonal turns lie elsewhere on the way back");
  if (count > 1 && count % 2 === 1 && rows.alternation_percent !== 100) return t("an odd number of rows with uneven turns has no way back");
  return undefined;
}

/** The same lines from the other end; the same rows where that is not possible. */
export function rowsBack(rows: Rows): Rows {
  const layout = layOut(rows);
  if (!layout || whyNotBack(rows) !== undefined) return rows;
  const odd = layout.count % 2 === 1;
  const [along, right] = layout.last;
  const at = groundAt(rows.at).place(turned(along + (odd ? rows.length_m : 0), right, rows.bearing_deg));
  if (odd) return { ...rows, at, bearing_deg: within360(rows.bearing_deg + 180) };
  return { ...rows, at, curve_right: !rows.curve_right };
}

/** To a decimetre. */
function rounded(metres: number): number {
  return Math.round(metres * 10) / 10;
}
