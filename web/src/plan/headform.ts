// What a plan is called, for whom, and how it is written: the form above its maneuvers.

import type { PlanDocument } from "../api/types.gen";
import { withSpeed } from "../state/plan";
import { make } from "../ui/dom";
import { hexAddress } from "../ui/format";
import { t } from "../words/words";
import type { PlanEditing } from "./editing";
import { checkField, choiceField, rebuilt, textField } from "./fields";
import type { SpeedView } from "./speeds";

const MOST_NAME_BYTES = 60;
const MOST_TEXT = 500;

export interface HeadNeeds {
  readonly editing: PlanEditing;
  /** Names that people gave vessels, by address. */
  readonly names: Readonly<Record<string, string>>;
  /** Of the plan's requests. */
  readonly path: string;
  readonly speeds: SpeedView;
  /** Whether coordinates have minutes. */
  minutes(): boolean;
  setMinutes(whether: boolean): void;
}

export function createHeadForm(root: HTMLElement, needs: HeadNeeds): { update(): void } {
  const { editing, path } = needs;
  const link = (format: string, label: string): HTMLElement => make("a", { class: "button", href: `${path}/export?format=${format}`, download: "", "data-key": `export-${format}` }, label);
  return {
    update() {
      const files = make("span", { class: "buttons", role: "group", "aria-label": t("Download") }, link("imc", "IMC JSON"), link("geojson", "GeoJSON"), link("gpx", "GPX"));
      rebuilt(
        root,
        make("div", { class: "fields" }, ...fields(needs, editing.plan)),
        make("div", { class: "row" }, make("span", { class: "download" }, `${t("Download")} `, files)),
      );
      if (!editing.writable) for (const one of root.querySelectorAll<HTMLInputElement>("input, select:not([data-key=minutes])")) one.disabled = true;
    },
  };
}

function fields({ editing, names, speeds, minutes, setMinutes }: HeadNeeds, now: PlanDocument): HTMLElement[] {
  const change = (next: PlanDocument): void => editing.change(next);
  const bytes = (text: string): number => new TextEncoder().encode(text).length;
  const isName = (text: string): boolean => text !== "" && bytes(text) <= MOST_NAME_BYTES;
  const vessel = now.vessel === null ? "" : String(now.vessel);
  const vessels: (readonly [string, string])[] = [["", t("any vessel")], ...Object.entries(names)];
  if (vessel && !(vessel in names)) vessels.push([vessel, hexAddress(Number(vessel))]);
  const speed = speeds.fields({ label: t("Speed of all"), unitLabel: t("Unit of all"), key: "speed-all", unitKey: "unit-all", speed: editing.speed, told: (next) => change(withSpeed(editing.plan, next)) });
  return [
    textField(t("Name of the plan"), "plan-name", now.name, (text) => (isName(text.trim()) ? { value: text.trim() } : { wrong: t("1 to {most} bytes", { most: MOST_NAME_BYTES }) }), (name) => change({ ...now, name })),
    textField(t("What for"), "plan-text", now.description, (value) => (value.length <= MOST_TEXT ? { value } : { wrong: t("up to {most} characters", { most: MOST_TEXT }) }), (description) => change({ ...now, description })),
    choiceField(t("For"), "plan-vessel", vessel, vessels, (value) => change({ ...now, vessel: value ? Number(value) : null })),
    choiceField(t("Coordinates"), "minutes", minutes() ? "yes" : "no", [["no", t("decimal degrees")], ["yes", t("degrees and minutes")]], (value) => setMinutes(value === "yes")),
    ...(now.maneuvers.length ? speed : []),
    checkField(t("Repeat"), "plan-repeat", now.repeat, (repeat) => change({ ...now, repeat })),
  ];
}
