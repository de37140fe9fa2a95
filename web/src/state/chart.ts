// What a chart shows, decided without drawing: shades, soundings, scales, colours, and which leg a verdict is about.

import type { VesselParameters } from "../api/types.gen";
import { t } from "../words/words";
import { GUARD_ENTITY } from "./guard";

/** Depths below chart datum that part the shades, m. */
export interface DepthLimits {
  /** Less is for nobody. */
  readonly navigable_m: number;
  /** Less is not for a vessel by itself: the safety depth. */
  readonly autonomous_m: number;
}

/** Drying, very shallow, shallow to the safety depth, safe, deep, and never surveyed. */
export type Shade = "drying" | "very-shallow" | "shallow" | "safe" | "deep" | "unknown";

/** From here on the chart is at its calmest, m. */
const DEEP_M = 20;
/** The greatest safety depth that may be chosen, m. */
export const MOST_SAFETY_M = 200;
/** A pixel is this large, m (OGC). */
const PIXEL_M = 0.000_28;
/** A chart that is shown larger than this many times its own scale promises more than it holds. */
const OVERSCALE = 2;
/** Decimals of a sounding are told above this, m (INT 1). */
const DECIMALS_TO_M = 31;
const BELOW = "₀₁₂₃₄₅₆₇₈₉";
const UNDERLINE = "\u0332";

/** The shade of an area whose shallowest charted depth is `depth_m`. */
export function shadeOf(depth_m: number | undefined, limits: DepthLimits): Shade {
  if (depth_m === undefined) return "unknown";
  if (depth_m < 0) return "drying";
  if (depth_m < limits.navigable_m) return "very-shallow";
  if (depth_m < limits.autonomous_m) return "shallow";
  return depth_m < Math.max(DEEP_M, 2 * limits.autonomous_m) ? "safe" : "deep";
}

/** What a vessel's own guard goes by, as it told its parameters; undefined where it has not reported them. */
export function ownLimits({ entities }: VesselParameters): DepthLimits | undefined {
  const guard = entities.find(({ entity }) => entity === GUARD_ENTITY);
  const depth = (name: string): number => {
    const text = guard?.parameters.find((one) => one.name === name)?.value.trim();
    return text ? Number(text) : NaN;
  };
  const [navigable_m, autonomous_m] = [depth("Navigable Depth"), depth("Autonomous Depth")];
  return Number.isFinite(navigable_m) && Number.isFinite(autonomous_m) ? { navigable_m, autonomous_m } : undefined;
}

/** What both guards let through, the one ashore and the vessel's own. */
export function guarded(ashore: DepthLimits, own: DepthLimits | undefined): DepthLimits {
  return { navigable_m: Math.max(ashore.navigable_m, own?.navigable_m ?? 0), autonomous_m: Math.max(ashore.autonomous_m, own?.autonomous_m ?? 0) };
}

/** The limits that are drawn where somebody has chosen a safety depth: never less than what the guard goes by. */
export function drawnLimits(limits: DepthLimits, chosen: string | null): DepthLimits {
  const wanted = chosen?.trim() ? Number(chosen) : NaN;
  const safe = Number.isFinite(wanted) && wanted <= MOST_SAFETY_M ? Math.max(wanted, limits.autonomous_m) : limits.autonomous_m;
  return { navigable_m: limits.navigable_m, autonomous_m: safe };
}

/** The contour that stands for the safety depth: the shallowest charted one that is no shallower. */
export function safetyContour(charted_m: Iterable<number>, limits: DepthLimits): number | undefined {
  let found: number | undefined;
  for (const value of charted_m) if (value >= limits.autonomous_m && (found === undefined || value < found)) found = value;
  return found;
}

/**
 * Whether a danger is one in water that is otherwise safe, which alone has the magenta symbol (S-52, UDWHAZ): too shallow
 * for a vessel by itself or of unknown depth, in an area that is charted as deep enough.
 */
export function isIsolated(depth_m: number | undefined, watlev: number | undefined, around_m: number | undefined, limits: DepthLimits): boolean {
  const dangerous = depth_m === undefined ? watlev === 3 || watlev === undefined : depth_m <= limits.autonomous_m;
  return dangerous && around_m !== undefined && around_m >= limits.autonomous_m;
}

