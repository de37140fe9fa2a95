// A plan while it is edited: what is drawn, which vertex is chosen, which tool is in hand, and the way back. No page in it.

import type { PlanDocument, PlanPlace, PlanSpeed } from "../api/types.gen";
import { displaced, FIRST_SPEED, History, middle, placeAt, placesOf, type TaskKind, type Vertex, vertices, withBetween, withNew, withNewTask, withOrder, withoutStep, withoutVertex, withPlace, withPoint } from "../state/plan";
import { rowsTo, rowsTurned, turnBetween } from "../state/rows";
import { type Grip, withAllBack, withBack, withCopy, withMoved, withMovedBy, withRows } from "../state/wholes";
import { isSketch, type SketchKind, Sketching } from "./sketching";

/** A maneuver that is inserted after the last lies so far north of it, m. */
const NEXT_M = 50;

export interface EditingHandlers {
  /** The plan is another one: it is to be kept and judged. */
  changed(plan: PlanDocument): void;
  /** Something is to be drawn. */
  draw(): void;
  /** The middle of the map. */
  centre(): PlanPlace;
  /** Brings a place into view. */
  reveal(place: PlanPlace): void;
}

/** What a click on the map does: adds a maneuver, or a corner of an area. */
export type Tool = TaskKind | SketchKind;

export class PlanEditing {
  selected: Vertex | undefined;
  tool: Tool | undefined;
  /** The area that is drawn with a tool for areas. */
  readonly sketch = new Sketching();
  private readonly history: History;
  /** While a vertex is dragged. */
  private dragged: PlanDocument | undefined;

  constructor(first: PlanDocument, readonly writable: boolean, private readonly on: EditingHandlers) {
    this.history = new History(first);
  }

  /** As it is drawn. */
  get shown(): PlanDocument {
    return this.dragged ?? this.history.plan;
  }

  /** Without what is being dragged. */
  get plan(): PlanDocument {
    return this.history.plan;
  }

  get canUndo(): boolean {
    return (this.sketch.canUndo || this.history.canUndo) && this.writable;
  }

  get canRedo(): boolean {
    return (this.sketch.canRedo || this.history.canRedo) && this.writable;
  }

  /** The speed of what is added: that of the last maneuver. */
  get speed(): PlanSpeed {
    return this.plan.maneuvers.at(-1)?.speed ?? FIRST_SPEED;
  }

  /** `what`: changes of one name that follow each other closely are undone as one. */
  change(next: PlanDocument, what = ""): void {
    if (!this.writable || next === this.plan) return this.on.draw();
    this.history.push(next, what, performance.now());
    this.on.changed(next);
    this.on.draw();
  }

  /** Takes over another plan as it is, with a way back to the one before. */
  replace(next: PlanDocument): void {
    this.history.push(next);
    this.selected = undefined;
  }

  /** Back and forth: corners of an area that is being drawn first. */
  travel(back: boolean): void {
    if (this.sketch.travel(back)) return this.on.draw();
    if (!(back ? this.history.undo() : this.history.redo())) return;
    if (this.selected && !placeAt(this.plan, this.selected)) this.selected = undefined;
    this.on.changed(this.plan);
    this.on.draw();
  }

  press(kind: Tool | undefined): void {
    this.tool = this.tool === kind ? undefined : kind;
    this.sketch.clear();
    this.on.draw();
  }

  select(vertex: Vertex): void {
    this.selected = vertex;
    const place = placeAt(this.plan, vertex);
    if (place) this.on.reveal(place);
    this.on.draw();
  }

  letGo(): void {
    [this.selected, this.tool] = [undefined, undefined];
    this.sketch.clear();
    this.on.draw();
  }

  /** A tool for areas that is in hand. */
  get sketching(): SketchKind | undefined {
    return this.writable && isSketch(this.tool) ? this.tool : undefined;
  }

