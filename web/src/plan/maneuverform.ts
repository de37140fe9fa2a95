// The form of the chosen maneuver: name, speed, places, and what its kind has besides.

import type { PlanPlace, PlanStep } from "../api/types.gen";
import type { Task, Vertex } from "../state/plan";
import { make } from "../ui/dom";
import { t } from "../words/words";
import { checkField, minutesField, numberField, placeFields, textField } from "./fields";
import type { SpeedView } from "./speeds";
import type { StepsHandlers } from "./steps";

/** Points of a path that are shown at once; the others by leafing. */
const POINTS_SHOWN = 40;
const LONGEST_S = 65_535;
const LONGEST_M = 50_000;
const WIDEST_M = 5_000;
const LONGEST_NAME = 60;

type SetValue = (name: string) => (value: number | boolean) => void;

export class ManeuverForm {
  constructor(private readonly speeds: SpeedView, private readonly handlers: StepsHandlers) {}

  parts(step: PlanStep, selected: Vertex, minutes: boolean): Node[] {
    const { handlers } = this;
    const { step: index } = selected;
    const { task } = step;
    const fields = [this.name(step, index), ...this.speeds.fields({ label: t("Speed"), unitLabel: t("Unit"), key: "speed", unitKey: "unit", speed: step.speed, told: (next) => handlers.speed(index, next) })];
    if (task.kind !== "follow_path") fields.push(...placeFields("place", "", task.at, minutes, (place) => handlers.place({ step: index, point: 0 }, place)));
    fields.push(...fieldsOf(step, (name) => (value) => handlers.values(index, { [name]: value })));
    const remove = make("button", { type: "button", class: "danger", "data-key": "remove" }, t("Delete {id}", { id: step.id }));
    remove.addEventListener("click", () => handlers.remove({ step: index, point: 0 }, true));
    const insert = make("button", { type: "button", "data-key": "insert" }, t("Insert a Goto after it"));
    insert.addEventListener("click", () => handlers.insert({ step: index, point: task.kind === "follow_path" ? task.points.length - 1 : 0 }));
    const points = task.kind === "follow_path" ? [this.points(task.points, selected, minutes)] : [];
    return [make("h2", { id: "step-title" }, step.id), make("div", { class: "fields" }, ...fields), ...points, make("div", { class: "row" }, insert, remove)];
  }

  private name(step: PlanStep, index: number): HTMLElement {
    const read = (text: string) => (text.trim() && new TextEncoder().encode(text.trim()).length <= LONGEST_NAME ? { value: text.trim() } : { wrong: t("1 to {most} bytes", { most: LONGEST_NAME }) });
    return textField(t("Name"), "name", step.id, read, (id) => this.handlers.name(index, id));
  }

  private points(points: readonly PlanPlace[], selected: Vertex, minutes: boolean): HTMLElement {
    const from = Math.floor(selected.point / POINTS_SHOWN) * POINTS_SHOWN;
    const rows = points.slice(from, from + POINTS_SHOWN).map((place, offset) => this.point(place, { step: selected.step, point: from + offset }, selected, minutes));
    const leaf = (text: string, to: number): HTMLElement => {
      const made = make("button", { type: "button", "data-key": text }, text);
      made.disabled = to < 0 || to >= points.length;
      made.addEventListener("click", () => this.handlers.select({ step: selected.step, point: to }));
      return made;
    };
    const leaves = points.length > POINTS_SHOWN ? [make("div", { class: "row" }, leaf(t("Points before"), from - POINTS_SHOWN), leaf(t("Points after"), from + POINTS_SHOWN))] : [];
    return make("section", { "aria-label": t("Points of the path: {n}", { n: points.length }) }, make("ol", { class: "points" }, ...rows), ...leaves);
  }

  private point(place: PlanPlace, vertex: Vertex, selected: Vertex, minutes: boolean): HTMLElement {
    const { handlers } = this;
    const number = vertex.point + 1;
    const button = (key: string, label: string, text: string, done: () => void): HTMLElement => {
      const made = make("button", { type: "button", "data-key": `${key}-${vertex.point}`, "aria-label": t("{action} point {number}", { action: label, number }) }, text);
      made.addEventListener("click", done);
      return made;
    };
    const choose = button("choose", t("Choose"), String(number), () => handlers.select(vertex));
    choose.setAttribute("aria-pressed", String(vertex.point === selected.point));
    const fields = placeFields(`point-${vertex.point}`, `${t("Point {number}", { number })} `, place, minutes, (next) => handlers.place(vertex, next));
    return make("li", { class: "point" }, choose, ...fields, button("after", t("Insert after"), "+", () => handlers.insertPoint(vertex)), button("without", t("Delete"), "✕", () => handlers.remove(vertex, false)));
  }
}

/** What a kind of maneuver has besides name, speed and places. */
function fieldsOf({ task }: PlanStep, set: SetValue): HTMLElement[] {
  const duration = (seconds: number): HTMLElement => minutesField(t("Duration, min (0: until stopped)"), "duration", seconds, LONGEST_S, set("duration_s"));
  switch (task.kind) {
    case "station_keeping":
      return [numberField(t("Radius, m"), "radius", task.radius_m, 0, WIDEST_M, set("radius_m")), duration(task.duration_s)];
    case "loiter":
      return [numberField(t("Radius, m"), "radius", task.radius_m, 0, WIDEST_M, set("radius_m")), duration(task.duration_s), checkField(t("Clockwise"), "clockwise", task.clockwise, set("clockwise"))];
    case "rows":
      return rowsFields(task, set);
    default:
      return [];
  }
}

function rowsFields(task: Task<"rows">, set: SetValue): HTMLElement[] {
  return [
    numberField(t("Bearing, ° true"), "bearing", task.bearing_deg, -360, 360, set("bearing_deg")),
    numberField(t("Length, m"), "length", task.length_m, 0.1, LONGEST_M, set("length_m")),
    numberField(t("Width, m"), "width", task.width_m, 0.1, LONGEST_M, set("width_m")),
    numberField(t("Between rows, m"), "step", task.step_m, 0.1, LONGEST_M, set("step_m")),
    numberField(t("Overrun, m"), "overrun", task.curve_offset_m, 0, 255, set("curve_offset_m"), true),
    numberField(t("Cross angle, °"), "cross", task.cross_angle_deg, -80, 80, set("cross_angle_deg")),
    numberField(t("Alternation, %"), "alternation", task.alternation_percent, 0, 100, set("alternation_percent"), true),
    checkField(t("First turn to the right"), "right", task.curve_right, set("curve_right")),
    checkField(t("Square turns"), "square", task.square_curve, set("square_curve")),
  ];
}
