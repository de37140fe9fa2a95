// A button beside lines that are to be copied.

import { t } from "../words/words";
import { make, setText } from "./dom";

/** Gives every element that asks for it (`data-copy`) a button that copies its text. */
export function offerCopies(root: ParentNode): void {
  for (const lines of root.querySelectorAll<HTMLElement>("[data-copy]")) {
    const button = make("button", { type: "button" }, t("Copy"));
    const said = make("span", { class: "dim", role: "status" });
    button.addEventListener("click", () => void copy(lines).then((text) => setText(said, text)));
    lines.after(make("div", { class: "row" }, button, said));
  }
}

/** Copies, or, where the browser lets no page do that, as without encryption, marks the lines for the keys that do. */
async function copy(lines: HTMLElement): Promise<string> {
  try {
    await navigator.clipboard.writeText(lines.textContent);
    return t("Copied.");
  } catch {
    window.getSelection()?.selectAllChildren(lines);
    return t("Marked: copy them with Ctrl and C.");
  }
}
