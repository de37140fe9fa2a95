// The list of maneuvers and the form of the chosen one. It mirrors the map: all that the map can do is done here by
// keyboard too.

import type { PlanCheck, PlanCost, PlanDocument, PlanPlace, PlanSpeed, PlanStep, SpeedUnit } from "../api/types.gen";
import { kindName, placesOf, type Vertex } from "../state/plan";
import { whyNotReversed } from "../state/wholes";
import { make } from "../ui/dom";
import { createPopupMenu, type MenuItem } from "../ui/popupmenu";
import { checkField, choiceField, numberField, placeFields, rebuilt, textField } from "./fields";
import { wholeKeyOf } from "./toolbar";

/** Points of a path that are shown at once; the others by leafing. */
const POINTS_SHOWN = 40;
const LONGEST_S = 65_535;
const LONGEST_M = 50_000;
const WIDEST_M = 5_000;
const LONGEST_NAME = 60;

export const UNITS: readonly (readonly [SpeedUnit, string])[] = [
  ["mps", "m/s"],
  ["rpm", "rpm"],
  ["percent", "%"],
];

export interface StepsHandlers {
  select(vertex: Vertex): void;
  name(step: number, id: string): void;
  speed(step: number, speed: PlanSpeed): void;
  place(vertex: Vertex, place: PlanPlace): void;
  values(step: number, values: Readonly<Record<string, number | boolean>>): void;
  order(step: number, by: number): void;
  remove(vertex: Vertex, whole: boolean): void;
  /** A new place after this one. */
  insert(after: Vertex): void;
  /** A new point of a path after this one. */
  insertPoint(after: Vertex): void;
  /** A copy after it. */
  duplicate(step: number): void;
  /** Sailed the other way. */
  back(step: number): void;
  /** The whole plan from its end to its beginning. */
  allBack(): void;
  /** Puts the keyboard onto the map. */
  onMap(): void;
}

export interface Steps {
  update(plan: PlanDocument, selected: Vertex | undefined, minutes: boolean): void;
  /** Lengths and problems, which come a moment later. */
  check(check: PlanCheck): void;
  /** Puts the keyboard onto the chosen maneuver. */
  focus(): void;
}

