// The table of parameters: a section for each entity, a row for each parameter with the place to type.

import type { EntityTold, VesselParameters } from "../api/types.gen";
import { make, setAttribute, setText } from "../ui/dom";
import { age } from "../ui/format";
import { type Outcome, rangeOf, type Row } from "./model";

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
  /** Draws what the vessel told, anew where other parameters are there than before. */
  fill(told: VesselParameters, rows: readonly Row[]): void;
  /** Brings texts and states up to date. */
  update(rows: readonly Row[], shown: ReadonlySet<string>, outcomes: ReadonlyMap<string, Outcome>, may: boolean): void;
  ages(told: VesselParameters, nowUs: number): void;
  focus(key: string): void;
}

/** `typed` is told what somebody types, and null where they take it back. */
export function createTable(root: HTMLElement, typed: (key: string, text: string | null) => void): ParameterTable {
  const parts = new Map<string, Part>();
  let drawn = "";

  const line = (row: Row, index: number, part: number): Shown => {
    const { about, name } = row.told;
    const id = `param-${part}-${index}`;
    const input = make("input", { type: "text", id, autocomplete: "off", spellcheck: "false", maxlength: "1000", "aria-label": `${name} of ${row.entity}`, "aria-describedby": `${id}-note`, ...(about?.items === 1 ? { inputmode: "decimal" } : {}) });
    input.addEventListener("input", () => typed(row.key, input.value));
    input.addEventListener("keydown", (event) => {
      if (event.key === "Escape") typed(row.key, null);
      else if (event.key === "Enter" || event.key === "ArrowDown") step(input, 1);
      else if (event.key === "ArrowUp") step(input, -1);
      else return;
      event.preventDefault();
    });
    const value = make("span", { class: "num now" });
    const marks = make("span", { class: "marks" });
    const note = make("p", { class: "param-note", id: `${id}-note` });
    const range = about ? rangeOf({ ...about, unit: "" }) : "";
    const root = make(
      "tr",
      {},
      make("th", { scope: "row" }, make("span", { class: "param-name" }, name), make("span", { class: "dim doc" }, about ? about.doc : "not described: this is no parameter that Lutra knows"), note),
      make("td", {}, make("span", { class: "param-value" }, input, make("span", { class: "unit" }, about?.unit ?? "")), value),
      make("td", { class: "dim" }, about?.live === false ? "in its file only" : range || "—"),
      make("td", { class: "num dim" }, about ? about.default : "—"),
      make("td", {}, marks),
    );
    return { root, input, value, marks, note };
  };

  const step = (from: HTMLInputElement, by: number): void => {
    const all = [...root.querySelectorAll<HTMLInputElement>("tr:not([hidden]) input:not([readonly])")].filter((one) => one.offsetParent !== null);
    const next = all[all.indexOf(from) + by];
    next?.focus();
    next?.select();
  };

  const section = ({ entity, left_out }: EntityTold, rows: readonly Row[], part: number): Part => {
    const shown = new Map(rows.map((row, index) => [row.key, line(row, index, part)]));
    const told = make("span", { class: "dim num" });
    const head = make("tr", {}, ...["Parameter", "Value", "Allowed", "Default", "Differs"].map((text) => make("th", { scope: "col" }, text)));
    const id = `param-part-${part}`;
    const more = left_out ? [make("p", { class: "note warn" }, `${left_out} more are not shown: they are too many.`)] : [];
    const none = rows.length ? [] : [make("p", { class: "dim" }, "It has no parameters.")];
    const table = rows.length ? [make("table", { class: "params", "aria-labelledby": id }, make("thead", {}, head), make("tbody", {}, ...[...shown.values()].map((one) => one.root)))] : [];
    return { root: make("section", { "aria-labelledby": id }, make("h3", {}, make("span", { id }, entity), told), ...none, ...more, ...table), told, rows: shown };
  };

  return {
    fill(told, rows) {
      const now = JSON.stringify(told.entities.map(({ entity, left_out, parameters }) => [entity, left_out, parameters.map(({ name, about }) => [name, about])]));
      if (now === drawn) return;
      drawn = now;
      parts.clear();
      told.entities.forEach((one, index) => parts.set(one.entity, section(one, rows.filter((row) => row.entity === one.entity), index)));
      root.replaceChildren(...[...parts.values()].map((part) => part.root));
    },
    update(rows, shown, outcomes, may) {
      const seen = new Set<string>();
      for (const row of rows) {
        const place = parts.get(row.entity)?.rows.get(row.key);
        if (!place) continue;
        setAttribute(place.root, "hidden", shown.has(row.key) ? null : "");
        if (shown.has(row.key)) seen.add(row.entity);
        const { told, edit } = row;
        const text = edit ?? told.value;
        if (place.input.value !== text) place.input.value = text;
        const fixed = !may || told.about?.live === false || told.cut;
        place.input.readOnly = fixed;
        place.input.title = told.cut ? "Too long to be changed here." : told.about?.live === false ? "It is set in the vessel's configuration file only; change it there and start the vessel again." : "";
        setAttribute(place.input, "aria-invalid", row.problem ? "true" : null);
        setText(place.value, edit === undefined ? "" : `now ${told.value}`);
        const marks = [row.unsaved ? `saved ${told.saved}` : "", row.changed ? "default" : ""].filter(Boolean);
        setText(place.marks, marks.map((mark) => `≠ ${mark}`).join("\n"));
        const outcome = outcomes.get(row.key);
        const note = row.problem || (outcome ? `${outcome.kind}${outcome.text ? `: ${outcome.text}` : ""}` : "");
        setText(place.note, note);
        setAttribute(place.root, "data-state", row.problem ? "wrong" : outcome ? outcome.kind : edit !== undefined ? "edited" : null);
      }
      for (const [entity, part] of parts) setAttribute(part.root, "hidden", seen.has(entity) ? null : "");
    },
    ages(told, nowUs) {
      for (const { entity, time_us } of told.entities) {
        const part = parts.get(entity);
        if (part) setText(part.told, `told ${age(Math.max(0, (nowUs - time_us) / 1e6))} ago`);
      }
    },
    focus(key) {
      for (const part of parts.values()) part.rows.get(key)?.input.focus();
    },
  };
}
