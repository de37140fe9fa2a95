// Help: keys of the page and words of the field, opened by `?` or from the top bar. What it shows is loaded when it is first
// opened; the dialog itself opens at once, never later over what the person does by then.

import { later, t } from "../words/words";
import { make } from "./dom";
import { reloadOffer } from "./reload";

/** `?` opens it, on every page; Escape closes it, as of any dialog. */
export function createHelp(): void {
  const place = document.querySelector(".own");
  if (!place) return;
  const button = make("button", { type: "button", class: "help-button", "aria-label": t("Help"), title: t("Help: keys and words. ?") }, "?");
  place.prepend(button);
  let dialog: HTMLDialogElement | undefined;
  const closing = (): HTMLElement => make("form", { method: "dialog" }, make("button", {}, t("Close")));
  const load = (into: HTMLDialogElement): void => {
    into.append(make("p", { role: "status" }, t("Reading …")), closing());
    later(() => import("./helpdialog")).then(
      ({ fillHelp }) => fillHelp(into),
      () => into.replaceChildren(reloadOffer(), closing()),
    );
  };
  const open = (): void => {
    if (!dialog) {
      dialog = make("dialog", { class: "help", "aria-label": t("Help") });
      document.body.append(dialog);
      load(dialog);
    }
    if (!dialog.open) dialog.showModal();
  };
  button.addEventListener("click", open);
  document.addEventListener("keydown", (event) => {
    const typing = event.target instanceof Element && event.target.closest("input:not([type=range], [type=checkbox], [type=radio], [type=button]), textarea, select, [contenteditable]");
    if (event.key !== "?" || typing || event.ctrlKey || event.altKey || event.metaKey) return;
    event.preventDefault();
    open();
  });
}
