// What the chart says of a plan, in a few words, and where the worst of it is. Pure.

import type { Guard, GuardReason, GuardWarning, PlanCheck, PlanDocument, PlanLeg, PlanPlace } from "../api/types.gen";
import { t, tn } from "../words/words";
import { depthText, nearestStretch } from "./chart";
import { placesOf, same, type Vertex, wayOf } from "./plan";

/** What is known of the verdict: it is asked for, nobody answered, or it is there. */
export type Judgement = { readonly kind: "asked" } | { readonly kind: "failed"; readonly text: string } | { readonly kind: "known"; readonly check: PlanCheck };

/** The least depth on the way; `depth_m` is null where it is no water of known depth. */
export interface LeastDepth {
  readonly depth_m: number | null;
  readonly place: PlanPlace;
}

export interface Verdict {
  /** `safe`, `unsafe`, `problem` and `checking` speak for themselves; `open` is neither safe nor unsafe. */
  readonly state: "safe" | "unsafe" | "problem" | "checking" | "open";
  readonly text: string;
  /** Where it is worst; absent where the verdict is about no place. */
  readonly spot?: Spot;
}

export interface Spot {
  readonly vertex: Vertex | undefined;
  readonly place: PlanPlace | undefined;
}

/** Why a verdict refuses where no leg is the reason. */
const CAUSES: Readonly<Record<string, string>> = {
  "too-large": t("the plan is too large to be checked against the chart; split it"),
  "chart-unreadable": t("the chart cannot be read, so nothing is known to be deep enough"),
  "no-go-areas": t("the no-go areas are not in the chart, so a plan may lead into one"),
};
/** From the worst; of one code, the shallowest is the worst. */
const WORST: readonly string[] = ["land", "obstacle", "too-shallow", "too-low", "unknown-depth", "no-data", "too-shallow-alone", "entry-prohibited", "entry-restricted"];
const SAYS: Readonly<Record<string, string>> = {
  land: t("crosses land"),
  obstacle: t("meets an obstacle"),
  "too-shallow": t("is too shallow"),
  "too-low": t("passes under something too low"),
  "unknown-depth": t("has unknown depth"),
  "no-data": t("has no chart"),
  "too-shallow-alone": t("is too shallow"),
  "entry-prohibited": t("enters an area where entry is prohibited"),
  "entry-restricted": t("enters an area where entry is restricted"),
};

export function verdictOf(plan: PlanDocument, now: Judgement, least: LeastDepth | undefined): Verdict {
  if (!plan.maneuvers.length) return { state: "open", text: t("Nothing is drawn yet") };
  if (now.kind === "asked") return { state: "checking", text: t("Checking…") };
  if (now.kind === "failed") return { state: "open", text: t("Not checked: {text}", { text: now.text }) };
  const { problems, guard, maneuvers } = now.check;
  if (problems.length) return ofProblems(plan, problems);
  if (!guard) return { state: "open", text: t("Not checked: no chart") };
  if (guard.outcome === "refused") return ofRefusal(plan, guard);
  return ofPassing(plan, guard, maneuvers, least);
}

function ofProblems(plan: PlanDocument, problems: PlanCheck["problems"]): Verdict {
  const [first] = problems;
  const count = tn(problems.length, "1 problem", "{n} problems");
  const step = plan.maneuvers.findIndex(({ id }) => id === first?.maneuver);
  if (step < 0) return { state: "problem", text: t("Cannot be sailed: {count}", { count }) };
  return { state: "problem", text: t("Cannot be sailed: {count}, first in {maneuver}", { count, maneuver: first?.maneuver ?? "" }), spot: { vertex: { step, point: 0 }, place: undefined } };
}

function ofRefusal(plan: PlanDocument, guard: Guard): Verdict {
  const worst = worstOf(guard.reasons);
  return { state: "unsafe", text: t("Not safe: {text}", { text: refusedText(plan, guard) }), ...(worst ? { spot: spotOf(plan, worst) } : {}) };
}

function ofPassing(plan: PlanDocument, guard: Guard, legs: readonly PlanLeg[], least: LeastDepth | undefined): Verdict {
  const depth = least?.depth_m == null ? "" : `: ${t("least depth {depth}", { depth: depthText(least.depth_m).replace(" m", "\u00a0m") })}`;
  const spot = least ? { spot: { vertex: nearestVertex(plan, legs, least.place), place: least.place } } : {};
  // The way from the vessel to the first place is judged when the plan is brought aboard and started.
  const warnings = guard.warnings.filter(({ code }) => code !== "start-unknown");
  if (!warnings.length) return { state: "safe", text: `${t("Safe from {id} on", { id: plan.maneuvers[0]?.id ?? "" })}${depth}`, ...spot };
  const partly = warnings.some(({ code }) => code === "unchecked");
  const count = tn(warnings.length, "1 warning", "{n} warnings");
  const step = plan.maneuvers.findIndex(({ id }) => id === warnings[0]?.maneuver);
  const about = step < 0 ? spot : { spot: { vertex: { step, point: 0 }, place: undefined } };
  return { state: "open", text: `${partly ? t("Partly checked") : t("Safe, with warnings")}: ${count}${depth.replace(":", ",")}`, ...about };
}

/** The reason that counts most. */
export function worstOf(reasons: readonly GuardReason[]): GuardReason | undefined {
  const rank = ({ code }: GuardReason): number => (WORST.includes(code) ? WORST.indexOf(code) : WORST.length);
  return [...reasons].sort((one, other) => rank(one) - rank(other) || (one.depth_m ?? 0) - (other.depth_m ?? 0))[0];
}

