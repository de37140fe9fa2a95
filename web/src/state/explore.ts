// What the explorer asks for, as it stands in the page's address, and the numbers of its plots. Pure.

import type { DetectionFlag, DetectionsSummary, FlagCode, PlanPlace } from "../api/types.gen";
import { t } from "../words/words";
import { pickedUs } from "./takeout";

/** A question, each part as it stands in its input; empty for all. */
export interface Asked {
  /** Of a date picker, UTC. */
  readonly from: string;
  readonly to: string;
  /** Address. */
  readonly vessel: string;
  readonly tag: string;
  readonly project: string;
  /** Corners as `lat,lon;lat,lon`. */
  readonly area: string;
}

const PARTS = ["from", "to", "vessel", "tag", "project", "area"] as const;

export function askedOf(search: string): Asked {
  const query = new URLSearchParams(search);
  const part = (name: string): string => query.get(name) ?? "";
  return { from: part("from"), to: part("to"), vessel: part("vessel"), tag: part("tag"), project: part("project"), area: part("area") };
}

/** What stands behind the `?` of the page's address. */
export function searchOf(asked: Asked): string {
  const query = new URLSearchParams();
  for (const name of PARTS) if (asked[name]) query.set(name, asked[name]);
  return query.toString();
}

/** The question to the server. */
export function apiOf({ from, to, vessel, tag, project, area }: Asked): string {
  const query = new URLSearchParams();
  if (from) query.set("from_us", String(pickedUs(from)));
  if (to) query.set("to_us", String(pickedUs(to)));
  const tags = tag.split(/[\s,]+/).filter(Boolean).join(",");
  for (const [name, value] of [["vessel", vessel], ["tag", tags], ["project", project], ["area", area]] as const) if (value) query.set(name, value);
  return query.toString();
}

/** What is wrong with it, before anything is asked. */
export function askedWrong({ from, to }: Asked): string {
  if ((from && !Number.isFinite(pickedUs(from))) || (to && !Number.isFinite(pickedUs(to)))) return t("Not a valid time.");
  return from && to && pickedUs(to) <= pickedUs(from) ? t("The end is not after the beginning.") : "";
}

export function cornersOfText(area: string): readonly PlanPlace[] {
  const corners = area.split(";").filter(Boolean).map((corner) => corner.split(",").map(Number));
  return corners.flatMap(([lat_deg, lon_deg]) => (Number.isFinite(lat_deg) && Number.isFinite(lon_deg) ? [{ lat_deg: lat_deg ?? 0, lon_deg: lon_deg ?? 0 }] : []));
}

export function textOfCorners(corners: readonly PlanPlace[]): string {
  return corners.map(({ lat_deg, lon_deg }) => `${lat_deg.toFixed(6)},${lon_deg.toFixed(6)}`).join(";");
}

/** What a flag is called. */
export function flagWord(code: FlagCode): string {
  switch (code) {
    case "unconfirmed": return t("unconfirmed");
    case "clock_not_set": return t("clock not set");
    case "clock_lost": return t("clock lost");
    case "clock_off": return t("clock off");
    case "no_place": return t("no place");
    case "old_place": return t("old place");
    case "lines_lost": return t("lines lost before");
  }
}

/** Why a detection has it. */
export function flagReason({ code, figure }: DetectionFlag): string {
  const n = Math.round(figure ?? 0);
  switch (code) {
    case "unconfirmed": return t("No other detection of this tag by this receiver within {n} s, 30 ping intervals: perhaps a false one.", { n });
    case "clock_not_set": return t("The receiver's clock was never set: the time is the vessel's.");
    case "clock_lost": return t("The receiver's clock was lost: the time is the vessel's.");
    case "clock_off": return t("The receiver's clock is {n} s off the vessel's.", { n });
    case "no_place": return t("The vessel did not know where it was.");
    case "old_place": return t("The nearest measured position is {n} s away.", { n });
    case "lines_lost": return t("{n} lines of the receiver were lost right before.", { n });
  }
}

/** How long a bar or a step is, as people say it. */
export function lengthText(us: number): string {
  const s = us / 1e6;
  if (s < 60) return t("{n} s", { n: s });
  if (s < 3_600) return t("{n} min", { n: s / 60 });
  return s < 86_400 ? t("{n} h", { n: s / 3_600 }) : t("{n} d", { n: s / 86_400 });
}

/** What a file of a plot's numbers has. */
export interface Numbers {
  readonly head: readonly string[];
  readonly rows: readonly (readonly (string | number | null)[])[];
}

const iso = (us: number): string => new Date(us / 1_000).toISOString();

export function abacusNumbers({ tags, from_us, step_us }: DetectionsSummary): Numbers {
  const rows = tags.flatMap(({ tag, name, animal, project, marks }) => marks.map(([at, count, unconfirmed]) => [tag, name, animal, project, iso((from_us ?? 0) + at * step_us), step_us / 1e6, count, unconfirmed] as const));
  return { head: ["tag", "tag_name", "animal", "project", "from_utc", "length_s", "detections", "unconfirmed"], rows };
}

export function barNumbers({ bars, bar_us }: DetectionsSummary): Numbers {
  return { head: ["from_utc", "length_s", "detections", "unconfirmed", "listened_s"], rows: bars.map((bar) => [iso(bar.from_us), bar_us / 1e6, bar.detections, bar.unconfirmed, bar.listened_s]) };
}

export function squareNumbers({ squares, square_m }: DetectionsSummary): Numbers {
  return { head: ["lat_deg", "lon_deg", "side_m", "detections"], rows: squares.map(({ lat_deg, lon_deg, detections }) => [Number(lat_deg.toFixed(7)), Number(lon_deg.toFixed(7)), Number(square_m.toFixed(1)), detections]) };
}
