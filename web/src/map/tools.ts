// The tools of a map: one column of icons at its edge, in one order on every page, and the words that they say beside it.

import { type Icon, icon } from "../ui/icons";
import { make } from "../ui/dom";
import { t } from "../words/words";

/** From above. */
const ORDER: readonly Icon[] = ["all", "follow", "course", "rings", "tags", "person", "measure", "query", "chart"];

export interface MapTools {
  /** A tool; `label` names it, and `title` says more to whoever rests on it. */
  button(icon: Icon, label: string, title?: string): HTMLButtonElement;
  /** A line beside the tools, empty for now. */
  line(kind: string): HTMLElement;
  /** What a tool opens stands beside it. */
  panel(content: HTMLElement): void;
}

export function createTools(box: HTMLElement): MapTools {
  const column = make("div", { class: "map-tools", role: "group", "aria-label": t("Map tools") });
  const beside = make("div", { class: "map-told" });
  box.append(beside, column);
  return {
    button(name, label, title = "") {
      const made = make("button", { type: "button", "data-tool-of-map": name, "aria-label": label, title: title ? `${label}. ${title}` : label });
      made.append(icon(name));
      const later = [...column.children].find((one) => ORDER.indexOf((one as HTMLElement).dataset["toolOfMap"] as Icon) > ORDER.indexOf(name));
      column.insertBefore(made, later ?? null);
      return made;
    },
    line(kind) {
      const made = make("p", { class: `${kind} num`, role: "status" });
      beside.append(made);
      return made;
    },
    panel: (content) => beside.append(content),
  };
}
