// The table of parameters: a section for each entity, a row for each parameter with the place to type.

import type { EntityReport, VesselParameters } from "../api/types.gen";
import { make, setAttribute, setText } from "../ui/dom";
import { age } from "../ui/format";
import { t } from "../words/words";
import { type Outcome, OUTCOMES, type Row } from "./model";

interface Shown {
  readonly root: HTMLTableRowElement;
  readonly input: HTMLInputElement;
  readonly value: HTMLElement;
  readonly marks: HTMLElement;
  readonly note: HTMLElement;
}

interface Part {
  readonly root: HTMLElement;
  readonly told: HTMLElement;
  readonly rows: ReadonlyMap<string, Shown>;
}

export interface ParameterTable {
  /** Draws what the vessel told, again where other parameters are there than before. */
  fill(told: VesselParameters, rows: readonly Row[]): void;
  /** Brings texts and states up to date. */
  update(rows: readonly Row[], shown: ReadonlySet<string>, outcomes: ReadonlyMap<string, Outcome>, may: boolean): void;
  ages(told: VesselParameters, nowUs: number): void;
  focus(key: string): void;
}

/** `typed` is told what somebody types, and null where they take it back. */
export function createTable(root: HTMLElement, typed: (key: string, text: string | null) => void): ParameterTable {
  return new Table(root, typed);
}

class Table implements ParameterTable {
  private readonly parts = new Map<string, Part>();
  private drawn = "";

  constructor(private readonly root: HTMLElement, private readonly typed: (key: string, text: string | null) => void) {}

  fill(told: VesselParameters, rows: readonly Row[]): void {
    const now = JSON.stringify(told.entities.map(({ entity, left_out, parameters }) => [entity, left_out, parameters.map(({ name, about }) => [name, about])]));
    if (now === this.drawn) return;
    this.drawn = now;
    this.parts.clear();
    told.entities.forEach((one, index) => this.parts.set(one.entity, this.section(one, rows.filter((row) => row.entity === one.entity), index)));
    this.root.replaceChildren(...[...this.parts.values()].map((part) => part.root));
  }

  update(rows: readonly Row[], shown: ReadonlySet<string>, outcomes: ReadonlyMap<string, Outcome>, may: boolean): void {
    const seen = new Set<string>();
    for (const row of rows) {
      const place = this.parts.get(row.entity)?.rows.get(row.key);
      if (!place) continue;
      setAttribute(place.root, "hidden", shown.has(row.key) ? null : "");
      if (shown.has(row.key)) seen.add(row.entity);
      drawRow(place, row, outcomes.get(row.key), may);
    }
    for (const [entity, part] of this.parts) setAttribute(part.root, "hidden", seen.has(entity) ? null : "");
  }

  ages(told: VesselParameters, nowUs: number): void {
    for (const { entity, time_us } of told.entities) {
      const part = this.parts.get(entity);
      if (part) setText(part.told, t("reported {age} ago", { age: age(Math.max(0, (nowUs - time_us) / 1e6)) }));
    }
  }

  focus(key: string): void {
    for (const part of this.parts.values()) part.rows.get(key)?.input.focus();
  }

  private section({ entity, left_out }: EntityReport, rows: readonly Row[], part: number): Part {
    const shown = new Map(rows.map((row, index) => [row.key, this.line(row, `param-${part}-${index}`)]));
    const told = make("span", { class: "dim num" });
    const head = make("tr", {}, ...[t("Parameter"), t("Value"), t("Allowed"), t("Default"), t("Differs")].map((text) => make("th", { scope: "col" }, text)));
    const id = `param-part-${part}`;
    const more = left_out ? [make("p", { class: "note warn" }, t("{n} more are not shown: they are too many.", { n: left_out }))] : [];
    const none = rows.length ? [] : [make("p", { class: "dim" }, t("It has no parameters."))];
    const table = rows.length ? [make("table", { class: "params", "aria-labelledby": id }, make("thead", {}, head), make("tbody", {}, ...[...shown.values()].map((one) => one.root)))] : [];
    return { root: make("section", { "aria-labelledby": id }, make("h3", {}, make("span", { id }, entity), told), ...none, ...more, ...table), told, rows: shown };
  }

  private line(row: Row, id: string): Shown {
    const { about, name } = row.told;
    const input = this.field(row, id);
    const value = make("span", { class: "num now" });
    const marks = make("span", { class: "marks" });
    const note = make("p", { class: "param-note", id: `${id}-note` });
    const { range, unit } = row.shown;
    const root = make(
      "tr",
      {},
      make("th", { scope: "row" }, make("span", { class: "param-name" }, name), make("span", { class: "dim doc" }, about ? about.doc : t("no description: not a parameter known to Lutra")), note),
      make("td", {}, make("span", { class: "param-value" }, input, make("span", { class: "unit" }, unit)), value),
      make("td", { class: "dim" }, about?.live === false ? t("in its file only") : range || "—"),
      make("td", { class: "num dim" }, about ? row.shown.default : "—"),
      make("td", {}, marks),
    );
    return { root, input, value, marks, note };
  }

  /** The place to type, with keys from row to row. */
  private field({ key, entity, told: { about, name } }: Row, id: string): HTMLInputElement {
    const input = make("input", { type: "text", id, autocomplete: "off", spellcheck: "false", maxlength: "1000", "aria-label": t("{name} of {entity}", { name, entity }), "aria-describedby": `${id}-note`, ...(about?.items === 1 ? { inputmode: "decimal" } : {}) });
    input.addEventListener("input", () => this.typed(key, input.value));
    input.addEventListener("keydown", (event) => {
      if (event.key === "Escape") this.typed(key, null);
      else if (event.key === "Enter" || event.key === "ArrowDown") this.step(input, 1);
      else if (event.key === "ArrowUp") this.step(input, -1);
      else return;
      event.preventDefault();
    });
    return input;
  }

  private step(from: HTMLInputElement, by: number): void {
    const all = [...this.root.querySelectorAll<HTMLInputElement>("tr:not([hidden]) input:not([readonly])")].filter((one) => one.offsetParent !== null);
    const next = all[all.indexOf(from) + by];
    next?.focus();
    next?.select();
  }
}

/** Brings the texts and the state of a row up to date. */
function drawRow(place: Shown, row: Row, outcome: Outcome | undefined, may: boolean): void {
  const { told, edit } = row;
  const text = edit ?? row.shown.value;
  if (place.input.value !== text) place.input.value = text;
  place.input.readOnly = !may || told.about?.live === false || told.cut;
  place.input.title = told.cut ? t("Too long to be changed here.") : told.about?.live === false ? t("It is set in the vessel's configuration file only; change it there and start the vessel again.") : "";
  setAttribute(place.input, "aria-invalid", row.problem ? "true" : null);
  setText(place.value, edit === undefined ? (row.shown.value === told.value ? "" : `= ${told.value} ${told.about?.unit ?? ""}`) : t("now {value}", { value: row.shown.value }));
  const marks = [row.unsaved ? t("saved {value}", { value: String(row.shown.saved) }) : "", row.changed ? t("default") : ""].filter(Boolean);
  setText(place.marks, marks.map((mark) => `≠ ${mark}`).join("\n"));
  setText(place.note, row.problem || (outcome ? `${OUTCOMES[outcome.kind]}${outcome.text ? `: ${outcome.text}` : ""}` : ""));
  setAttribute(place.root, "data-state", row.problem ? "wrong" : outcome ? outcome.kind : edit !== undefined ? "edited" : null);
}
