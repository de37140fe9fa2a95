// The tools of the plan editor: what a click on the map does, back and forth, adding by keyboard, and the keys for it.

import type { PlanPlace } from "../api/types.gen";
import { KIND_WORDS, KINDS, type TaskKind } from "../state/plan";
import { make, setAttribute } from "../ui/dom";
import { t } from "../words/words";
import type { PlanEditing, Tool } from "./editing";
import { SKETCHES } from "./sketching";

/** Arrow keys move a vertex by this; with Shift by ten times as much, m. */
const NUDGE_M = 1;
const ARROWS: Readonly<Record<string, readonly [number, number]>> = { ArrowUp: [1, 0], ArrowDown: [-1, 0], ArrowRight: [0, 1], ArrowLeft: [0, -1] };

export interface ToolBar {
  update(): void;
}

export interface ToolBarHandlers {
  /** Something is to be added by keyboard. */
  added(kind: TaskKind): void;
  /** An area is drawn from now on, by pointer or keyboard on the map. */
  draws(): void;
  /** The tool that finds routes on the chart. */
  readonly route: { readonly open: boolean; toggle(): void };
}

export function createToolBar(root: HTMLElement, editing: PlanEditing, { added, draws, route }: ToolBarHandlers): ToolBar {
  if (!editing.writable) {
    root.append(make("p", { class: "dim" }, t("You may look at this plan, not change it.")));
    return { update: () => undefined };
  }
  const tool = (kind: Tool | undefined, label: string): HTMLButtonElement => {
    const made = make("button", { type: "button", "data-tool": kind ?? "", "aria-pressed": "false" }, label);
    made.addEventListener("click", () => {
      editing.press(kind);
      if (editing.sketching) draws();
    });
    return made;
  };
  const places = [tool(undefined, t("Choose")), ...KINDS.map(([kind]) => tool(kind, KIND_WORDS[kind]))];
  const areas = SKETCHES.map(([kind, label]) => tool(kind, label));
  const tools = [...places, ...areas];
  const way = make("button", { type: "button", "data-tool": "route", "aria-pressed": "false", title: t("The shortest way that the chart calls safe") }, t("Route …"));
  way.addEventListener("click", () => route.toggle());
  const undo = make("button", { type: "button", "aria-keyshortcuts": "Control+Z", title: t("Ctrl and Z") }, t("Undo"));
  const redo = make("button", { type: "button", "aria-keyshortcuts": "Control+Y", title: t("Ctrl and Y") }, t("Redo"));
  undo.addEventListener("click", () => editing.travel(true));
  redo.addEventListener("click", () => editing.travel(false));
  const kind = make("select", { "aria-label": t("What to add") }, ...KINDS.map(([name]) => make("option", { value: name }, KIND_WORDS[name])));
  const add = make("button", { type: "button", title: t("After the chosen maneuver, in the middle of the map") }, t("Add"));
  add.addEventListener("click", () => added(kind.value as TaskKind));
  root.append(
    make("span", { class: "buttons", role: "group", "aria-label": t("What a click on the map does") }, ...places, way),
    make("span", { class: "buttons", role: "group", "aria-label": t("Back and forth") }, undo, redo),
    make("span", { class: "buttons", role: "group", "aria-label": t("Draw an area") }, ...areas),
    make("span", { class: "buttons adding", role: "group", "aria-label": t("Add by keyboard") }, kind, add),
  );
  return {
    update() {
      setAttribute(undo, "disabled", editing.canUndo ? null : "");
      setAttribute(redo, "disabled", editing.canRedo ? null : "");
      setAttribute(way, "aria-pressed", String(route.open));
      for (const button of tools) setAttribute(button, "aria-pressed", String(!(route.open && editing.tool === undefined) && (button.dataset["tool"] || undefined) === editing.tool));
    },
  };
}

/** Keys of the whole page: save, undo, redo. */
export function pageKeys(editing: PlanEditing, save: () => void): void {
  document.addEventListener("keydown", (event) => {
    if (!(event.ctrlKey || event.metaKey) || event.altKey) return;
    const { target } = event;
    // A text that is being typed is taken back by the browser.
    if (target instanceof HTMLInputElement && target.type === "text" && target.value !== target.defaultValue) return;
    const key = event.key.toLowerCase();
    if (key === "s") save();
    else if (key === "y" || (key === "z" && event.shiftKey)) editing.travel(false);
    else if (key === "z") editing.travel(true);
    else return;
    event.preventDefault();
  });
}

/** What the keys of the map want to know of it. */
export interface MapPlaces {
  centre(): PlanPlace;
  /** What is told apart there, m. */
  apart(): number;
}

/** Keys of the map: move what is chosen, take it away, let go; corners of an area. Before the map's own. */
export function mapKeys(map: HTMLElement, editing: PlanEditing, places: MapPlaces): void {
  map.addEventListener("keydown", (event) => {
    if (event.key === "Escape") editing.letGo();
    else if (editing.sketching && event.key === "Enter") editing.corner(places.centre());
    else if (editing.sketching && event.key === "Backspace") editing.travel(true);
    else if (editing.sketching) return;
    else if (event.key === "Delete" && editing.selected && editing.writable) editing.remove(editing.selected, false);
    else if (!arrow(event, editing) && !(editing.selected && wholeKey(event, editing, editing.selected.step, places.apart()))) return;
    event.preventDefault();
    event.stopPropagation();
  }, { capture: true });
}

/** Arrows move the chosen place, with Ctrl its whole maneuver. */
function arrow(event: KeyboardEvent, editing: PlanEditing): boolean {
  const [north, east] = ARROWS[event.key] ?? [0, 0];
  if (!north && !east) return false;
  const by = NUDGE_M * (event.shiftKey ? 10 : 1);
  return event.ctrlKey || event.metaKey ? editing.nudgeWhole(north * by, east * by) : editing.nudge(north * by, east * by);
}

/** Letters that copy a maneuver and turn it back, or with Shift the whole plan; answers whether it was one. */
export function wholeKey(event: KeyboardEvent, editing: Pick<PlanEditing, "duplicate" | "back" | "allBack">, step: number, apart_m: number): boolean {
  switch (wholeKeyOf(event)) {
    case "duplicate":
      return editing.duplicate(step, apart_m);
    case "back":
      return editing.back(step);
    case "allBack":
      return editing.allBack();
    case undefined:
      return false;
  }
}

/** What a letter asks for; Shift is held for the whole plan, not locked. */
export function wholeKeyOf({ key, shiftKey, ctrlKey, metaKey, altKey }: KeyboardEvent): "duplicate" | "back" | "allBack" | undefined {
  if (ctrlKey || metaKey || altKey) return undefined;
  const letter = key.toLowerCase();
  if (letter === "r") return shiftKey ? "allBack" : "back";
  return letter === "d" && !shiftKey ? "duplicate" : undefined;
}
