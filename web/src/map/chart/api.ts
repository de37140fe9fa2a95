// What the server tells about charts. Places are degrees, WGS 84; depths metres below chart datum, negative where it dries.

import { getJson } from "../../api/http";
import type { ChartDepth, ChartNear } from "../../api/types.gen";
import { t } from "../../words/words";

/** What is charted at a place, and objects within so many metres; judged by the limits of a vessel, where one is given. */
export async function chartAt(lat_deg: number, lon_deg: number, within_m: number, vessel: number | undefined, signal?: AbortSignal): Promise<ChartNear> {
  const by = vessel === undefined ? "" : `&vessel=${vessel}`;
  return getJson<ChartNear>(`/api/v1/chart/at?lat_deg=${lat_deg.toFixed(7)}&lon_deg=${lon_deg.toFixed(7)}&within_m=${within_m.toFixed(1)}${by}`, signal);
}

const ZONES = ["", "A1", "A2", "B", "C", "D", t("unassessed")];

/** A zone of confidence as charts write it. */
export function zoneText(zone: number | null): string {
  return zone === null ? t("not reported") : (ZONES[zone] ?? String(zone));
}

/** How deep it is, in words. */
export function depthWords(depth: ChartDepth): string {
  const metres = (value: number): string => (value < 0 ? t("dries {value} m", { value: (-value).toFixed(1) }) : `${value.toFixed(1)} m`);
  const { least_m: least, greatest_m: most } = depth;
  switch (depth.kind) {
    case "land":
      return t("Land");
    case "no-data":
      return t("No chart here");
    case "obstacle":
      return depth.words ? t("Obstacle: {what}", { what: depth.words }) : t("Obstacle");
    case "unknown-depth":
      return t("Depth unknown");
    case "too-low":
      return t("Too low overhead");
    default:
      if (least === null) return t("Depth unknown");
      return most !== null && most > least ? t("Depth {least} to {most}", { least: metres(least), most: metres(most) }) : t("Depth {least}", { least: metres(least) });
  }
}
