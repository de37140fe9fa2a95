// What a narrow top bar has no room for opens from a button: pages, palette, account.

import { setAttribute } from "./dom";

export function createMenu(): void {
  const [button, menu] = [document.getElementById("menu-button"), document.getElementById("menu")];
  if (!button || !menu) return;
  const isOpen = (): boolean => button.getAttribute("aria-expanded") === "true";
  const open = (whether: boolean): void => setAttribute(button, "aria-expanded", String(whether));
  button.addEventListener("click", () => open(!isOpen()));
  document.addEventListener("pointerdown", ({ target }) => {
    if (target instanceof Node && !menu.contains(target) && !button.contains(target)) open(false);
  });
  for (const part of [button, menu]) {
    part.addEventListener("keydown", (event) => {
      if (event.key !== "Escape" || !isOpen()) return;
      event.preventDefault();
      open(false);
      button.focus();
    });
  }
}
