// The list of maneuvers and the form of the chosen one. It mirrors the map: all that the map can do is done here by
// keyboard too.

import type { PlanCheck, PlanCost, PlanDocument, PlanPlace, PlanSpeed, PlanStep } from "../api/types.gen";
import { KIND_WORDS, placesOf, type Vertex } from "../state/plan";
import { troubleText } from "../state/plantrouble";
import { whyNotReversed } from "../state/wholes";
import { make } from "../ui/dom";
import { createPopupMenu, type MenuItem } from "../ui/popupmenu";
import { t } from "../words/words";
import { rebuilt } from "./fields";
import { ManeuverForm } from "./maneuverform";
import type { SpeedView } from "./speeds";
import { wholeKeyOf } from "./toolbar";

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
export function createSteps(list: HTMLElement, form: HTMLElement, speeds: SpeedView, handlers: StepsHandlers): Steps {
  return new StepList(list, form, speeds, handlers);
}

class StepList implements Steps {
  private last: { plan: PlanDocument; selected: Vertex | undefined } | undefined;
  private told: PlanCheck | undefined;
  private readonly menu = createPopupMenu(() => this.list.querySelector<HTMLElement>('.step[aria-pressed="true"]'));
  private readonly maneuver: ManeuverForm;

  constructor(private readonly list: HTMLElement, private readonly form: HTMLElement, private readonly speeds: SpeedView, private readonly handlers: StepsHandlers) {
    this.maneuver = new ManeuverForm(speeds, handlers);
  }

  update(plan: PlanDocument, selected: Vertex | undefined, minutes: boolean): void {
    this.last = { plan, selected };
    const rows = plan.maneuvers.map((step, index) => this.row(plan, step, index, index === selected?.step));
    const empty = make("p", { class: "empty" }, t("No maneuvers yet. Choose a tool above the map and click on the map; or press “Add” beside a tool to put one into the middle of the map and type its place here."));
    const shown = rows.length ? [make("ol", { class: "steps", "aria-label": t("Maneuvers") }, ...rows)] : [empty];
    rebuilt(this.list, ...shown, ...(rows.length > 1 ? [make("div", { class: "row" }, this.allBack())] : []));
    const step = selected && plan.maneuvers[selected.step];
    rebuilt(this.form, ...(step ? this.maneuver.parts(step, selected, minutes) : []));
    this.form.toggleAttribute("hidden", !step);
    this.tell();
  }

  check(check: PlanCheck): void {
    this.told = check;
    this.tell();
  }

  focus(): void {
    this.list.querySelector<HTMLElement>('.step[aria-pressed="true"]')?.focus();
  }

  /** Lengths and problems of the rows. */
  private tell(): void {
    const { last, told } = this;
    if (!last || !told) return;
    const [costs, troubles] = [new Map(told.maneuvers.map((leg) => [leg.id, leg.cost])), [...told.problems, ...told.warnings]];
    for (const [index, step] of last.plan.maneuvers.entries()) {
      const row = this.list.querySelector(`[data-step="${index}"]`);
      const own = troubles.filter((one) => one.maneuver === step.id);
      row?.toggleAttribute("data-bad", told.problems.some((one) => one.maneuver === step.id));
      row?.querySelector(".cost")?.replaceChildren(cost(costs.get(step.id)));
      row?.querySelector(".told")?.replaceChildren(own.map(troubleText).join("; "));
    }
  }