/** Into `list` and `form`. */
export function createSteps(list: HTMLElement, form: HTMLElement, handlers: StepsHandlers): Steps {
  let last: { plan: PlanDocument; selected: Vertex | undefined } | undefined;
  let told: PlanCheck | undefined;
  const menu = createPopupMenu(() => list.querySelector<HTMLElement>('.step[aria-pressed="true"]'));

  const tell = (): void => {
    if (!last || !told) return;
    const [costs, troubles] = [new Map(told.maneuvers.map((leg) => [leg.id, leg.cost])), [...told.problems, ...told.warnings]];
    for (const [index, step] of last.plan.maneuvers.entries()) {
      const row = list.querySelector(`[data-step="${index}"]`);
      const own = troubles.filter((one) => one.maneuver === step.id);
      row?.toggleAttribute("data-bad", told.problems.some((one) => one.maneuver === step.id));
      row?.querySelector(".cost")?.replaceChildren(cost(costs.get(step.id)));
      row?.querySelector(".told")?.replaceChildren(own.map((one) => one.text).join("; "));
    }
  };

  const rowOf = (plan: PlanDocument, step: PlanStep, index: number, chosen: boolean): HTMLElement => {
    const choose = make(
      "button",
      { type: "button", class: "step", "data-key": `step-${step.id}`, "aria-pressed": String(chosen) },
      make("span", { class: "name" }, `${index + 1} ${step.id}`),
      make("span", { class: "dim" }, `${kindName(step.task.kind)} · ${step.speed.value} ${UNITS.find(([unit]) => unit === step.speed.unit)?.[1] ?? ""}`),
      make("span", { class: "cost num" }),
      make("span", { class: "told" }),
    );
    choose.addEventListener("click", () => handlers.select({ step: index, point: 0 }));
    choose.addEventListener("keydown", (event) => {
      const by = event.key === "ArrowUp" ? -1 : event.key === "ArrowDown" ? 1 : 0;
      if (by && event.altKey) handlers.order(index, by);
      else if (by) {
        const next = plan.maneuvers[index + by];
        if (!next) return;
        handlers.select({ step: index + by, point: 0 });
        list.querySelector<HTMLElement>(`[data-step="${index + by}"] .step`)?.focus();
      } else if (event.key === "Delete") handlers.remove({ step: index, point: 0 }, true);
      else {
        const whole = wholeKeyOf(event);
        if (!whole) return;
        handlers[whole](index);
      }
      event.preventDefault();
    });
    const move = (name: string, sign: string, by: number, possible: boolean): HTMLElement => {
      const button = make("button", { type: "button", "data-key": `${name}-${step.id}`, "aria-label": `${name} ${step.id}`, title: `Alt and the arrow do the same` }, sign);
      button.disabled = !possible;
      button.addEventListener("click", () => handlers.order(index, by));
      return button;
    };
    const more = make("button", { type: "button", "data-key": `more-${step.id}`, "aria-label": `More for ${step.id}`, "aria-haspopup": "menu" }, "⋯");
    more.addEventListener("click", () => menu.open(more, step.id, itemsOf(step, index, handlers)));
    const buttons = make("span", { class: "order-buttons" }, move("Earlier", "↑", -1, index > 0), move("Later", "↓", 1, index + 1 < plan.maneuvers.length), more);
    return make("li", { "data-step": String(index) }, choose, buttons);
  };

  const allBack = (): HTMLElement => {
    const button = make("button", { type: "button", "data-key": "all-back", title: "From the last maneuver to the first; paths and rows are sailed backwards too. Shift and R do the same" }, "Reverse the whole plan");
    button.addEventListener("click", () => handlers.allBack());
    return button;
  };

  const formOf = (step: PlanStep, selected: Vertex, minutes: boolean): Node[] => {
    const index = selected.step;
    const set = (name: string) => (value: number | boolean) => handlers.values(index, { [name]: value });
    const { task } = step;
    const name = textField(
      "Name",
      "name",
      step.id,
      (text) => (text.trim() && new TextEncoder().encode(text.trim()).length <= LONGEST_NAME ? { value: text.trim() } : { wrong: `1 to ${LONGEST_NAME} bytes` }),
      (id) => handlers.name(index, id),
    );
    const speed = numberField("Speed", "speed", step.speed.value, 0.01, 1_000, (value) => handlers.speed(index, { ...step.speed, value }));
    const unit = choiceField("Unit", "unit", step.speed.unit, UNITS, (value) => handlers.speed(index, { ...step.speed, unit: value as SpeedUnit }));
    const fields: HTMLElement[] = [name, speed, unit];
    const duration = (seconds: number): HTMLElement => numberField("Duration, s (0: until stopped)", "duration", seconds, 0, LONGEST_S, set("duration_s"), true);
    if (task.kind !== "follow_path") fields.push(...placeFields("place", "", task.at, minutes, (place) => handlers.place({ step: index, point: 0 }, place)));
    if (task.kind === "station_keeping") {
      fields.push(numberField("Radius, m", "radius", task.radius_m, 0, WIDEST_M, set("radius_m")), duration(task.duration_s));
    } else if (task.kind === "loiter") {
      fields.push(numberField("Radius, m", "radius", task.radius_m, 0, WIDEST_M, set("radius_m")), duration(task.duration_s), checkField("Clockwise", "clockwise", task.clockwise, set("clockwise")));
    } else if (task.kind === "rows") {
      fields.push(
        numberField("Bearing, ° true", "bearing", task.bearing_deg, -360, 360, set("bearing_deg")),
        numberField("Length, m", "length", task.length_m, 0.1, LONGEST_M, set("length_m")),
        numberField("Width, m", "width", task.width_m, 0.1, LONGEST_M, set("width_m")),
        numberField("Between rows, m", "step", task.step_m, 0.1, LONGEST_M, set("step_m")),
        numberField("Overrun, m", "overrun", task.curve_offset_m, 0, 255, set("curve_offset_m"), true),
        numberField("Cross angle, °", "cross", task.cross_angle_deg, -80, 80, set("cross_angle_deg")),
        numberField("Alternation, %", "alternation", task.alternation_percent, 0, 100, set("alternation_percent"), true),
        checkField("First turn to the right", "right", task.curve_right, set("curve_right")),
        checkField("Square turns", "square", task.square_curve, set("square_curve")),
      );
    }
    const remove = make("button", { type: "button", class: "danger", "data-key": "remove" }, `Delete ${step.id}`);
    remove.addEventListener("click", () => handlers.remove({ step: index, point: 0 }, true));
    const insert = make("button", { type: "button", "data-key": "insert" }, "Insert a Goto after it");
    insert.addEventListener("click", () => handlers.insert({ step: index, point: task.kind === "follow_path" ? task.points.length - 1 : 0 }));
    const parts: Node[] = [make("h2", { id: "step-title" }, step.id), make("div", { class: "fields" }, ...fields)];
    if (task.kind === "follow_path") parts.push(pointsOf(task.points, selected, minutes));
    return [...parts, make("div", { class: "row" }, insert, remove)];
  };

  const pointsOf = (points: readonly PlanPlace[], selected: Vertex, minutes: boolean): HTMLElement => {
    const from = Math.floor(selected.point / POINTS_SHOWN) * POINTS_SHOWN;
    const rows = points.slice(from, from + POINTS_SHOWN).map((place, offset) => {
      const vertex = { step: selected.step, point: from + offset };
      const number = vertex.point + 1;
      const button = (key: string, label: string, text: string, done: () => void): HTMLElement => {
        const made = make("button", { type: "button", "data-key": `${key}-${vertex.point}`, "aria-label": `${label} point ${number}` }, text);
        made.addEventListener("click", done);
        return made;
      };
      const choose = button("choose", "Choose", String(number), () => handlers.select(vertex));
      choose.setAttribute("aria-pressed", String(vertex.point === selected.point));
      const fields = placeFields(`point-${vertex.point}`, `Point ${number} `, place, minutes, (next) => handlers.place(vertex, next));
      return make("li", { class: "point" }, choose, ...fields, button("after", "Insert after", "+", () => handlers.insertPoint(vertex)), button("without", "Delete", "✕", () => handlers.remove(vertex, false)));
    });
    const leaf = (text: string, to: number): HTMLElement => {
      const made = make("button", { type: "button", "data-key": text }, text);
      made.disabled = to < 0 || to >= points.length;
      made.addEventListener("click", () => handlers.select({ step: selected.step, point: to }));
      return made;
    };
    const leaves = points.length > POINTS_SHOWN ? [make("div", { class: "row" }, leaf("Points before", from - POINTS_SHOWN), leaf("Points after", from + POINTS_SHOWN))] : [];
    return make("section", { "aria-label": `Points of the path: ${points.length}` }, make("ol", { class: "points" }, ...rows), ...leaves);
  };

  return {
    update(plan, selected, minutes) {
      last = { plan, selected };
      const rows = plan.maneuvers.map((step, index) => rowOf(plan, step, index, index === selected?.step));
      const empty = make("p", { class: "empty" }, "No maneuvers yet. Choose a tool above the map and click on the map; or press “Add” beside a tool to put one into the middle of the map and type its place here.");
      const shown = rows.length ? [make("ol", { class: "steps", "aria-label": "Maneuvers" }, ...rows)] : [empty];
      rebuilt(list, ...shown, ...(rows.length > 1 ? [make("div", { class: "row" }, allBack())] : []));
      const step = selected && plan.maneuvers[selected.step];
      rebuilt(form, ...(step ? formOf(step, selected, minutes) : []));
      form.toggleAttribute("hidden", !step);
      tell();
    },
    check(check) {
      told = check;
      tell();
    },
    focus() {
      list.querySelector<HTMLElement>('.step[aria-pressed="true"]')?.focus();
    },
  };
}

