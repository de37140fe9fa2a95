// What the explorer asks for, as it stands in the page's address, and the numbers of its plots. Pure.

import type { DetectionsSummary, PlanPlace } from "../api/types.gen";
import { count, t } from "../words/words";
import { pickedUs, spanWrong } from "./takeout";

/** A question, each part as it stands in its input; empty for all. */
export interface Asked {
  /** Of a date picker, UTC. */
  readonly from: string;
  readonly to: string;
  /** Addresses, with commas between them. */
  readonly vessel: string;
  readonly tag: string;
  /** Names; from an address also a text of several with `;` between them. */
  readonly project: readonly string[];
  /** Corners as `lat,lon;lat,lon`. */
  readonly area: string;
  /** `whole` where plots reach to times by wrong clocks too. */
  readonly axis: string;
}

const PARTS = ["from", "to", "vessel", "tag", "area", "axis"] as const;

export function askedOf(search: string): Asked {
  const query = new URLSearchParams(search);
  const part = (name: string): string => query.get(name) ?? "";
  return { from: part("from"), to: part("to"), vessel: part("vessel"), tag: part("tag"), project: query.getAll("project").filter(Boolean), area: part("area"), axis: part("axis") };
}

/** What stands behind the `?` of the page's address. */
export function searchOf(asked: Asked): string {
  const query = new URLSearchParams();
  for (const name of PARTS) if (asked[name]) query.set(name, asked[name]);
  for (const name of asked.project) query.append("project", name);
  return query.toString();
}

/** Which detections, as the server is asked. */
export function apiOf({ from, to, vessel, tag, project, area }: Asked): string {
  const query = new URLSearchParams();
  if (from) query.set("from_us", String(pickedUs(from)));
  if (to) query.set("to_us", String(pickedUs(to)));
  const tags = tag.split(/[\s,]+/).filter(Boolean).join(",");
  for (const [name, value] of [["vessel", vessel], ["tag", tags], ["area", area]] as const) if (value) query.set(name, value);
  for (const name of project) query.append("project", name);
  return query.toString();
}

/** The projects that an address means, as the server reads it: a text that is no name of one is several with `;` between them. */
export function projectsOf(asked: readonly string[], known: readonly string[]): readonly string[] {
  const folded = new Set(known.map((name) => name.toLowerCase()));
  return asked.flatMap((text) => (folded.has(text.trim().toLowerCase()) ? [text] : text.split(";").map((name) => name.trim()).filter(Boolean)));
}

/** Which numbers of them. */
export function summaryOf(asked: Asked): string {
  return [apiOf(asked), asked.axis === "whole" ? "whole_axis=true" : ""].filter(Boolean).join("&");
}

/** What is wrong with it, before anything is asked. */
export function askedWrong({ from, to }: Asked): string {
  return spanWrong(from, to)?.text ?? "";
}

export function cornersOfText(area: string): readonly PlanPlace[] {
  const corners = area.split(";").filter(Boolean).map((corner) => corner.split(",").map(Number));
  return corners.flatMap(([lat_deg, lon_deg]) => (Number.isFinite(lat_deg) && Number.isFinite(lon_deg) ? [{ lat_deg: lat_deg ?? 0, lon_deg: lon_deg ?? 0 }] : []));
}

export function textOfCorners(corners: readonly PlanPlace[]): string {
  return corners.map(({ lat_deg, lon_deg }) => `${lat_deg.toFixed(6)},${lon_deg.toFixed(6)}`).join(";");
}

/** Longitudes side by side, as places lie on the chart: east of the widest stretch without any, so that those on both sides of the
 * 180th meridian lie together, some of them beyond 180. */
export function sideBySide(lons: readonly number[]): readonly number[] {
  const sorted = [...lons].sort((one, other) => one - other);
  const [first = 0, last = 0] = [sorted[0], sorted.at(-1)];
  let [west, widest] = [first, first + 360 - last];
  sorted.forEach((lon, at) => {
    const gap = lon - (sorted[at - 1] ?? lon);
    if (gap > widest) [west, widest] = [lon, gap];
  });
  return lons.map((lon) => (lon < west ? lon + 360 : lon));
}

/** From when on it is counted, where not all of it is, µs. */
export function countedFrom({ left_out_before_us, read_from_us }: DetectionsSummary): number | undefined {
  const all = [left_out_before_us, read_from_us].filter((us) => us !== null);
  return all.length ? Math.max(...all) : undefined;
}

/** From when on it is known which detections nothing confirms, where that is not known of all, µs. */
export function confirmedFrom({ confirmed_from_us }: DetectionsSummary): number | undefined {
  return confirmed_from_us ?? undefined;
}

/** Where the grid of the bars begins, µs. It is not where the plots begin, for weeks begin on Monday. */
export function barsBegin({ bars, from_us }: Pick<DetectionsSummary, "bars" | "from_us">): number {
  return bars[0]?.from_us ?? from_us ?? 0;
}

/** A stretch of time that somebody draws over a plot between two moments, in whole steps of that plot, µs. */
export function brushed(one: number, other: number, begin: number, step: number): { readonly from: number; readonly to: number } {
  const at = (us: number, whole: (n: number) => number): number => begin + whole((us - begin) / step) * step;
  const from = at(Math.min(one, other), Math.floor);
  return { from, to: Math.max(from + step, at(Math.max(one, other), Math.ceil)) };
}