  /** A corner of the area; the second of a rectangle finishes it. */
  corner(place: PlanPlace): void {
    this.sketch.add(place);
    if (this.sketching === "rows_rectangle" && this.sketch.corners.length > 1) this.finish();
    else this.on.draw();
  }

  /** A rectangle is dragged from one corner to the other. */
  stretch(from: PlanPlace, to: PlanPlace, done: boolean): void {
    if (this.sketching !== "rows_rectangle") return;
    this.sketch.begin(from);
    this.sketch.lead(to);
    if (done) this.corner(to);
    else this.on.draw();
  }

  /** Takes the area as it is drawn into the plan; the tool is put away. Answers whether it was one. */
  finish(): boolean {
    const kind = this.sketching;
    const drawn = kind && this.sketch.made(kind);
    if (!drawn) return false;
    if (typeof drawn === "string") {
      // The last corner of a rectangle that is not valid was a slip.
      if (kind === "rows_rectangle") this.sketch.drop();
      this.on.draw();
      return false;
    }
    this.sketch.clear();
    this.tool = undefined;
    const at = this.selected ? this.selected.step + 1 : this.plan.maneuvers.length;
    this.selected = { step: at, point: 0 };
    this.change(withNewTask(this.plan, drawn.name, drawn.task, this.speed, at));
    return true;
  }

  /** Somebody clicked beside everything. */
  clicked(place: PlanPlace): void {
    if (this.sketching) return this.corner(place);
    if (this.writable && this.tool && !isSketch(this.tool)) {
      const kind = this.tool;
      // An area is made by one click, and the tool is put away as after one that is drawn: the next click chooses.
      if (kind === "rows") this.tool = undefined;
      return this.add(kind, place);
    }
    this.selected = undefined;
    this.on.draw();
  }

  /** A path that is open goes on; else a maneuver comes after the chosen one, or at the end. */
  add(kind: TaskKind, place: PlanPlace): void {
    const open = this.selected ? this.plan.maneuvers[this.selected.step] : undefined;
    if (kind === "follow_path" && this.selected && open?.task.kind === "follow_path") {
      this.selected = { step: this.selected.step, point: this.selected.point + 1 };
      return this.change(withPoint(this.plan, this.selected, place));
    }
    this.addStep(kind, place);
  }

  addStep(kind: TaskKind, place: PlanPlace): void {
    const { plan } = this;
    const at = this.selected ? this.selected.step + 1 : plan.maneuvers.length;
    this.selected = { step: at, point: 0 };
    this.change(withNew(plan, kind, place, this.speed, at));
  }

  remove(vertex: Vertex, whole: boolean): void {
    const next = whole ? withoutStep(this.plan, vertex.step) : withoutVertex(this.plan, vertex);
    const left = next.maneuvers.length;
    const step = Math.min(vertex.step, left - 1);
    const task = next.maneuvers[step]?.task;
    const points = task ? placesOf(task).length : 0;
    this.selected = left ? { step, point: whole ? 0 : Math.min(vertex.point, points - 1) } : undefined;
    this.change(next);
  }

  /** A vertex is dragged; answers what is drawn meanwhile, or undefined once it is let go. */
  drag(vertex: Vertex, place: PlanPlace, done: boolean): PlanDocument | undefined {
    return this.preview(withPlace(this.plan, vertex, place), done);
  }

  /** A whole maneuver is moved, turned or resized by a grip that was taken at `from`; answers as `drag` does. */
  pull({ kind, step }: Pick<Grip, "kind" | "step">, from: PlanPlace, to: PlanPlace, done: boolean): PlanDocument | undefined {
    const task = this.plan.maneuvers[step]?.task;
    if (kind === "move") return this.preview(withMoved(this.plan, step, from, to), done);
    if (task?.kind !== "rows") return undefined;
    return this.preview(withRows(this.plan, step, kind === "turn" ? rowsTurned(task, turnBetween(task, from, to)) : rowsTo(task, to)), done);
  }

