// Help: keys of the page and words of the field, opened by `?` or from the top bar. What it shows is loaded when it is first
// opened; the dialog itself opens at once, never later over what the person does by then. It is not modal: STOP stays within
// reach, by pointer and by keyboard, and lies above it.

import { later, t } from "../words/words";
import { make } from "./dom";
import { reloadOffer } from "./reload";

/** `?` opens it on every page, or leads the keyboard back into it; Escape closes it. */
export function createHelp(): void {
  const place = document.querySelector(".own");
  if (!place) return;
  const button = make("button", { type: "button", class: "help-button", "aria-label": t("Help"), title: t("Help: keys and words. ?") }, "?");
  place.prepend(button);
  let dialog: HTMLDialogElement | undefined;
  const open = (): void => {
    dialog ??= createDialog();
    if (!dialog.open) dialog.show();
    dialog.querySelector<HTMLElement>("input, button")?.focus();
  };
  button.addEventListener("click", open);
  document.addEventListener("keydown", (event) => {
    const { key, target } = event;
    if (key === "Escape" && dialog?.open && (target === document.body || (target instanceof Node && dialog.contains(target)))) {
      event.preventDefault();
      dialog.close();
    }
    const typing = target instanceof Element && target.closest("input:not([type=range], [type=checkbox], [type=radio], [type=button]), textarea, select, [contenteditable]");
    if (key !== "?" || typing || event.ctrlKey || event.altKey || event.metaKey) return;
    event.preventDefault();
    open();
  });
}

function createDialog(): HTMLDialogElement {
  const dialog = make("dialog", { class: "help", "aria-label": t("Help") });
  document.body.append(dialog);
  const closing = (): HTMLElement => make("form", { method: "dialog" }, make("button", {}, t("Close")));
  dialog.append(make("p", { role: "status" }, t("Reading …")), closing());
  later(() => import("./helpdialog")).then(
    ({ fillHelp }) => fillHelp(dialog),
    () => dialog.replaceChildren(reloadOffer(), closing()),
  );
  // The browser gives the focus back to where it was, unless that is folded away with the menu by then.
  dialog.addEventListener("close", () => {
    const at = document.activeElement;
    if (at === document.body || dialog.contains(at)) document.getElementById("menu-button")?.focus();
  });
  return dialog;
}
