// Areas that routes avoid, as they are kept in this browser beside the draft of a plan.

import type { PlanPlace, SeaRouteZone } from "../api/types.gen";

export type Area = readonly PlanPlace[];

/** As many as the server takes. */
export const MOST_AREAS = 50;
export const MOST_CORNERS = 200;

const KEY = "lutra.avoid.";

export function keptAreas(store: Pick<Storage, "getItem">, plan: string): Area[] {
  try {
    const kept: unknown = JSON.parse(store.getItem(KEY + plan) ?? "[]");
    return Array.isArray(kept) ? kept.filter(isArea).slice(0, MOST_AREAS) : [];
  } catch {
    return [];
  }
}

export function keepAreas(store: Pick<Storage, "setItem" | "removeItem">, plan: string, areas: readonly Area[]): void {
  if (areas.length) store.setItem(KEY + plan, JSON.stringify(areas));
  else store.removeItem(KEY + plan);
}

export function zonesOf(areas: readonly Area[]): SeaRouteZone[] {
  return areas.map((corners) => ({ kind: "avoid", corners: corners.map(({ lat_deg, lon_deg }) => [lat_deg, lon_deg]) }));
}

function isArea(value: unknown): value is Area {
  return Array.isArray(value) && value.length >= 3 && value.length <= MOST_CORNERS && value.every(isPlace);
}

function isPlace(value: unknown): value is PlanPlace {
  const { lat_deg, lon_deg } = (value ?? {}) as Partial<PlanPlace>;
  return typeof lat_deg === "number" && typeof lon_deg === "number" && Math.abs(lat_deg) <= 90 && Math.abs(lon_deg) <= 180;
}
