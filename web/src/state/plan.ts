// A plan under the hands of its author: pure steps from one document to the next, with undo.

import type { PlanDocument, PlanLeg, PlanPlace, PlanSpeed, PlanStep, PlanTask } from "../api/types.gen";
import { t } from "../words/words";
import { rowsWay } from "./rows";
import { toWire } from "./units";

export type TaskKind = PlanTask["kind"];
export type Task<K extends TaskKind> = Extract<PlanTask, { kind: K }>;

/** What maneuvers are called, in the order of the tools. */
export const KINDS: readonly (readonly [TaskKind, string])[] = [
  ["goto", "Goto"],
  ["follow_path", "Path"],
  ["station_keeping", "Station"],
  ["loiter", "Loiter"],
  ["rows", "Rows"],
];
/** The same in the page's language; what plans hold keeps its name everywhere. */
export const KIND_WORDS: Readonly<Record<TaskKind, string>> = { goto: t("Goto"), follow_path: t("Path"), station_keeping: t("Station"), loiter: t("Loiter"), rows: t("Rows") };
/** Decimals of a degree that are kept: a centimetre. */
const PER_DEGREE = 1e7;
/** Of the first maneuver of a plan: 3 kn. */
export const FIRST_SPEED: PlanSpeed = { value: toWire(3, "m/s"), unit: "mps" };
/** Two ways to lay out rows agree to this: some centimetres. */
const SAME_DEG = 1e-6;
const STEPS_KEPT = 200;
/** Changes of the same thing within this are one step of undo, ms. */
const TOGETHER_MS = 1_200;
const M_PER_DEGREE = 111_195;

/** A place of a plan: which maneuver, and which point of it. */
export interface Vertex {
  readonly step: number;
  readonly point: number;
}

export function kindName(kind: TaskKind): string {
  return KINDS.find(([known]) => known === kind)?.[1] ?? kind;
}

export function placesOf(task: PlanTask): readonly PlanPlace[] {
  return task.kind === "follow_path" ? task.points : [task.at];
}

export function placeAt(plan: PlanDocument, vertex: Vertex): PlanPlace | undefined {
  const step = plan.maneuvers[vertex.step];
  return step && placesOf(step.task)[vertex.point];
}

/** All places in the order in which they are sailed. */
export function vertices(plan: PlanDocument): { vertex: Vertex; place: PlanPlace }[] {
  return plan.maneuvers.flatMap(({ task }, step) => placesOf(task).map((place, point) => ({ vertex: { step, point }, place })));
}

export function rounded(place: PlanPlace): PlanPlace {
  const round = (deg: number): number => Math.round(deg * PER_DEGREE) / PER_DEGREE;
  const lon = ((((place.lon_deg + 180) % 360) + 360) % 360) - 180;
  return { lat_deg: round(Math.max(-90, Math.min(90, place.lat_deg))), lon_deg: round(lon) };
}

function withStep(plan: PlanDocument, index: number, change: (step: PlanStep) => PlanStep): PlanDocument {
  return { ...plan, maneuvers: plan.maneuvers.map((step, at) => (at === index ? change(step) : step)) };
}

/** With other values in one maneuver. */
export function withTask(plan: PlanDocument, index: number, values: Readonly<Record<string, number | boolean>>): PlanDocument {
  return withStep(plan, index, (step) => ({ ...step, task: { ...step.task, ...values } as PlanTask }));
}

export function withName(plan: PlanDocument, index: number, id: string): PlanDocument {
  return withStep(plan, index, (step) => ({ ...step, id }));
}

/** With another speed of one maneuver, or without index of all. */
export function withSpeed(plan: PlanDocument, speed: PlanSpeed, index?: number): PlanDocument {
  return { ...plan, maneuvers: plan.maneuvers.map((step, at) => (index === undefined || at === index ? { ...step, speed } : step)) };
}

/** With a vertex somewhere else. */
export function withPlace(plan: PlanDocument, { step, point }: Vertex, place: PlanPlace): PlanDocument {
  return withStep(plan, step, (one) => {
    const { task } = one;
    if (task.kind !== "follow_path") return { ...one, task: { ...task, at: rounded(place) } };
    return { ...one, task: { ...task, points: task.points.map((old, at) => (at === point ? rounded(place) : old)) } };
  });
}