/** What can be done with a whole maneuver. */
function itemsOf({ task, id }: PlanStep, step: number, handlers: StepsHandlers): MenuItem[] {
  const point = placesOf(task).length - 1;
  const whyNot = whyNotReversed(task);
  const chosen = (act: () => void) => () => {
    handlers.select({ step, point: 0 });
    act();
  };
  return [
    { text: "Duplicate", keys: "D", act: chosen(() => handlers.duplicate(step)) },
    { text: task.kind === "loiter" ? "Circle the other way round" : "Reverse its way", keys: "R", act: chosen(() => handlers.back(step)), ...(whyNot ? { whyNot } : {}) },
    { text: "Move it with arrow keys", keys: "Ctrl ↑↓←→", leads: true, act: chosen(() => handlers.onMap()) },
    { text: "Insert a Goto after it", act: () => handlers.insert({ step, point }) },
    { text: `Delete ${id}`, keys: "Delete", act: () => handlers.remove({ step, point: 0 }, true) },
    { text: "Reverse the whole plan", keys: "Shift R", act: () => handlers.allBack() },
  ];
}

/** Length and time of a leg. */
function cost(cost: PlanCost | undefined): string {
  return cost ? [lengthText(cost.length_m), durationText(cost.duration_s)].join(" · ") : "";
}

export function lengthText(metres: number | null): string {
  if (metres === null) return "length open";
  return metres < 9_999.5 ? `${metres.toFixed(0)} m` : `${(metres / 1_000).toFixed(1)} km`;
}

export function durationText(seconds: number | null): string {
  if (seconds === null) return "until stopped";
  const whole = Math.round(seconds);
  const [h, min, s] = [Math.floor(whole / 3_600), Math.floor(whole / 60) % 60, whole % 60];
  return h ? `${h} h ${String(min).padStart(2, "0")} min` : `${min} min ${String(s).padStart(2, "0")} s`;
}

export function energyText(joules: number | null): string {
  return joules === null ? "energy open" : `${(joules / 3_600).toFixed(1)} Wh`;
}
