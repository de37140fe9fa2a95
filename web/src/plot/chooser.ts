// Choosing a field to plot from all that were recorded or are heard.

import { make, setAttribute, setText } from "../ui/dom";
import { t } from "../words/words";
import { type Source, written } from "./model";

/** Fields offered at once; the words narrow them. */
const OFFERED = 60;

export interface Choice {
  readonly source: Source;
  /** Message, entity and field by their IMC names. */
  readonly label: string;
  /** What it measures in words; empty where only IMC's name is known. */
  readonly quantity: string;
  readonly entity: string;
  readonly unit: string;
}

/** A button that opens a list of what `choices` gives; `choose` is called with one. */
export function createChooser(choices: () => readonly Choice[], choose: (source: Source) => void): HTMLElement {
  const words = make("input", { type: "search", "aria-label": t("Words of quantity, message, entity or field"), placeholder: t("speed, heading, voltage, ...") });
  const list = make("ul", { class: "choices" });
  const more = make("p", { class: "dim" });
  const close = make("button", { type: "button" }, t("Close"));
  const dialog = make("dialog", { class: "chooser", "aria-label": t("Add a field") }, make("div", { class: "row" }, words, close), list, more);
  const open = make("button", { type: "button", class: "main" }, t("Add a field"));
  const offer = (): void => {
    const wanted = words.value.trim().toLowerCase().split(/\s+/);
    const has = (text: string): boolean => wanted.every((word) => text.toLowerCase().includes(word));
    const all = choices();
    // What measures the thing comes before what only has its word in a name.
    const measured = all.filter(({ quantity }) => quantity && has(quantity));
    const found = [...measured, ...all.filter((one) => !measured.includes(one) && has(`${one.label} ${one.quantity}`))];
    list.replaceChildren(
      ...found.slice(0, OFFERED).map(({ source, label, quantity, entity, unit }) => {
        const dim = (text: string): HTMLElement => make("span", { class: "dim" }, text);
        const named = quantity ? [make("b", {}, quantity), ` ${entity} `, dim(`${source.message} ${source.field}`)] : [label];
        const button = make("button", { type: "button", "data-source": written(source) }, ...named, ...(unit ? [dim(` ${unit}`)] : []));
        button.addEventListener("click", () => {
          dialog.close();
          choose(source);
        });
        return make("li", {}, button);
      }),
    );
    const rest = found.length - OFFERED;
    setText(more, found.length ? (rest > 0 ? t("{rest} more: give more words.", { rest }) : "") : t("No matching fields."));
    setAttribute(more, "hidden", more.textContent ? null : "");
  };
  words.addEventListener("input", offer);
  words.addEventListener("keydown", (event) => {
    if (event.key !== "Enter") return;
    event.preventDefault();
    list.querySelector("button")?.click();
  });
  dialog.addEventListener("keydown", (event) => {
    if (event.key !== "Escape") return;
    dialog.close();
    open.focus();
  });
  close.addEventListener("click", () => dialog.close());
  open.addEventListener("click", () => {
    words.value = "";
    offer();
    // Not a modal one: STOP stays within reach.
    dialog.show();
    words.focus();
  });
  return make("div", {}, open, dialog);
}
