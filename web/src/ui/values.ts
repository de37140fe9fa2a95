// The latest value of every field of the chosen system, with unit and age.

import type { Update } from "../api/types.gen";
import { ageS, freshForS, seriesKey } from "../state/fleet";
import { make, setAttribute, setText } from "./dom";
import { age, field } from "./format";

/** Rows that are drawn; a filter finds the others. */
const ROWS = 400;

interface Row {
  readonly root: HTMLTableRowElement;
  readonly value: HTMLElement;
  readonly unit: HTMLElement;
  readonly age: HTMLElement;
}

export interface ValueTable {
  update(title: string, values: readonly Update[], entities: ReadonlyMap<number, string>, nowUs: number): void;
}

/** Shows values in `root`. */
export function createValues(root: HTMLElement): ValueTable {
  const title = make("h2", { id: "values-title" }, "Latest values");
  const filter = make("input", { type: "search", id: "values-filter", placeholder: "message, entity or field" });
  const more = make("p", { class: "dim", hidden: "" });
  const body = make("tbody");
  const head = make("tr");
  for (const name of ["Message", "Entity", "Field", "Value", "Unit", "Age"]) {
    head.append(make("th", { scope: "col" }, name));
  }
  const table = make("table", { class: "values" }, make("thead", {}, head), body);
  const box = make("div", { class: "wide scroll", tabindex: "0", role: "region", "aria-labelledby": "values-title" }, table);
  root.append(
    make("div", { class: "values-head" }, title, make("label", { for: "values-filter" }, "Filter "), filter),
    box,
    more,
  );
  let rows = new Map<string, Row>();
  let order = "";

  return {
    update(name, values, entities, nowUs) {
      setText(title, name);
      const wanted = filter.value.trim().toLowerCase();
      const shown: { key: string; update: Update; index: number; entity: string }[] = [];
      for (const update of [...values].sort(byName)) {
        const entity = entities.get(update.entity) ?? (update.entity === 255 ? "" : String(update.entity));
        update.fields.forEach((one, index) => {
          const text = `${update.abbrev} ${entity} ${one.name}`.toLowerCase();
          if (text.includes(wanted)) shown.push({ key: `${seriesKey(update)}/${one.name}`, update, index, entity });
        });
      }
      const cut = shown.length - ROWS;
      setAttribute(more, "hidden", cut > 0 ? null : "");
      setText(more, cut > 0 ? `${cut} more: narrow the filter.` : "");
      shown.length = Math.min(shown.length, ROWS);
      const keys = shown.map((one) => one.key).join("\n");
      if (keys !== order) {
        order = keys;
        const next = new Map<string, Row>();
        for (const { key, update, index, entity } of shown) {
          next.set(key, rows.get(key) ?? row(update, update.fields[index]?.name ?? "", entity));
        }
        rows = next;
        body.replaceChildren(...[...rows.values()].map((one) => one.root));
      }
      for (const { key, update, index } of shown) {
        const [known, one] = [rows.get(key), update.fields[index]];
        if (!known || !one) continue;
        const { text, unit } = field(one);
        const old = ageS(update, nowUs);
        setText(known.value, text);
        setText(known.unit, unit);
        setText(known.age, age(old));
        setAttribute(known.root, "class", old > freshForS(update) ? "stale" : null);
      }
    },
  };
}

function row(update: Update, name: string, entity: string): Row {
  const value = make("td", { class: "num value" });
  const unit = make("td");
  const old = make("td", { class: "num" });
  const from = update.instance === null ? entity : `${entity} ${update.instance}`;
  const root = make(
    "tr",
    {},
    // What is too long for its column is told whole under the pointer.
    make("td", { title: update.abbrev }, update.abbrev),
    make("td", { title: from }, from),
    make("td", { title: name }, name),
    value,
    unit,
    old,
  );
  return { root, value, unit, age: old };
}

function byName(one: Update, other: Update): number {
  return one.abbrev.localeCompare(other.abbrev) || one.entity - other.entity || (one.instance ?? 0) - (other.instance ?? 0);
}
