// What the chart says of a plan, in a few words, and where the worst of it is. Pure.

import type { Guard, GuardReason, PlanCheck, PlanDocument, PlanLeg, PlanPlace } from "../api/types.gen";
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

/** From the worst; of one code, the shallowest is the worst. */
const WORST: readonly string[] = ["land", "obstacle", "too-shallow", "too-low", "unknown-depth", "no-data", "too-shallow-alone"];
const SAYS: Readonly<Record<string, string>> = {
  land: "crosses land",
  obstacle: "meets an obstacle",
  "too-shallow": "is too shallow",
  "too-low": "passes under something too low",
  "unknown-depth": "has unknown depth",
  "no-data": "has no chart",
  "too-shallow-alone": "is too shallow",
};

export function verdictOf(plan: PlanDocument, now: Judgement, least: LeastDepth | undefined): Verdict {
  if (!plan.maneuvers.length) return { state: "open", text: "Nothing is drawn yet" };
  if (now.kind === "asked") return { state: "checking", text: "Checking…" };
  if (now.kind === "failed") return { state: "open", text: `Not checked: ${now.text}` };
  const { problems, guard, maneuvers } = now.check;
  if (problems.length) return ofProblems(plan, problems);
  if (!guard) return { state: "open", text: "Not checked: no chart" };
  if (guard.outcome === "refused") return ofRefusal(plan, guard);
  return ofPassing(plan, guard, maneuvers, least);
}

function ofProblems(plan: PlanDocument, problems: PlanCheck["problems"]): Verdict {
  const [first] = problems;
  const count = problems.length === 1 ? "1 problem" : `${problems.length} problems`;
  const step = plan.maneuvers.findIndex(({ id }) => id === first?.maneuver);
  if (step < 0) return { state: "problem", text: `Cannot be sailed: ${count}` };
  return { state: "problem", text: `Cannot be sailed: ${count}, first in ${first?.maneuver}`, spot: { vertex: { step, point: 0 }, place: undefined } };
}

function ofRefusal(plan: PlanDocument, guard: Guard): Verdict {
  const worst = worstOf(guard.reasons);
  if (!worst) return { state: "unsafe", text: `Not safe: ${guard.text}` };
  const others = guard.reasons.length - 1;
  const more = others > 0 ? `, and ${others} more ${others === 1 ? "leg" : "legs"}` : "";
  return { state: "unsafe", text: `Not safe: ${legWords(plan, worst)}${depthOf(worst)}${more}`, spot: spotOf(plan, worst) };
}

function ofPassing(plan: PlanDocument, guard: Guard, legs: readonly PlanLeg[], least: LeastDepth | undefined): Verdict {
  const depth = least?.depth_m == null ? "" : `: least depth ${depthText(least.depth_m).replace(" m", "\u00a0m")}`;
  const spot = least ? { spot: { vertex: nearestVertex(plan, legs, least.place), place: least.place } } : {};
  // The way from the vessel to the first place is judged when the plan is brought aboard and started.
  const warnings = guard.warnings.filter(({ code }) => code !== "start-unknown");
  if (!warnings.length) return { state: "safe", text: `Safe from ${plan.maneuvers[0]?.id} on${depth}`, ...spot };
  const partly = warnings.some(({ code }) => code === "unchecked");
  const count = warnings.length === 1 ? "1 warning" : `${warnings.length} warnings`;
  const step = plan.maneuvers.findIndex(({ id }) => id === warnings[0]?.maneuver);
  const about = step < 0 ? spot : { spot: { vertex: { step, point: 0 }, place: undefined } };
  return { state: "open", text: `${partly ? "Partly checked" : "Safe, but look"}: ${count}${depth.replace(":", ",")}`, ...about };
}

/** The reason that counts most. */
export function worstOf(reasons: readonly GuardReason[]): GuardReason | undefined {
  const rank = ({ code }: GuardReason): number => (WORST.includes(code) ? WORST.indexOf(code) : WORST.length);
  return [...reasons].sort((one, other) => rank(one) - rank(other) || (one.depth_m ?? 0) - (other.depth_m ?? 0))[0];
}

function depthOf({ code, depth_m }: GuardReason): string {
  return depth_m === null || !code.startsWith("too-shallow") ? "" : `, ${depthText(depth_m)}`;
}

/** Which leg does what. */
function legWords(plan: PlanDocument, { maneuver, part, number, code, from, to }: GuardReason): string {
  const says = SAYS[code] ?? code;
  // The way to the first place is left out, and that place is judged alone.
  if (part === "transit" && same(from, to)) return code === "land" ? `${maneuver} is on land` : `the place of ${maneuver} ${says}`;
  if (part === "transit") return `the way to ${maneuver} ${says}`;
  const kind = plan.maneuvers.find(({ id }) => id === maneuver)?.task.kind;
  if (part === "track" && (kind === "follow_path" || kind === "rows")) return `leg ${number + 1} of ${maneuver} ${says}`;
  return part === "track" ? `${maneuver} ${says}` : `the ${part} of ${maneuver} ${says}`;
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
