// A menu that opens from a button: what can be done with one thing, by pointer and by keyboard.

import { t } from "../words/words";
import { make } from "./dom";

export interface MenuItem {
  readonly text: string;
  /** The key that does the same elsewhere. */
  readonly keys?: string;
  /** Why it cannot be done. */
  readonly whyNot?: string;
  /** It leads the keyboard somewhere by itself. */
  readonly leads?: boolean;
  act(): void;
}

export interface PopupMenu {
  /** Opens below a button, or above it where there is more room. */
  open(button: HTMLElement, label: string, items: readonly MenuItem[]): void;
}

/** One for many buttons. `after` says where the keyboard goes when something was done. */
export function createPopupMenu(after: () => HTMLElement | null): PopupMenu {
  const root = make("div", { class: "popup-menu", role: "menu", popover: "auto" });
  document.body.append(root);
  let from: HTMLElement | undefined;
  const entries = (): HTMLElement[] => [...root.querySelectorAll<HTMLElement>('[role="menuitem"]')];
  const close = (to: HTMLElement | null | undefined): void => {
    root.hidePopover();
    to?.focus();
  };
  root.addEventListener("keydown", (event) => {
    const all = entries();
    const at = all.indexOf(document.activeElement as HTMLElement);
    const to = { ArrowDown: at + 1, ArrowUp: at - 1, Home: 0, End: all.length - 1 }[event.key];
    if (to !== undefined) all[(to + all.length) % all.length]?.focus();
    else if (event.key === "Escape" || event.key === "Tab") close(from?.isConnected ? from : after());
    else return;
    event.preventDefault();
    event.stopPropagation();
  });
  // What it opened from is somewhere else by then.
  window.addEventListener("resize", () => root.hidePopover());
  document.addEventListener("wheel", ({ target }) => void (root.contains(target as Node) || root.hidePopover()), { capture: true, passive: true });
  const entryOf = (item: MenuItem): HTMLElement => {
    const text = item.whyNot ? t("{text}: not possible, {why}", { text: item.text, why: item.whyNot }) : item.text;
    const entry = make("button", { type: "button", role: "menuitem", tabindex: "-1", ...(item.whyNot ? { "aria-disabled": "true" } : {}) }, text, ...(item.keys ? [make("kbd", { "aria-hidden": "true" }, item.keys)] : []));
    entry.addEventListener("click", () => {
      if (item.whyNot) return;
      root.hidePopover();
      item.act();
      if (!item.leads) after()?.focus();
    });
    return entry;
  };
  return {
    open(button, label, items) {
      from = button;
      root.setAttribute("aria-label", label);
      root.replaceChildren(...items.map(entryOf));
      root.showPopover();
      const [box, own] = [button.getBoundingClientRect(), root.getBoundingClientRect()];
      const below = box.bottom + own.height < innerHeight;
      Object.assign(root.style, { top: `${Math.max(4, below ? box.bottom : box.top - own.height)}px`, left: `${Math.max(4, Math.min(box.right - own.width, innerWidth - own.width - 4))}px` });
      entries()[0]?.focus();
    },
  };
}
