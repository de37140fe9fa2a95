// The language of pages in other tabs: one that was opened before another language was chosen says so. It is not loaded again by
// itself: somebody may steer by it.

import { t } from "../words/words";
import { make } from "./dom";

/** The language of the page that was opened last in this browser. */
const KEPT = "lutra-language";

export function tellLanguage(): void {
  const own = document.documentElement.lang;
  localStorage.setItem(KEPT, own);
  let note: HTMLElement | undefined;
  window.addEventListener("storage", ({ key, newValue }) => {
    if (key !== KEPT || newValue === null) return;
    note?.remove();
    note = newValue === own ? undefined : offer();
    if (note) document.getElementById("top")?.append(note);
  });
}

function offer(): HTMLElement {
  const again = make("button", { type: "button" }, t("Load the page again"));
  again.addEventListener("click", () => location.reload());
  return make("p", { class: "note", role: "status" }, t("Another language was chosen in another tab."), " ", again);
}