/** With a new maneuver at `index`, or at the end. */
export function withNew(plan: PlanDocument, kind: TaskKind, place: PlanPlace, speed: PlanSpeed, index = plan.maneuvers.length): PlanDocument {
  return withNewTask(plan, kindName(kind), fresh(kind, rounded(place)), speed, index);
}

/** With a new maneuver at `index` that does this, called by a name with a number. */
export function withNewTask(plan: PlanDocument, name: string, task: PlanTask, speed: PlanSpeed, index: number): PlanDocument {
  const maneuvers = [...plan.maneuvers];
  maneuvers.splice(index, 0, { id: freeId(plan, name), speed, task });
  return { ...plan, maneuvers };
}

/** A maneuver as one begins with it. */
export function fresh(kind: TaskKind, at: PlanPlace): PlanTask {
  switch (kind) {
    case "goto":
      return { kind, at };
    case "follow_path":
      return { kind, points: [at] };
    case "station_keeping":
      return { kind, at, radius_m: 15, duration_s: 300 };
    case "loiter":
      return { kind, at, radius_m: 30, duration_s: 300, clockwise: true };
    case "rows":
      return { kind, at, bearing_deg: 0, cross_angle_deg: 0, width_m: 100, length_m: 150, step_m: 20, curve_offset_m: 10, alternation_percent: 100, square_curve: true, curve_right: true };
  }
}

/** A name with a number that no maneuver has yet. */
export function freeId(plan: PlanDocument, name: string): string {
  const taken = new Set(plan.maneuvers.map((step) => step.id));
  for (let number = 1; ; number++) if (!taken.has(`${name} ${number}`)) return `${name} ${number}`;
}

/** With a point of a path before `point`. */
export function withPoint(plan: PlanDocument, { step, point }: Vertex, place: PlanPlace): PlanDocument {
  return withStep(plan, step, (one) => {
    if (one.task.kind !== "follow_path") return one;
    const points = [...one.task.points];
    points.splice(point, 0, rounded(place));
    return { ...one, task: { ...one.task, points } };
  });
}

/** Without a point of a path; without its last point, or any other maneuver's only one, without the maneuver. */
export function withoutVertex(plan: PlanDocument, { step, point }: Vertex): PlanDocument {
  const task = plan.maneuvers[step]?.task;
  if (task?.kind !== "follow_path" || task.points.length < 2) return withoutStep(plan, step);
  return withStep(plan, step, (one) => ({ ...one, task: { ...task, points: task.points.filter((_, at) => at !== point) } }));
}

export function withoutStep(plan: PlanDocument, step: number): PlanDocument {
  return { ...plan, maneuvers: plan.maneuvers.filter((_, at) => at !== step) };
}

/** With a maneuver moved by so many places; the same plan where that is not possible. */
export function withOrder(plan: PlanDocument, step: number, by: number): PlanDocument {
  const to = step + by;
  const one = plan.maneuvers[step];
  if (!one || to < 0 || to >= plan.maneuvers.length) return plan;
  const maneuvers = plan.maneuvers.filter((_, at) => at !== step);
  maneuvers.splice(to, 0, one);
  return { ...plan, maneuvers };
}

/** A new place between a vertex and the one after it: of a path a point of it, else a Goto. */
export function withBetween(plan: PlanDocument, after: Vertex, place: PlanPlace): { plan: PlanDocument; vertex: Vertex } {
  const step = plan.maneuvers[after.step];
  if (step?.task.kind === "follow_path" && after.point < step.task.points.length - 1) {
    const vertex = { step: after.step, point: after.point + 1 };
    return { plan: withPoint(plan, vertex, place), vertex };
  }
  const speed = step?.speed ?? FIRST_SPEED;
  return { plan: withNew(plan, "goto", place, speed, after.step + 1), vertex: { step: after.step + 1, point: 0 } };
}

