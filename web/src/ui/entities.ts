// All parts of a vessel with how they say they are.

import { type EntityReading, STATE_WORDS } from "../state/vitals";
import { t } from "../words/words";
import { make, setAttribute, setText } from "./dom";
import { age } from "./format";

export interface EntityTable {
  update(entities: readonly EntityReading[]): void;
}

/** Text and shape beside the colour. */
const SHAPES: Readonly<Record<string, string>> = { NORMAL: "●", BOOT: "◔", FAULT: "▲", ERROR: "◆", FAILURE: "✕" };

/** Lists entities in `root`. */
export function createEntities(root: HTMLElement): EntityTable {
  const head = make("tr");
  for (const name of [t("Number"), t("Entity"), t("State"), t("Report"), t("Age")]) head.append(make("th", { scope: "col" }, name));
  const body = make("tbody");
  const table = make("table", { class: "compact" }, make("thead", {}, head), body);
  root.append(make("div", { class: "wide scroll", tabindex: "0", role: "region", "aria-label": t("Entities") }, table));
  const rows = new Map<number, HTMLElement[]>();
  return {
    update(entities) {
      for (const one of entities) {
        let cells = rows.get(one.entity);
        if (!cells) {
          cells = [0, 1, 2, 3, 4].map((column) => make("td", column === 0 || column === 4 ? { class: "num" } : {}));
          rows.set(one.entity, cells);
          const row = make("tr", { "data-entity": String(one.entity) }, ...cells);
          const after = [...body.children].find((other) => Number(other.getAttribute("data-entity")) > one.entity);
          body.insertBefore(row, after ?? null);
        }
        const shape = SHAPES[one.state] ?? "";
        const texts = [String(one.entity), one.label || t("without a label"), one.state ? `${shape} ${one.state === "NORMAL" ? t("normal") : (STATE_WORDS[one.state] ?? one.state)}` : t("— says nothing"), one.description, one.ageS === null ? "" : age(one.ageS)];
        texts.forEach((text, column) => cells[column] && setText(cells[column], text));
        const row = cells[0]?.parentElement;
        if (row) setAttribute(row, "class", one.old && one.state ? "stale" : null);
        if (cells[2]) setAttribute(cells[2], "data-state", one.state || null);
      }
    },
  };
}
