// What the server tells about charts. Places are degrees, WGS 84; depths metres below chart datum, negative where it dries.

import { getJson } from "../../api/http";
import type { ChartDepth, ChartNear } from "../../api/types.gen";

/** What is charted at a place, and objects within so many metres; judged by the limits of a vessel, where one is given. */
export async function chartAt(lat_deg: number, lon_deg: number, within_m: number, vessel: number | undefined, signal?: AbortSignal): Promise<ChartNear> {
  const by = vessel === undefined ? "" : `&vessel=${vessel}`;
  return getJson<ChartNear>(`/api/v1/chart/at?lat_deg=${lat_deg.toFixed(7)}&lon_deg=${lon_deg.toFixed(7)}&within_m=${within_m.toFixed(1)}${by}`, signal);
}

const ZONES = ["", "A1", "A2", "B", "C", "D", "unassessed"];

/** A zone of confidence as charts write it. */
export function zoneText(zone: number | null): string {
  return zone === null ? "not reported" : (ZONES[zone] ?? String(zone));
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
