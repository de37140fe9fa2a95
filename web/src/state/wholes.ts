// Whole maneuvers: moved with all their points, copied, sailed backwards; and a whole plan backwards. Pure.

import type { PlanDocument, PlanPlace, PlanStep, PlanTask } from "../api/types.gen";
import { t } from "../words/words";
import { groundAt, type Metres } from "./ground";
import { freeId, placesOf, rounded, type Task } from "./plan";
import { rowsBack, rowsCentre, rowsCorners, rowsHead, whyNotBack } from "./rows";

/** Names have no more bytes; a copy's has a number behind it. */
const MOST_BASE_BYTES = 54;

/** With a maneuver that is as far from where it was as `to` is from `from`. */
export function withMoved(plan: PlanDocument, step: number, from: PlanPlace, to: PlanPlace): PlanDocument {
  return withMovedBy(plan, step, groundAt(from).metres(to));
}

/** With a maneuver so many metres to the north and to the east; its shape stays. */
export function withMovedBy(plan: PlanDocument, step: number, by: Metres): PlanDocument {
  return withTaskOf(plan, step, (task) => movedBy(task, by));
}

function movedBy(task: PlanTask, [north, east]: Metres): PlanTask {
  if (task.kind !== "follow_path") return { ...task, at: rounded(groundAt(task.at).place([north, east])) };
  const [first] = task.points;
  if (!first) return task;
  // One frame for all points where they are, and one where they come to, so that distances between them stay.
  const [ground, there] = [groundAt(first), groundAt(groundAt(first).place([north, east]))];
  return { ...task, points: task.points.map((point) => rounded(there.place(ground.metres(point)))) };
}

/** With a copy of a maneuver after it, so far to the south-east that it is seen. */
export function withCopy(plan: PlanDocument, step: number, apart_m: number): PlanDocument {
  const one = plan.maneuvers[step];
  if (!one) return plan;
  const copy: PlanStep = { ...one, id: freeId(plan, baseOf(one.id)), task: movedBy(one.task, [-apart_m, apart_m]) };
  return { ...plan, maneuvers: [...plan.maneuvers.slice(0, step + 1), copy, ...plan.maneuvers.slice(step + 1)] };
}

/** A name without the number behind it, and not too long for another. */
function baseOf(id: string): string {
  const letters = [...(id.replace(/ \d+$/, "") || id)];
  while (new TextEncoder().encode(letters.join("")).length > MOST_BASE_BYTES) letters.pop();
  return letters.join("").trim() || "Copy";
}

/** Why a maneuver has no way back; undefined where it has. */
export function whyNotReversed(task: PlanTask): string | undefined {
  switch (task.kind) {
    case "goto":
    case "station_keeping":
      return t("it is one place");
    case "follow_path":
      return task.points.length < 2 ? t("it is one place") : undefined;
    case "loiter":
      return undefined;
    case "rows":
      return whyNotBack(task);
  }
}

/** With a maneuver sailed the other way, a circle the other way round; the same plan where it has no way back. */
export function withBack(plan: PlanDocument, step: number): PlanDocument {
  const task = plan.maneuvers[step]?.task;
  return !task || whyNotReversed(task) !== undefined ? plan : withTaskOf(plan, step, back);
}

function back(task: PlanTask): PlanTask {
  if (task.kind === "follow_path") return { ...task, points: [...task.points].reverse() };
  if (task.kind === "loiter") return { ...task, clockwise: !task.clockwise };
  if (task.kind !== "rows") return task;
  const turned = rowsBack(task);
  return { ...turned, at: rounded(turned.at) };
}

/** The plan from its end to its beginning: paths and rows backwards too, as far as they have a way back. Circles stay. */
export function withAllBack(plan: PlanDocument): PlanDocument {
  const maneuvers = plan.maneuvers.map((step) => (step.task.kind === "loiter" ? step : { ...step, task: back(step.task) }));
  return { ...plan, maneuvers: maneuvers.reverse() };
}

/** With other rows in place of a maneuver's. */
export function withRows(plan: PlanDocument, step: number, rows: Task<"rows">): PlanDocument {
  return withTaskOf(plan, step, () => ({ ...rows, at: rounded(rows.at) }));
}

/** What one takes hold of to change a whole maneuver. */
export interface Grip {
  readonly kind: "move" | "turn" | "size";
  readonly step: number;
  readonly place: PlanPlace;
  /** It is drawn so far beside its place, px: to the right and down, or along a bearing. */
  readonly beside: { readonly px: readonly [number, number] } | { readonly px: number; readonly bearing_deg: number };
}

const BESIDE_PX = 24;
const HEAD_PX = 34;

/** The grips of a maneuver; none for a single place, which is its own. */
export function gripsOf(plan: PlanDocument, step: number): Grip[] {
  const task = plan.maneuvers[step]?.task;
  if (!task || task.kind === "goto" || (task.kind === "follow_path" && task.points.length < 2)) return [];
  if (task.kind !== "rows") return [{ kind: "move", step, place: southEast(task), beside: { px: [BESIDE_PX, BESIDE_PX] } }];
  const corner = rowsCorners(task)[2];
  return [
    { kind: "move", step, place: rowsCentre(task), beside: { px: [0, 0] } },
    { kind: "turn", step, place: rowsHead(task), beside: { px: HEAD_PX, bearing_deg: task.bearing_deg } },
    ...(corner ? [{ kind: "size" as const, step, place: corner, beside: { px: [0, 0] as const } }] : []),
  ];
}

/** The corner of all that a path or circle covers. */
function southEast(task: PlanTask): PlanPlace {
  const places = placesOf(task);
  const [lats, lons] = [places.map(({ lat_deg }) => lat_deg), places.map(({ lon_deg }) => lon_deg)];
  const corner = { lat_deg: Math.min(...lats), lon_deg: Math.max(...lons) };
  if (task.kind !== "loiter" && task.kind !== "station_keeping") return corner;
  const out = task.radius_m * Math.SQRT1_2;
  return groundAt(corner).place([-out, out]);
}

function withTaskOf(plan: PlanDocument, index: number, change: (task: PlanTask) => PlanTask): PlanDocument {
  return { ...plan, maneuvers: plan.maneuvers.map((step, at) => (at === index ? { ...step, task: change(step.task) } : step)) };
}
