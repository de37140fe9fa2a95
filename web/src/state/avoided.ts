// Areas that routes avoid, as they are kept in this browser beside the draft of a plan.

import type { PlanPlace, SeaRouteZone } from "../api/types.gen";
import { MOST_CORNERS } from "./corners";

export type Area = readonly PlanPlace[];

/** As many as the server takes: areas, corners of one, corners of all. */
export const MOST_AREAS = 50;
const ALL_CORNERS = 1_000;

const KEY = "lutra.avoid.";

export function keptAreas(store: Pick<Storage, "getItem">, plan: string): Area[] {
  try {
    const kept: unknown = JSON.parse(store.getItem(KEY + plan) ?? "[]");
    return Array.isArray(kept) ? kept.filter(isArea).slice(0, MOST_AREAS) : [];
  } catch {
    return [];
  }
}

/** A browser that keeps nothing, or has no room, has them for as long as the page is open. */
export function keepAreas(store: Pick<Storage, "setItem" | "removeItem">, plan: string, areas: readonly Area[]): void {
  try {
    if (areas.length) store.setItem(KEY + plan, JSON.stringify(areas));
    else store.removeItem(KEY + plan);
  } catch {
    // Said by nobody: the areas on the map are those that count.
  }
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

export function zonesOf(areas: readonly Area[]): SeaRouteZone[] {
  return areas.map((corners) => ({ kind: "avoid", corners: corners.map(({ lat_deg, lon_deg }) => [lat_deg, lon_deg]), most_mps: null }));
}

function isArea(value: unknown): value is Area {
  return Array.isArray(value) && value.length >= 3 && value.length <= MOST_CORNERS && value.every(isPlace);
}

function isPlace(value: unknown): value is PlanPlace {
  const { lat_deg, lon_deg } = (value ?? {}) as Partial<PlanPlace>;
  return typeof lat_deg === "number" && typeof lon_deg === "number" && Math.abs(lat_deg) <= 90 && Math.abs(lon_deg) <= 180;
}
