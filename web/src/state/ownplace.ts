// What is known of the place of the person at this device, in words. Pure.

import { bearing, distance } from "../ui/format";
import { t } from "../words/words";
import { legTo } from "./control";

export interface OwnPlace {
  readonly lat_deg: number;
  readonly lon_deg: number;
  /** With 95 % it is within this, m. */
  readonly accuracy_m: number;
  /** When it was so, by this device's clock, ms since 1970 UTC. */
  readonly atMs: number;
}

/** A place older than this says how old it is, s. */
const OLD_S = 10;

/** The place against a vessel, its accuracy, and its age where it is old. */
export function ownPlaceText(own: OwnPlace | undefined, vessel: { name: string; lat_deg: number; lon_deg: number } | undefined, nowMs: number): string {
  if (!own) return t("Waiting for this device's position …");
  const ageS = Math.max(0, (nowMs - own.atMs) / 1_000);
  const old = ageS > OLD_S ? `, ${t("{age} s old", { age: ageS.toFixed(0) })}` : "";
  const known = `${t("You ±{accuracy} m", { accuracy: own.accuracy_m.toFixed(0) })}${old}`;
  if (!vessel) return known;
  const { distance_m, bearing_rad } = legTo(own, [vessel.lat_deg, vessel.lon_deg]);
  return `${known} · ${vessel.name} ${distance(distance_m)}, ${bearing(bearing_rad)}`;
}