/** A sounding as charts write it: whole metres, decimals set low, what dries underlined. Cut, never rounded up to deeper. */
export function soundingText(depth_m: number): string {
  const tenths = Math.floor(Math.abs(depth_m) * 10 + 1e-6) * Math.sign(depth_m) || 0;
  const size = Math.abs(tenths);
  const whole = String(Math.floor(size / 10));
  const tenth = size % 10;
  const figures = tenths < 0 ? [...whole].map((one) => one + UNDERLINE).join("") : whole;
  return tenth && size < DECIMALS_TO_M * 10 ? figures + (BELOW[tenth] ?? "") : figures;
}

/** The scale of a picture, 1 : this. `resolution` is that of the Mercator projection, m/px. */
export function shownScale(resolution: number, lat_deg: number): number {
  return (resolution * Math.cos((lat_deg * Math.PI) / 180)) / PIXEL_M;
}

/** Whether a chart of this scale is shown much larger than it was made for. */
export function isOverscale(chart: number | undefined, shown: number): boolean {
  return chart !== undefined && chart > 0 && shown * OVERSCALE < chart;
}

/**
 * Whether an area gets the bars of S-52's OVERSC01: it is overscale, and the picture has a better chart elsewhere. A picture that
 * is overscale all over says so in words alone; `best` is not known before something is drawn.
 */
export function isBarred(area: number | undefined, best: number | undefined, shown: number): boolean {
  return best !== undefined && area !== undefined && area > best && isOverscale(area, shown);
}

/** Colours of buoys, beacons and lights in words, from the codes of S-57 or from words. */
export function colourWords(text: unknown): string[] {
  const codes = ["", "white", "black", "red", "green", "blue", "yellow", "grey", "brown", "amber", "violet", "orange", "magenta", "pink"];
  return String(text ?? "")
    .split(/[,;/ ]+/)
    .map((one) => codes[Number(one)] ?? one.toLowerCase())
    .filter((one) => codes.includes(one) && one !== "");
}

/** Number of a buoy's shape (S-57 BOYSHP) from that number or its words; 0 for another. */
export function buoyShape(text: unknown): number {
  const number = Number(text);
  if (Number.isInteger(number)) return number;
  const words = String(text ?? "").toLowerCase();
  return ["con", "can", "spher", "pillar", "spar", "barrel", "super", "ice"].findIndex((start) => words.startsWith(start)) + 1;
}

/** A depth with its unit, for people. */
export function depthText(depth_m: number | null | undefined): string {
  if (depth_m === null || depth_m === undefined) return t("depth unknown");
  return depth_m < 0 ? t("dries {depth} m", { depth: (-depth_m).toFixed(1) }) : `${depth_m.toFixed(1)} m`;
}

type Place = { readonly lat_deg: number; readonly lon_deg: number };

/** Number of the stretch of a line that is nearest to a place; undefined for a line of fewer than two places. */
export function nearestStretch(line: readonly Place[], place: Place): number | undefined {
  const east = Math.cos((place.lat_deg * Math.PI) / 180);
  const flat = line.map((one) => [(one.lon_deg - place.lon_deg) * east, one.lat_deg - place.lat_deg] as const);
  let found: number | undefined;
  let best = Infinity;
  for (let at = 0; at + 1 < flat.length; at++) {
    const [[x0, y0], [x1, y1]] = [flat[at]!, flat[at + 1]!];
    const [dx, dy] = [x1 - x0, y1 - y0];
    const size = dx * dx + dy * dy;
    const part = size > 0 ? Math.max(0, Math.min(1, -(x0 * dx + y0 * dy) / size)) : 0;
    const away = (x0 + part * dx) ** 2 + (y0 + part * dy) ** 2;
    if (away < best) [best, found] = [away, at];
  }
  return found;
}

/** What one may leave out of the chart; its base not. */
export const SWITCHES = [
  ["soundings", t("Soundings")],
  ["contours", t("Depths of contours")],
  ["aids", t("Buoys, beacons, lights")],
  ["areas", t("Restricted and other areas")],
  ["names", t("Names")],
] as const;
export type Switch = (typeof SWITCHES)[number][0];

/** What is left out, from what the browser kept. */
export function keptSwitches(text: string | null): Set<Switch> {
  const known = new Set<string>(SWITCHES.map(([name]) => name));
  return new Set((text ?? "").split(",").filter((one): one is Switch => known.has(one)));
}
