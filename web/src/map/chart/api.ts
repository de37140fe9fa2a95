// What the server tells about charts. Places are degrees, WGS 84; depths metres below chart datum, negative where it dries.

import { getJson } from "../../api/http";

export interface ChartCell {
  readonly name: string;
  readonly edition: string;
  readonly update: string;
  readonly scale: number;
  readonly band: number;
  readonly issued: string;
  readonly comment: string;
}

export interface ChartSet {
  readonly set: string | null;
  readonly trouble: string | null;
  readonly cells: readonly ChartCell[];
  readonly bounds: { readonly south_deg: number; readonly west_deg: number; readonly north_deg: number; readonly east_deg: number } | null;
  readonly not_for_navigation: boolean;
  readonly navigable_m: number;
  readonly autonomous_m: number;
}

export interface ChartDepth {
  readonly kind: string;
  readonly least_m: number | null;
  readonly greatest_m: number | null;
  readonly margin_m: number | null;
  readonly autonomous: boolean;
  readonly navigable: boolean;
  readonly class: string | null;
  readonly words: string | null;
  readonly name: string | null;
  readonly cell: string | null;
  readonly edition: string | null;
  readonly update: string | null;
  readonly scale: number | null;
  readonly zone: number | null;
}

export interface ChartObject {
  readonly id: number;
  readonly class: string;
  readonly words: string;
  readonly name: string | null;
  readonly distance_m: number;
  readonly depth_m: number | null;
  readonly attributes: readonly { readonly name: string; readonly words: string; readonly value: string; readonly text: string }[];
  readonly cell: string;
  readonly edition: string;
  readonly update: string;
  readonly scale: number;
}

export interface ChartNear {
  readonly depth: ChartDepth;
  readonly objects: readonly ChartObject[];
}

/** What is charted at a place, and objects within so many metres. */
export async function chartAt(lat_deg: number, lon_deg: number, within_m: number, signal?: AbortSignal): Promise<ChartNear> {
  return getJson<ChartNear>(`/api/v1/chart/at?lat_deg=${lat_deg.toFixed(7)}&lon_deg=${lon_deg.toFixed(7)}&within_m=${within_m.toFixed(1)}`, signal);
}

const ZONES = ["", "A1", "A2", "B", "C", "D", "unassessed"];

/** A zone of confidence as charts write it. */
export function zoneText(zone: number | null): string {
  return zone === null ? "not told" : (ZONES[zone] ?? String(zone));
}

/** How deep it is, in words. */
export function depthWords(depth: ChartDepth): string {
  const metres = (value: number): string => (value < 0 ? `dries ${(-value).toFixed(1)} m` : `${value.toFixed(1)} m`);
  const { least_m: least, greatest_m: most } = depth;
  switch (depth.kind) {
    case "land":
      return "Land";
    case "no-data":
      return "No chart here";
    case "obstacle":
      return `Obstacle${depth.words ? `: ${depth.words}` : ""}`;
    case "unknown-depth":
      return "Depth unknown";
    case "too-low":
      return "Too low overhead";
    default:
      if (least === null) return "Depth unknown";
      return most !== null && most > least ? `Depth ${metres(least)} to ${metres(most)}` : `Depth ${metres(least)}`;
  }
}

export interface ChartProfilePoint {
  readonly along_m: number;
  readonly depth_m: number | null;
  readonly kind: string;
}

export interface ChartCorridor {
  readonly length_m: number;
  readonly profile: readonly ChartProfilePoint[];
}

export interface GuardReason {
  readonly maneuver: string;
  readonly part: string;
  readonly code: string;
  readonly text: string;
  readonly lat_deg: number;
  readonly lon_deg: number;
  readonly depth_m: number | null;
}

export interface Guard {
  readonly outcome: string;
  readonly text: string;
  readonly reasons: readonly GuardReason[];
  readonly warnings: readonly { readonly maneuver: string | null; readonly code: string; readonly text: string }[];
}