  private row(plan: PlanDocument, step: PlanStep, index: number, chosen: boolean): HTMLElement {
    const { handlers, menu } = this;
    const choose = make(
      "button",
      { type: "button", class: "step", "data-key": `step-${step.id}`, "aria-pressed": String(chosen) },
      make("span", { class: "name" }, `${index + 1} ${step.id}`),
      make("span", { class: "dim" }, `${KIND_WORDS[step.task.kind]} · ${this.speeds.text(step.speed)}`),
      make("span", { class: "cost num" }),
      make("span", { class: "told" }),
    );
    choose.addEventListener("click", () => handlers.select({ step: index, point: 0 }));
    choose.addEventListener("keydown", (event) => this.key(event, plan, index));
    const move = (name: string, sign: string, by: number, possible: boolean): HTMLElement => {
      const button = make("button", { type: "button", "data-key": `${name}-${step.id}`, "aria-label": `${name} ${step.id}`, title: t("Alt and the arrow do the same") }, sign);
      button.disabled = !possible;
      button.addEventListener("click", () => handlers.order(index, by));
      return button;
    };
    const more = make("button", { type: "button", "data-key": `more-${step.id}`, "aria-label": t("More for {id}", { id: step.id }), "aria-haspopup": "menu" }, "⋯");
    more.addEventListener("click", () => menu.open(more, step.id, itemsOf(step, index, handlers)));
    const buttons = make("span", { class: "order-buttons" }, move(t("Earlier"), "↑", -1, index > 0), move(t("Later"), "↓", 1, index + 1 < plan.maneuvers.length), more);
    return make("li", { "data-step": String(index) }, choose, buttons);
  }

  private key(event: KeyboardEvent, plan: PlanDocument, index: number): void {
    const { handlers } = this;
    const by = event.key === "ArrowUp" ? -1 : event.key === "ArrowDown" ? 1 : 0;
    if (by && event.altKey) handlers.order(index, by);
    else if (by) {
      const next = plan.maneuvers[index + by];
      if (!next) return;
      handlers.select({ step: index + by, point: 0 });
      this.list.querySelector<HTMLElement>(`[data-step="${index + by}"] .step`)?.focus();
    } else if (event.key === "Delete") handlers.remove({ step: index, point: 0 }, true);
    else {
      const whole = wholeKeyOf(event);
      if (!whole) return;
      handlers[whole](index);
    }
    event.preventDefault();
  }

  private allBack(): HTMLElement {
    const button = make("button", { type: "button", "data-key": "all-back", title: t("From the last maneuver to the first; paths and rows are sailed backwards too. Shift and R do the same") }, t("Reverse the whole plan"));
    button.addEventListener("click", () => this.handlers.allBack());
    return button;
  }
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
    { text: t("Duplicate"), keys: "D", act: chosen(() => handlers.duplicate(step)) },
    { text: task.kind === "loiter" ? t("Circle the other way round") : t("Reverse its way"), keys: "R", act: chosen(() => handlers.back(step)), ...(whyNot ? { whyNot } : {}) },
    { text: t("Move it with arrow keys"), keys: "Ctrl ↑↓←→", leads: true, act: chosen(() => handlers.onMap()) },
    { text: t("Insert a Goto after it"), act: () => handlers.insert({ step, point }) },
    { text: t("Delete {id}", { id }), keys: "Delete", act: () => handlers.remove({ step, point: 0 }, true) },
    { text: t("Reverse the whole plan"), keys: "Shift R", act: () => handlers.allBack() },
  ];
}

/** Length and time of a leg. */
function cost(cost: PlanCost | undefined): string {
  return cost ? [lengthText(cost.length_m), durationText(cost.duration_s)].join(" · ") : "";
}

export function lengthText(metres: number | null): string {
  if (metres === null) return t("length unknown");
  return metres < 9_999.5 ? `${metres.toFixed(0)} m` : `${(metres / 1_000).toFixed(1)} km`;
}

export function durationText(seconds: number | null): string {
  if (seconds === null) return t("until stopped");
  const whole = Math.round(seconds);
  const [h, min, s] = [Math.floor(whole / 3_600), Math.floor(whole / 60) % 60, whole % 60];
  return h ? `${h} h ${String(min).padStart(2, "0")} min` : `${min} min ${String(s).padStart(2, "0")} s`;
}

export function energyText(joules: number | null): string {
  return joules === null ? t("energy unknown") : `${(joules / 3_600).toFixed(1)} Wh`;
}