  /** What is dragged is drawn, and counts when it is let go. */
  private preview(next: PlanDocument, done: boolean): PlanDocument | undefined {
    if (!this.writable) return undefined;
    this.dragged = done ? undefined : next;
    if (done) this.change(next);
    return this.dragged;
  }

  /** A vertex in the middle of what follows one. */
  between(after: Vertex, place: PlanPlace): Vertex {
    if (!this.writable) return after;
    const { plan, vertex } = withBetween(this.plan, after, place);
    this.selected = vertex;
    this.change(plan);
    return vertex;
  }

  insert(after: Vertex): void {
    this.between(after, this.placeAfter(after));
  }

  insertPoint(after: Vertex): void {
    this.selected = { step: after.step, point: after.point + 1 };
    this.change(withPoint(this.plan, this.selected, this.placeAfter(after)));
  }

  move(vertex: Vertex, place: PlanPlace): void {
    this.selected = vertex;
    this.change(withPlace(this.plan, vertex, place));
    this.on.reveal(place);
  }

  nudge(north_m: number, east_m: number): boolean {
    const place = this.selected && placeAt(this.plan, this.selected);
    if (!this.selected || !place || !this.writable) return false;
    const { step, point } = this.selected;
    this.change(withPlace(this.plan, this.selected, displaced(place, north_m, east_m)), `nudge ${step} ${point}`);
    return true;
  }

  /** Moves the whole chosen maneuver. */
  nudgeWhole(north_m: number, east_m: number): boolean {
    if (!this.selected || !this.writable) return false;
    const { step } = this.selected;
    this.change(withMovedBy(this.plan, step, [north_m, east_m]), `nudge whole ${step}`);
    return true;
  }

  /** A copy of a maneuver comes after it, so far beside that it is seen, and is chosen. */
  duplicate(step: number, apart_m: number): boolean {
    const next = withCopy(this.plan, step, apart_m);
    if (next === this.plan || !this.writable) return false;
    this.selected = { step: step + 1, point: 0 };
    this.change(next);
    return true;
  }

  /** A maneuver is sailed the other way; answers whether it has one. */
  back(step: number): boolean {
    const next = withBack(this.plan, step);
    if (next === this.plan || !this.writable) return false;
    if (this.selected?.step === step) this.selected = { step, point: lastPoint(next, step) - this.selected.point };
    this.change(next);
    return true;
  }

  /** The whole plan is sailed from its end to its beginning; what is chosen stays chosen. */
  allBack(): boolean {
    if (!this.writable || this.plan.maneuvers.length < 1) return false;
    const next = withAllBack(this.plan);
    if (this.selected) {
      const step = next.maneuvers.length - 1 - this.selected.step;
      this.selected = { step, point: lastPoint(next, step) - this.selected.point };
    }
    this.change(next);
    return true;
  }

  /** Moves a maneuver in the order; what is chosen stays chosen. */
  order(step: number, by: number): void {
    const next = withOrder(this.plan, step, by);
    if (next !== this.plan && this.selected?.step === step) this.selected = { ...this.selected, step: step + by };
    else if (next !== this.plan && this.selected?.step === step + by) this.selected = { ...this.selected, step };
    this.change(next);
  }

  /** Half way to the next place, or a little to the north of the last. */
  private placeAfter(after: Vertex): PlanPlace {
    const all = vertices(this.plan);
    const at = all.findIndex(({ vertex }) => vertex.step === after.step && vertex.point === after.point);
    const [here, next] = [all[at]?.place ?? this.on.centre(), all[at + 1]?.place];
    return next ? middle(here, next) : displaced(here, NEXT_M, 0);
  }
}

function lastPoint(plan: PlanDocument, step: number): number {
  const task = plan.maneuvers[step]?.task;
  return task ? placesOf(task).length - 1 : 0;
}
