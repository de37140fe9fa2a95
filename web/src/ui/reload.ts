// What stands in place of a part of a page that could not be loaded. Browsers remember a module whose loading failed, so asking
// for it again gives the same failure: only the page as a whole can be loaded again.

import { t } from "../words/words";
import { make } from "./dom";

export function reloadOffer(): HTMLElement {
  const again = make("button", { type: "button" }, t("Load the page again"));
  again.addEventListener("click", () => location.reload());
  return make("p", { role: "alert" }, t("This part of the page could not be loaded."), " ", again);
}
