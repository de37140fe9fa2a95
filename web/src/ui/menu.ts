// What a narrow top bar has no room for opens from a button: pages, palette, account.

import { setAttribute } from "./dom";

export function createMenu(): void {
  const [button, menu] = [document.getElementById("menu-button"), document.getElementById("menu")];
  if (!button || !menu) return;
  const isOpen = (): boolean => button.getAttribute("aria-expanded") === "true";
  const open = (whether: boolean): void => setAttribute(button, "aria-expanded", String(whether));
  button.addEventListener("click", () => open(!isOpen()));
  // It is in the way of nothing: it closes when the person goes on elsewhere, by pointer or by keyboard.
  for (const name of ["pointerdown", "focusin"]) {
    document.addEventListener(name, ({ target }) => {
      if (target instanceof Node && !menu.contains(target) && !button.contains(target)) open(false);
    });
  }
  for (const part of [button, menu]) {
    part.addEventListener("keydown", (event) => {
      if (event.key !== "Escape" || !isOpen()) return;
      event.preventDefault();
      open(false);
      button.focus();
    });
  }
}