/** How long receivers listened, roughly, as people say it. */
export function hoursText(s: number): string {
  if (s < 60) return t("{n} s", { n: Math.round(s) });
  return s < 3_600 ? t("{n} min", { n: Math.round(s / 60) }) : t("{n} h", { n: count(Math.round(s / 3_600)) });
}

/** How long a bar or a step is, as people say it. */
export function lengthText(us: number): string {
  const s = us / 1e6;
  if (s < 60) return t("{n} s", { n: s });
  if (s < 3_600) return t("{n} min", { n: s / 60 });
  return s < 86_400 ? t("{n} h", { n: s / 3_600 }) : t("{n} d", { n: s / 86_400 });
}

/** What the bars of a length are called. */
export function barsTitle(us: number): string {
  if (us === HOUR_US) return t("Detections per hour");
  if (us === DAY_US) return t("Detections per day");
  return us === 7 * DAY_US ? t("Detections per week") : t("Detections by time, {length} a bar", { length: lengthText(us) });
}

const [HOUR_US, DAY_US] = [3_600_000_000, 86_400_000_000];
/** 1970-01-05, a Monday. */
const MONDAY_US = 4 * DAY_US;
/** Lengths between marks of an axis, µs, up to two weeks; then months, then years. */
const TICKS_US = [1, 5, 15, 30, 60, 300, 900, 1_800, 3_600, 7_200, 10_800, 21_600, 43_200].map((s) => s * 1e6).concat([DAY_US, 2 * DAY_US, 7 * DAY_US, 14 * DAY_US]);
const TICK_MONTHS = [1, 2, 3, 6, 12, 24, 60, 120, 240, 600, 1_200];
const MONTH_US = 30.4 * DAY_US;

/** A mark of an axis. */
export interface Tick {
  readonly us: number;
  readonly text: string;
}

/** At most so many marks within a time, at whole hours, days, Mondays, months or years, UTC. */
export function ticks(from: number, to: number, most: number): readonly Tick[] {
  const span = Math.max(1, to - from);
  const length = TICKS_US.find((us) => span / us < most);
  if (length !== undefined) return evenTicks(from, to, length);
  const months = TICK_MONTHS.find((n) => span / (n * MONTH_US) < most) ?? 12 * Math.ceil(span / (most * 12 * MONTH_US));
  const first = new Date(from / 1_000);
  const all: Tick[] = [];
  for (let at = Math.floor((first.getUTCFullYear() * 12 + first.getUTCMonth()) / months) * months; ; at += months) {
    const us = Date.UTC(Math.floor(at / 12), at % 12) * 1_000;
    if (us > to) return all;
    if (us >= from) all.push({ us, text: dateText(us, months % 12 === 0 ? { year: "numeric" } : { month: "short", year: "numeric" }) });
  }
}

function evenTicks(from: number, to: number, length: number): readonly Tick[] {
  const begin = length % (7 * DAY_US) === 0 ? MONDAY_US : 0;
  const all: Tick[] = [];
  for (let us = Math.ceil((from - begin) / length) * length + begin; us <= to; us += length) {
    const clock = new Date(us / 1_000).toISOString().slice(11, length < 60e6 ? 19 : 16);
    all.push({ us, text: us % DAY_US === 0 ? dateText(us, { day: "numeric", month: "short" }) : clock });
  }
  return all;
}

function dateText(us: number, parts: Intl.DateTimeFormatOptions): string {
  return new Intl.DateTimeFormat(globalThis.lutraWords ? "nb" : "en-GB", { ...parts, timeZone: "UTC" }).format(us / 1_000);
}

/** What a file of a plot's numbers has. */
export interface Numbers {
  readonly head: readonly string[];
  readonly rows: readonly (readonly (string | number | null)[])[];
}

const iso = (us: number): string => new Date(us / 1_000).toISOString();

/** How many nothing confirms; empty where that is not known. */
function unconfirmedOf(found: DetectionsSummary, from: number, unconfirmed: number): number | null {
  return from < (confirmedFrom(found) ?? -Infinity) ? null : unconfirmed;
}

export function abacusNumbers(found: DetectionsSummary): Numbers {
  const { tags, from_us, step_us } = found;
  const rows = tags.flatMap(({ tag, name, animal, project, marks }) => marks.map(([at, heard, unconfirmed]) => {
    const from = (from_us ?? 0) + at * step_us;
    return [tag, name, animal, project, iso(from), step_us / 1e6, heard, unconfirmedOf(found, from, unconfirmed)] as const;
  }));
  return { head: ["tag", "tag_name", "animal", "project", "from_utc", "length_s", "detections", "unconfirmed"], rows };
}

export function barNumbers(found: DetectionsSummary): Numbers {
  const rows = found.bars.map(({ from_us, detections, unconfirmed, listened_s }) => [iso(from_us), found.bar_us / 1e6, detections, unconfirmedOf(found, from_us, unconfirmed), listened_s] as const);
  return { head: ["from_utc", "length_s", "detections", "unconfirmed", "listened_s"], rows };
}

export function squareNumbers({ squares, square_m }: DetectionsSummary): Numbers {
  return { head: ["lat_deg", "lon_deg", "side_m", "detections"], rows: squares.map(({ lat_deg, lon_deg, detections }) => [Number(lat_deg.toFixed(7)), Number(lon_deg.toFixed(7)), Number(square_m.toFixed(1)), detections]) };
}
