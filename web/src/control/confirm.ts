// The second step before a vessel is set in motion: what will happen, in words; it ends by itself and is never the
// first thing under the finger.

import { make, setText } from "../ui/dom";
import { t } from "../words/words";

/** Nothing is confirmed after this, s: what is shown may not be true any more. */
const LASTS_S = 30;

export interface Confirm {
  /** Shows what will happen; `act` does it, `over` is called when it ends, either way. */
  ask(title: string, lines: readonly string[], word: string, act: () => void, over?: () => void): void;
  close(): void;
}

export function createConfirm(root: HTMLElement): Confirm {
  let timer: number | undefined;
  let back: HTMLElement | null = null;
  let after: (() => void) | undefined;
  const close = (): void => {
    window.clearInterval(timer);
    if (!root.childElementCount) return;
    root.replaceChildren();
    after?.();
    after = undefined;
    if (back?.isConnected) back.focus();
  };
  root.addEventListener("keydown", (event) => {
    if (event.key === "Escape") close();
  });
  return {
    close,
    ask(title, lines, word, act, over) {
      window.clearInterval(timer);
      after?.();
      after = over;
      back = document.activeElement instanceof HTMLElement ? document.activeElement : null;
      const head = make("h3", { tabindex: "-1" }, title);
      const left = make("span", { class: "left" });
      const yes = make("button", { type: "button", class: "main" }, word);
      const no = make("button", { type: "button" }, t("Cancel"));
      yes.addEventListener("click", () => {
        close();
        act();
      });
      no.addEventListener("click", close);
      root.replaceChildren(make("div", { class: "confirm", role: "group", "aria-label": title }, head, make("ul", {}, ...lines.map((line) => make("li", {}, line))), make("div", { class: "row" }, no, yes, left)));
      // The words get the focus, not the button: a stray key confirms nothing.
      head.focus();
      let rest = LASTS_S;
      const count = (): void => {
        setText(left, t("expires in {rest} s", { rest }));
        if (rest-- <= 0) close();
      };
      count();
      timer = window.setInterval(count, 1_000);
    },
  };
}
