// What a plan is called, for whom, and how it is written: the form above its maneuvers.

import type { PlanDocument, SpeedUnit } from "../api/types.gen";
import { withSpeed } from "../state/plan";
import { make } from "../ui/dom";
import { hexAddress } from "../ui/format";
import type { PlanEditing } from "./editing";
import { checkField, choiceField, numberField, rebuilt, textField } from "./fields";
import { UNITS } from "./steps";

const MOST_NAME_BYTES = 60;
const MOST_TEXT = 500;

export interface HeadNeeds {
  readonly editing: PlanEditing;
  /** Names that people gave vessels, by address. */
  readonly names: Readonly<Record<string, string>>;
  /** Of the plan's requests. */
  readonly path: string;
  /** Whether coordinates have minutes. */
  minutes(): boolean;
  setMinutes(whether: boolean): void;
}

export function createHeadForm(root: HTMLElement, needs: HeadNeeds): { update(): void } {
  const { editing, path } = needs;
  const link = (format: string, label: string): HTMLElement => make("a", { class: "button", href: `${path}/export?format=${format}`, download: "", "data-key": `export-${format}` }, label);
  return {
    update() {
      const files = make("span", { class: "buttons", role: "group", "aria-label": "Download" }, link("imc", "IMC JSON"), link("geojson", "GeoJSON"), link("gpx", "GPX"));
      rebuilt(
        root,
        make("div", { class: "fields" }, ...fields(needs, editing.plan)),
        make("div", { class: "row" }, make("span", { class: "download" }, "Download ", files)),
      );
      if (!editing.writable) for (const one of root.querySelectorAll<HTMLInputElement>("input, select:not([data-key=minutes])")) one.disabled = true;
    },
  };
}

function fields({ editing, names, minutes, setMinutes }: HeadNeeds, now: PlanDocument): HTMLElement[] {
  const change = (next: PlanDocument): void => editing.change(next);
  const bytes = (text: string): number => new TextEncoder().encode(text).length;
  const isName = (text: string): boolean => text !== "" && bytes(text) <= MOST_NAME_BYTES;
  const vessel = now.vessel === null ? "" : String(now.vessel);
  const vessels: (readonly [string, string])[] = [["", "any vessel"], ...Object.entries(names)];
  if (vessel && !(vessel in names)) vessels.push([vessel, hexAddress(Number(vessel))]);
  const { speed } = editing;
  const speeds = [
    numberField("Speed of all", "speed-all", speed.value, 0.01, 1_000, (value) => change(withSpeed(editing.plan, { value, unit: speed.unit }))),
    choiceField("Unit of all", "unit-all", speed.unit, UNITS, (value) => change(withSpeed(editing.plan, { value: speed.value, unit: value as SpeedUnit }))),
  ];
  return [
    textField("Name of the plan", "plan-name", now.name, (text) => (isName(text.trim()) ? { value: text.trim() } : { wrong: `1 to ${MOST_NAME_BYTES} bytes` }), (name) => change({ ...now, name })),
    textField("What for", "plan-text", now.description, (value) => (value.length <= MOST_TEXT ? { value } : { wrong: `up to ${MOST_TEXT} letters` }), (description) => change({ ...now, description })),
    choiceField("For", "plan-vessel", vessel, vessels, (value) => change({ ...now, vessel: value ? Number(value) : null })),
    choiceField("Coordinates", "minutes", minutes() ? "yes" : "no", [["no", "decimal degrees"], ["yes", "degrees and minutes"]], (value) => setMinutes(value === "yes")),
    ...(now.maneuvers.length ? speeds : []),
    checkField("Repeat", "plan-repeat", now.repeat, (repeat) => change({ ...now, repeat })),
  ];
}
