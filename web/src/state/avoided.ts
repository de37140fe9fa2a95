// Areas that routes avoid, and areas with a speed limit, as they are kept in this browser beside the draft of a plan.

import type { PlanPlace, SeaRouteZone } from "../api/types.gen";
import { t } from "../words/words";
import { MOST_CORNERS } from "./corners";

export type Area = readonly PlanPlace[];

/** An area in which a vessel is no faster than a limit, m/s. */
export interface SlowArea {
  readonly corners: Area;
  readonly most_mps: number;
}

/** As many as the server takes: areas, corners of one, corners of all. */
export const MOST_AREAS = 50;
const ALL_CORNERS = 1_000;

/** Speed limits that the server takes, m/s. */
const SLOWEST_MPS = 0.05;
const FASTEST_MPS = 20;

const KEY = "lutra.avoid.";
const SLOW_KEY = "lutra.slow.";

export function keptAreas(store: Pick<Storage, "getItem">, plan: string): Area[] {
  return kept(store, KEY + plan, isArea);
}

export function keepAreas(store: Pick<Storage, "setItem" | "removeItem">, plan: string, areas: readonly Area[]): void {
  keep(store, KEY + plan, areas);
}

export function keptSlow(store: Pick<Storage, "getItem">, plan: string): SlowArea[] {
  return kept(store, SLOW_KEY + plan, isSlow);
}

export function keepSlow(store: Pick<Storage, "setItem" | "removeItem">, plan: string, areas: readonly SlowArea[]): void {
  keep(store, SLOW_KEY + plan, areas);
}

function kept<T>(store: Pick<Storage, "getItem">, key: string, isOne: (value: unknown) => value is T): T[] {
  try {
    const all: unknown = JSON.parse(store.getItem(key) ?? "[]");
    return Array.isArray(all) ? all.filter(isOne).slice(0, MOST_AREAS) : [];
  } catch {
    return [];
  }
}

/** A browser that keeps nothing, or has no room, has them for as long as the page is open. */
function keep(store: Pick<Storage, "setItem" | "removeItem">, key: string, areas: readonly unknown[]): void {
  try {
    if (areas.length) store.setItem(key, JSON.stringify(areas));
    else store.removeItem(key);
  } catch {
    // The areas on the map are those that count.
  }
}

/** What is wrong with a speed limit as it was typed; empty for a good one. */
export function limitWrong(text: string): string {
  return isLimit(text.trim() === "" ? Number.NaN : Number(text)) ? "" : t("Give a speed of {least} to {most} m/s.", { least: SLOWEST_MPS, most: FASTEST_MPS });
}

/** Whether a corner may be added to an area that is drawn beside others. */
export function hasRoom(areas: readonly Area[], drawing: Area): boolean {
  const all = areas.reduce((sum, one) => sum + one.length, drawing.length);
  return areas.length < MOST_AREAS && drawing.length < MOST_CORNERS && all < ALL_CORNERS;
}

/** Whether two sides cross, so that nobody can tell what is inside. */
export function crosses(corners: Area): boolean {
  const sides = corners.map((from, at) => [from, corners[(at + 1) % corners.length] ?? from] as const);
  return sides.some((one, at) => sides.slice(at + 1).some((other) => cross(one, other)));
}

type Side = readonly [PlanPlace, PlanPlace];

function cross([a, b]: Side, [c, d]: Side): boolean {
  return turn(a, b, c) * turn(a, b, d) < 0 && turn(c, d, a) * turn(c, d, b) < 0;
}

/** Positive where the way over three places turns to port. */
function turn(a: PlanPlace, b: PlanPlace, c: PlanPlace): number {
  return (b.lon_deg - a.lon_deg) * (c.lat_deg - a.lat_deg) - (b.lat_deg - a.lat_deg) * (c.lon_deg - a.lon_deg);
}

export function zonesOf(areas: readonly Area[], slow: readonly SlowArea[]): SeaRouteZone[] {
  const zone = (kind: SeaRouteZone["kind"], corners: Area, most_mps: number | null): SeaRouteZone => ({ kind, corners: corners.map(({ lat_deg, lon_deg }) => [lat_deg, lon_deg]), most_mps });
  return [...areas.map((corners) => zone("avoid", corners, null)), ...slow.map(({ corners, most_mps }) => zone("limit", corners, most_mps))];
}

function isLimit(mps: unknown): mps is number {
  return typeof mps === "number" && mps >= SLOWEST_MPS && mps <= FASTEST_MPS;
}

function isSlow(value: unknown): value is SlowArea {
  const { corners, most_mps } = (value ?? {}) as Partial<SlowArea>;
  return isArea(corners) && isLimit(most_mps);
}

function isArea(value: unknown): value is Area {
  return Array.isArray(value) && value.length >= 3 && value.length <= MOST_CORNERS && value.every(isPlace);
}

function isPlace(value: unknown): value is PlanPlace {
  const { lat_deg, lon_deg } = (value ?? {}) as Partial<PlanPlace>;
  return typeof lat_deg === "number" && typeof lon_deg === "number" && Math.abs(lat_deg) <= 90 && Math.abs(lon_deg) <= 180;
}
