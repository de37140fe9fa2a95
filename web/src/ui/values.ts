// The latest value of every field of a system, with unit and age. Only rows in sight are in the page.

import type { Field, Update } from "../api/types.gen";
import { ageS, freshForS, seriesKey } from "../state/fleet";
import { quantity } from "../state/quantities";
import { t, tn } from "../words/words";
import { make, setAttribute, setText } from "./dom";
import { age, field } from "./format";

/** Height of a row, px; the style sheet has the same. */
const ROW_PX = 34;
/** Rows kept ready above and below those in sight. */
const SPARE = 30;

/** A field of a series. */
export interface Cell {
  readonly update: Update;
  readonly field: Field;
  readonly entity: string;
}

interface Row {
  readonly root: HTMLTableRowElement;
  readonly cells: readonly HTMLElement[];
  readonly plot: HTMLButtonElement | undefined;
  cell: Cell | undefined;
}

export interface ValueTable {
  update(title: string, values: readonly Update[], entities: ReadonlyMap<number, string>, nowUs: number): void;
}

/** Shows values in `root`. With `plot` each number has a button that calls it. */
export function createValues(root: HTMLElement, plot?: (cell: Cell) => void): ValueTable {
  const title = make("h2", { id: "values-title" }, t("Latest values"));
  const filter = make("input", { type: "search", id: "values-filter", placeholder: t("speed, heading, voltage, ...") });
  const count = make("span", { class: "dim" });
  const body = make("tbody");
  const [above, below] = [make("tbody", { "aria-hidden": "true" }, spacer(plot ? 7 : 6)), make("tbody", { "aria-hidden": "true" }, spacer(plot ? 7 : 6))];
  const head = make("tr");
  const names = [t("Message"), t("Entity"), t("Field"), t("Value"), t("Unit"), t("Age")];
  for (const name of names) head.append(make("th", { scope: "col" }, name));
  if (plot) head.append(make("th", { scope: "col" }, make("span", { class: "hidden" }, t("Plot"))));
  const table = make("table", { class: "values" }, make("thead", {}, head), above, body, below);
  const box = make("div", { class: "wide scroll", tabindex: "0", role: "region", "aria-label": t("Latest values") }, table);
  root.append(
    make("div", { class: "values-head" }, title, count, make("label", { for: "values-filter" }, `${t("Filter")} `), filter),
    box,
  );
  const rows: Row[] = [];
  let cells: readonly Cell[] = [];
  let nowUs = 0;

  const add = (): void => {
    const made = names.map((_, index) => make("td", index === 3 ? { class: "num value" } : index === 5 ? { class: "num" } : {}));
    const button = plot ? make("button", { type: "button", class: "small" }, t("Plot")) : undefined;
    const row: Row = { root: make("tr", {}, ...made, ...(button ? [make("td", {}, button)] : [])), cells: made, plot: button, cell: undefined };
    button?.addEventListener("click", () => row.cell && plot?.(row.cell));
    rows.push(row);
    body.append(row.root);
  };

  // Asking for these while the page changes makes the browser lay all of it out at once.
  let [top, height] = [0, 0];
  const draw = (): void => {
    const first = Math.max(0, Math.min(cells.length - 1, Math.floor(top / ROW_PX) - SPARE));
    const shown = Math.min(cells.length - Math.max(0, first), Math.ceil((height || 400) / ROW_PX) + 2 * SPARE);
    while (rows.length < shown) add();
    rows.forEach((row, index) => {
      const cell = index < shown ? cells[first + index] : undefined;
      setAttribute(row.root, "hidden", cell ? null : "");
      row.cell = cell;
      if (cell) fill(row, cell, first + index, nowUs);
    });
    stretch(above, first);
    stretch(below, Math.max(0, cells.length - first - shown));
    setAttribute(table, "aria-rowcount", String(cells.length + 1));
  };
  box.addEventListener("scroll", () => {
    top = box.scrollTop;
    draw();
  }, { passive: true });
  new ResizeObserver(() => {
    height = box.clientHeight;
    draw();
  }).observe(box);
  filter.addEventListener("input", () => (box.scrollTop = 0));

  return {
    update(name, values, entities, now) {
      setText(title, name);
      nowUs = now;
      const words = filter.value.trim().toLowerCase().split(/\s+/);
      const found: Cell[] = [];
      let all = 0;
      for (const update of [...values].sort(byName)) {
        const label = entities.get(update.entity) ?? (update.entity === 255 ? "" : String(update.entity));
        const entity = update.instance === null ? label : `${label} ${update.instance}`;
        for (const one of update.fields) {
          all += 1;
          const text = `${update.abbrev} ${entity} ${one.name} ${quantity(update.abbrev, one.name)}`.toLowerCase();
          if (words.every((word) => text.includes(word))) found.push({ update, field: one, entity });
        }
      }
      cells = found;
      setText(count, found.length === all ? tn(all, "{n} field", "{n} fields") : t("{n} of {all} fields", { n: found.length, all }));
      draw();
    },
  };
}

function fill(row: Row, cell: Cell, index: number, nowUs: number): void {
  const { text, unit } = field(cell.field);
  const old = ageS(cell.update, nowUs);
  const measured = quantity(cell.update.abbrev, cell.field.name);
  const texts = [cell.update.abbrev, cell.entity, measured ? `${cell.field.name} · ${measured}` : cell.field.name, text, unit, age(old)];
  texts.forEach((one, at) => row.cells[at] && setText(row.cells[at], one));
  row.cells[1]?.setAttribute("title", cell.entity);
  row.cells[2]?.setAttribute("title", measured);
  row.cells[3]?.setAttribute("title", text);
  setAttribute(row.root, "class", old > freshForS(cell.update) ? "stale" : null);
  setAttribute(row.root, "aria-rowindex", String(index + 2));
  if (!row.plot) return;
  const numeric = typeof cell.field.value === "number";
  setAttribute(row.plot, "hidden", numeric ? null : "");
  setAttribute(row.plot, "aria-label", t("Plot {abbrev} {entity} {name}", { abbrev: cell.update.abbrev, entity: cell.entity, name: cell.field.name }));
}

function spacer(columns: number): HTMLTableRowElement {
  return make("tr", {}, make("td", { colspan: String(columns) }));
}

/** Makes room for so many rows that are not there. */
function stretch(part: HTMLTableSectionElement, count: number): void {
  setAttribute(part, "hidden", count ? null : "");
  const cell = part.querySelector("td");
  if (cell) cell.style.height = `${count * ROW_PX}px`;
}

function byName(one: Update, other: Update): number {
  return (
    one.abbrev.localeCompare(other.abbrev) ||
    one.entity - other.entity ||
    (one.instance ?? 0) - (other.instance ?? 0) ||
    seriesKey(one).localeCompare(seriesKey(other))
  );
}
