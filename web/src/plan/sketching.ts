// An area while it is drawn: its corners, with a way back, and the maneuver that becomes of it. No page in it.

import type { PlanPlace, PlanTask } from "../api/types.gen";
import { fresh, rounded, type Task } from "../state/plan";
import { rowsBetween, rowsCount, rowsCorners, rowsWay } from "../state/rows";
import { linesInPolygon } from "../state/sweep";
import { t, tn } from "../words/words";

export const SKETCHES = [
  ["rows_rectangle", t("Rows in rectangle")],
  ["lines_polygon", t("Lines in polygon")],
] as const;
export type SketchKind = (typeof SKETCHES)[number][0];

export const isSketch = (tool: string | undefined): tool is SketchKind => SKETCHES.some(([kind]) => kind === tool);

/** What is drawn of it, and what is told. */
export interface SketchView {
  readonly corners: readonly PlanPlace[];
  /** Its edge, closed. */
  readonly edge: readonly PlanPlace[];
  /** The way that the vessel would take. */
  readonly way: readonly PlanPlace[];
  readonly told: string;
  /** It could be taken as it is. */
  readonly whole: boolean;
}

/** A maneuver that was drawn, and what it is called. */
export interface Drawn {
  readonly name: string;
  readonly task: PlanTask;
}

export class Sketching {
  corners: readonly PlanPlace[] = [];
  spacing_m = 20;
  /** Along which rows and lines run, °; undefined for what suits the area. */
  bearing_deg: number | undefined;
  /** Where the hand is, which would be the next corner. */
  private hand: PlanPlace | undefined;
  private undone: readonly PlanPlace[] = [];
  private begun: PlanPlace | undefined;

  clear(): void {
    [this.corners, this.undone, this.hand, this.bearing_deg] = [[], [], undefined, undefined];
  }

  get canUndo(): boolean {
    return this.corners.length > 0;
  }

  get canRedo(): boolean {
    return this.undone.length > 0;
  }

  travel(back: boolean): boolean {
    const [from, to] = back ? [this.corners, this.undone] : [this.undone, this.corners];
    const last = from.at(-1);
    if (!last) return false;
    [this.corners, this.undone] = back ? [from.slice(0, -1), [...to, last]] : [[...to, last], from.slice(0, -1)];
    return true;
  }

  add(corner: PlanPlace): void {
    this.corners = [...this.corners, rounded(corner)];
    [this.undone, this.hand] = [[], undefined];
  }

  /** The first corner of a drag, which may be told again and again. */
  begin(corner: PlanPlace): void {
    if (this.begun !== corner) [this.corners, this.undone, this.begun] = [[rounded(corner)], [], corner];
  }

  /** Without the last corner, for good. */
  drop(): void {
    [this.corners, this.hand] = [this.corners.slice(0, -1), undefined];
  }

  lead(hand: PlanPlace | undefined): void {
    this.hand = hand;
  }

  /** What would become of it, with the hand as the last corner if it is not finished; a text says why nothing. */
  made(kind: SketchKind, withHand = false): Drawn | string {
    const corners = [...this.corners, ...(withHand && this.hand ? [this.hand] : [])];
    return kind === "rows_rectangle" ? this.rows(corners) : this.lines(corners);
  }

  private rows([from, to]: readonly PlanPlace[]): Drawn | string {
    if (!from || !to) return t("a rectangle has two corners");
    const task = rowsBetween(from, to, { ...(fresh("rows", from) as Task<"rows">), step_m: this.spacing_m }, this.bearing_deg);
    return task ? { name: "Rows", task: { ...task, at: rounded(task.at) } } : t("it is too narrow");
  }

  private lines(corners: readonly PlanPlace[]): Drawn | string {
    const sweep = linesInPolygon(corners, this.spacing_m, this.bearing_deg);
    return typeof sweep === "string" ? sweep : { name: "Lines", task: { kind: "follow_path", points: sweep.points.map(rounded) } };
  }

  view(kind: SketchKind): SketchView {
    const corners = this.hand ? [...this.corners, this.hand] : this.corners;
    const drawn = this.made(kind, true);
    const whole = typeof this.made(kind) !== "string";
    if (typeof drawn === "string") return { corners: this.corners, edge: corners, way: [], told: this.hint(kind, drawn), whole };
    const { task } = drawn;
    if (task.kind === "rows") {
      return { corners: this.corners, edge: [...rowsCorners(task), task.at], way: rowsWay(task), told: tn(rowsCount(task), "{n} row of {length} m, {width} m wide; turns go {overrun} m beyond.", "{n} rows of {length} m, {width} m wide; turns go {overrun} m beyond.", { length: Math.round(task.length_m), width: Math.round(task.width_m), overrun: task.curve_offset_m }), whole };
    }
    const points = task.kind === "follow_path" ? task.points : [];
    return { corners: this.corners, edge: [...corners, ...corners.slice(0, 1)], way: points, told: `${tn(points.length / 2, "{n} line.", "{n} lines.")} ${FINISH}`, whole };
  }

  private hint(kind: SketchKind, wrong: string): string {
    const count = this.corners.length;
    if (kind === "rows_rectangle") return count ? (this.hand ? t("Not yet: {wrong}.", { wrong }) : t("Click the opposite corner.")) : t("Drag from one corner to the opposite one, or click both. Enter takes the middle of the map.");
    if (count >= 3) return t("Not possible: {wrong}.", { wrong });
    return count ? t("{n} of 3 corners or more.", { n: count }) : t("Click the corners. Enter takes the middle of the map, Backspace drops the last corner.");
  }
}

const FINISH = t("Click the first corner or Finish.");
