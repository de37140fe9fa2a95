// No-go areas: what somebody types and draws, as the server takes it. Pure.

import type { NoGoArea, NoGoAreaRequest, PlanPlace } from "../api/types.gen";
import { t } from "../words/words";
import { crosses } from "./avoided";
import type { Wrong } from "./notes";

/** Corners of one area. */
export const MOST_CORNERS = 200;

/** An area as it stands in its form and on the map. */
export interface AreaDraft {
  readonly name: string;
  readonly reason: string;
}

export const EMPTY_AREA: AreaDraft = { name: "", reason: "" };

export function areaWrong({ name }: AreaDraft, corners: readonly PlanPlace[]): Wrong | undefined {
  if (corners.length < 3) return { field: "corners", text: t("An area has three corners or more: click them on the map.") };
  if (crosses(corners)) return { field: "corners", text: t("Two sides of the area cross: remove corners and draw it without.") };
  if (!name.trim()) return { field: "name", text: t("Give it a name.") };
  return undefined;
}

/** A draft without anything wrong, as the server takes it. */
export function areaAsk({ name, reason }: AreaDraft, corners: readonly PlanPlace[]): NoGoAreaRequest {
  return { name: name.trim(), reason: reason.trim(), corners: corners.map(({ lat_deg, lon_deg }) => [lat_deg, lon_deg]) };
}

export function cornersOf({ area }: Pick<NoGoArea, "area">): PlanPlace[] {
  return area.corners.map(([lat_deg, lon_deg]) => ({ lat_deg, lon_deg }));
}