const PARTS: Readonly<Record<string, string>> = { circle: t("circle"), station: t("station"), drift: t("drift") };

/** Which leg does what, and in how little water. Without the plan, a track is taken to have numbered legs. */
export function reasonWords(plan: PlanDocument | undefined, reason: GuardReason): string {
  return `${legWords(plan, reason)}${depthOf(reason)}`;
}

/** The same with what is needed, the area and the chart: for lists, where there is room. */
export function reasonInFull(plan: PlanDocument | undefined, reason: GuardReason): string {
  const { depth_m, margin_m, area, cell } = reason;
  const needs = depth_m === null || margin_m === null || margin_m >= 0 ? "" : `; ${t("needs {depth} m", { depth: (depth_m - margin_m).toFixed(1) })}`;
  const chart = [area, cell].filter(Boolean).join(", ");
  return `${reasonWords(plan, reason)}${needs}${chart ? ` (${chart})` : ""}`;
}

/** Why the guard refuses, in a line: the worst leg and how many more there are. */
export function refusedText(plan: PlanDocument | undefined, guard: Guard): string {
  const worst = worstOf(guard.reasons);
  if (!worst) return (guard.cause && CAUSES[guard.cause]) || guard.text;
  const others = guard.reasons.length - 1;
  return `${reasonWords(plan, worst)}${others > 0 ? `, ${tn(others, "and {n} more leg", "and {n} more legs")}` : ""}`;
}

/** What was not checked, or not well. */
export function warningWords({ code, about, text }: GuardWarning): string {
  if (code === "start-unknown") return t("where the vessel comes from is not known; that way is not checked");
  if (code === "unchecked") return t("it is not known beforehand where a {kind} leads, so it is not checked", { kind: about ?? "" });
  if (code === "drifts-on") return t("the vessel drifts for a time that is not known; it is not checked");
  if (code === "poor-chart") return t("deep enough by a survey of poor or unknown quality ({chart})", { chart: about ?? t("the chart") });
  const enters = SAYS[code];
  return enters ? `${enters}${about ? `: ${about}` : ""}` : text;
}

function depthOf({ code, depth_m }: GuardReason): string {
  return depth_m === null || !code.startsWith("too-shallow") ? "" : `, ${depthText(depth_m)}`;
}

/** Which leg does what. */
function legWords(plan: PlanDocument | undefined, { maneuver, part, number, code, from, to }: GuardReason): string {
  const says = SAYS[code] ?? code;
  if (part === "place") return `${maneuver} ${says}`;
  // The way to the first place is left out, and that place is judged alone.
  if (part === "transit" && from && to && same(from, to)) return code === "land" ? t("{maneuver} is on land", { maneuver }) : t("the place of {maneuver} {says}", { maneuver, says });
  if (part === "transit") return t("the way to {maneuver} {says}", { maneuver, says });
  const kind = plan?.maneuvers.find(({ id }) => id === maneuver)?.task.kind ?? "follow_path";
  if (part === "track" && (kind === "follow_path" || kind === "rows")) return t("leg {number} of {maneuver} {says}", { number: number + 1, maneuver, says });
  return part === "track" ? `${maneuver} ${says}` : t("the {part} of {maneuver} {says}", { part: PARTS[part] ?? part, maneuver, says });
}

function spotOf(plan: PlanDocument, reason: GuardReason): Spot {
  const step = plan.maneuvers.findIndex(({ id }) => id === reason.maneuver);
  const task = plan.maneuvers[step]?.task;
  const place = { lat_deg: reason.lat_deg, lon_deg: reason.lon_deg };
  if (!task) return { vertex: undefined, place };
  return { vertex: { step, point: nearestPoint(placesOf(task), place) }, place };
}

/** The maneuver on whose way, or the way to it, a place is; of a path, its point nearest to the place. */
export function nearestVertex(plan: PlanDocument, legs: readonly PlanLeg[], place: PlanPlace): Vertex | undefined {
  let before: PlanPlace | undefined;
  let found: { vertex: Vertex; away: number } | undefined;
  for (const [step, one] of plan.maneuvers.entries()) {
    const way = wayOf(one, legs);
    const line = before ? [before, ...way] : way;
    const away = awayFrom(line, place);
    if (!found || away < found.away) found = { vertex: { step, point: nearestPoint(placesOf(one.task), place) }, away };
    before = way.at(-1) ?? before;
  }
  return found?.vertex;
}

function nearestPoint(points: readonly PlanPlace[], place: PlanPlace): number {
  return points.reduce((best, one, at) => (apart(one, place) < apart(points[best] ?? one, place) ? at : best), 0);
}

function awayFrom(line: readonly PlanPlace[], place: PlanPlace): number {
  const at = nearestStretch(line, place);
  const [from, to] = at === undefined ? [line[0], line[0]] : [line[at], line[at + 1]];
  if (!from || !to) return Infinity;
  const east = Math.cos((place.lat_deg * Math.PI) / 180);
  const [x, y, dx, dy] = [(from.lon_deg - place.lon_deg) * east, from.lat_deg - place.lat_deg, (to.lon_deg - from.lon_deg) * east, to.lat_deg - from.lat_deg];
  const size = dx * dx + dy * dy;
  const part = size > 0 ? Math.max(0, Math.min(1, -(x * dx + y * dy) / size)) : 0;
  return Math.hypot(x + part * dx, y + part * dy);
}

/** How far two places are apart, in degrees of latitude. */
function apart(one: PlanPlace, other: PlanPlace): number {
  return Math.hypot((one.lon_deg - other.lon_deg) * Math.cos((one.lat_deg * Math.PI) / 180), one.lat_deg - other.lat_deg);
}
