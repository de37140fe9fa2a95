// Choosing a field to plot from all that were recorded or are heard.

import { make, setAttribute, setText } from "../ui/dom";
import { type Source, written } from "./model";

/** Fields offered at once; the words narrow them. */
const OFFERED = 60;

export interface Choice {
  readonly source: Source;
  readonly label: string;
  readonly unit: string;
}

/** A button that opens a list of what `choices` gives; `choose` is called with one. */
export function createChooser(choices: () => readonly Choice[], choose: (source: Source) => void): HTMLElement {
  const words = make("input", { type: "search", "aria-label": "Words of message, entity or field", placeholder: "message, entity or field" });
  const list = make("ul", { class: "choices" });
  const more = make("p", { class: "dim" });
  const close = make("button", { type: "button" }, "Close");
  const dialog = make("dialog", { class: "chooser", "aria-label": "Add a field" }, make("div", { class: "row" }, words, close), list, more);
  const open = make("button", { type: "button", class: "main" }, "Add a field");
  const offer = (): void => {
    const wanted = words.value.trim().toLowerCase().split(/\s+/);
    const found = choices().filter(({ label }) => wanted.every((word) => label.toLowerCase().includes(word)));
    list.replaceChildren(
      ...found.slice(0, OFFERED).map(({ source, label, unit }) => {
        const button = make("button", { type: "button", "data-source": written(source) }, label, ...(unit ? [make("span", { class: "dim" }, ` ${unit}`)] : []));
        button.addEventListener("click", () => {
          dialog.close();
          choose(source);
        });
        return make("li", {}, button);
      }),
    );
    const rest = found.length - OFFERED;
    setText(more, found.length ? (rest > 0 ? `${rest} more: give more words.` : "") : "Nothing has these words.");
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
