// Help: keys of the page and words of the field, opened by `?` or from the top bar. It is loaded when it is first opened.

import { reason } from "../api/http";
import { later, t } from "../words/words";
import { make } from "./dom";

/** `?` opens it, on every page; Escape closes it, as of any dialog. */
export function createHelp(): void {
  const place = document.querySelector(".own");
  if (!place) return;
  const button = make("button", { type: "button", class: "help-button", "aria-label": t("Help"), title: t("Help: keys and words. ?") }, "?");
  place.prepend(button);
  let dialog: HTMLDialogElement | undefined;
  const show = (shown: HTMLDialogElement): void => {
    if (!shown.isConnected) document.body.append(shown);
    if (!shown.open) shown.showModal();
  };
  const open = (): void => {
    if (dialog) return show(dialog);
    later(() => import("./helpdialog")).then(
      ({ createHelpDialog }) => show((dialog ??= createHelpDialog())),
      (error: unknown) => show(make("dialog", { class: "help", "aria-label": t("Help") }, make("p", { role: "alert" }, reason(error)), make("form", { method: "dialog" }, make("button", {}, t("Close"))))),
    );
  };
  button.addEventListener("click", open);
  document.addEventListener("keydown", (event) => {
    const typing = event.target instanceof Element && event.target.closest("input:not([type=range], [type=checkbox], [type=radio], [type=button]), textarea, select, [contenteditable]");
    if (event.key !== "?" || typing || event.ctrlKey || event.altKey || event.metaKey) return;
    event.preventDefault();
    open();
  });
}