/** The place so many metres away. On a sphere, which is near enough for moving things by hand. */
export function displaced(place: PlanPlace, northM: number, eastM: number): PlanPlace {
  const lat = place.lat_deg + northM / M_PER_DEGREE;
  return rounded({ lat_deg: lat, lon_deg: place.lon_deg + eastM / (M_PER_DEGREE * Math.max(0.01, Math.cos((place.lat_deg * Math.PI) / 180))) });
}

export function middle(one: PlanPlace, other: PlanPlace): PlanPlace {
  return rounded({ lat_deg: (one.lat_deg + other.lat_deg) / 2, lon_deg: (one.lon_deg + other.lon_deg) / 2 });
}

/** Whether two things of JSON say the same, in whatever order their fields stand. */
export function same(one: unknown, other: unknown): boolean {
  if (one === other) return true;
  if (typeof one !== "object" || typeof other !== "object" || one === null || other === null) return false;
  const [own, theirs] = [Object.entries(one), new Map(Object.entries(other))];
  return Array.isArray(one) === Array.isArray(other) && own.length === theirs.size && own.every(([key, value]) => theirs.has(key) && same(value, theirs.get(key)));
}

/** Of a circle that is looked at corner by corner: 0.9 % of its radius lie between both. */
const CORNERS = 24;

/** The states of a plan, to go back and forth between. */
export class History {
  private before: PlanDocument[] = [];
  private after: PlanDocument[] = [];
  private last = { what: "", at: -Infinity };

  constructor(private current: PlanDocument) {}

  get plan(): PlanDocument {
    return this.current;
  }

  get canUndo(): boolean {
    return this.before.length > 0;
  }

  get canRedo(): boolean {
    return this.after.length > 0;
  }

  /** Goes on to `next`. Quick changes of the same `what` are one step. */
  push(next: PlanDocument, what = "", nowMs = 0): void {
    if (next === this.current) return;
    const together = what !== "" && what === this.last.what && nowMs - this.last.at < TOGETHER_MS;
    if (!together) this.before = [...this.before.slice(1 - STEPS_KEPT), this.current];
    this.last = { what, at: nowMs };
    this.after = [];
    this.current = next;
  }

  undo(): boolean {
    return this.go(this.before, this.after);
  }

  redo(): boolean {
    return this.go(this.after, this.before);
  }

  private go(from: PlanDocument[], to: PlanDocument[]): boolean {
    const next = from.pop();
    if (!next) return false;
    to.push(this.current);
    this.current = next;
    this.last = { what: "", at: -Infinity };
    return true;
  }
}

/** Where a maneuver leads: of rows as the server laid them out, as soon as it has laid out these. */
export function wayOf(step: PlanStep, legs: readonly PlanLeg[]): PlanPlace[] {
  if (step.task.kind !== "rows") return [...placesOf(step.task)];
  const way = rowsWay(step.task);
  const places = legs.find((one) => one.id === step.id)?.places ?? [];
  // What cannot be laid out here, the server may.
  return places.length && (way.length < 2 || alike(places, way)) ? [...places] : way;
}

/** A circle once round, from its north on. */
function circle({ at, radius_m, clockwise }: PlanTask & { kind: "loiter" }): PlanPlace[] {
  return Array.from({ length: CORNERS + 1 }, (_, corner) => {
    const bearing = ((clockwise ? 1 : -1) * corner * 2 * Math.PI) / CORNERS;
    return displaced(at, radius_m * Math.cos(bearing), radius_m * Math.sin(bearing));
  });
}

function alike(one: readonly PlanPlace[], other: readonly PlanPlace[]): boolean {
  const near = (a: PlanPlace, b: PlanPlace | undefined): boolean => b !== undefined && Math.abs(a.lat_deg - b.lat_deg) < SAME_DEG && Math.abs(a.lon_deg - b.lon_deg) < SAME_DEG;
  return one.length === other.length && one.every((place, at) => near(place, other[at]));
}

/** All that a plan sails over, circles as they are sailed; one that repeats, back to its beginning. */
export function wayOfAll(plan: PlanDocument, legs: readonly PlanLeg[]): PlanPlace[] {
  const way = plan.maneuvers.flatMap((step) => (step.task.kind === "loiter" ? circle(step.task) : wayOf(step, legs)));
  const [first] = way;
  return plan.repeat && first ? [...way, first] : way;
}
