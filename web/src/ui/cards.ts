// Tables whose rows are cards where they have little room. What is laid out as no table is none to some browsers: so each part
// says by its role what it is, and who hears the page still goes from row to row and hears the names of columns.

import { setAttribute } from "./dom";

/** Roles of a table's parts, by selectors: of each part the last that fits. */
const ROLES = [["thead, tbody", "rowgroup"], ["tr", "row"], ["td", "cell"], ["th[scope=row]", "rowheader"], ["th[scope=col]", "columnheader"]] as const;

/** Gives all parts of a table that is there their roles. */
export function asCards(table: HTMLTableElement): HTMLTableElement {
  table.classList.add("cards");
  setAttribute(table, "role", "table");
  for (const [parts, role] of ROLES) for (const one of table.querySelectorAll(parts)) setAttribute(one, "role", role);
  return table;
}
