// STOP ALL: asked back once, in the same place, with the names of all whom it stops.

import { OFFERED_MS, press } from "../state/stopall";
import { t } from "../words/words";
import { make, setAttribute, setText } from "./dom";

export interface Target {
  readonly address: number;
  readonly name: string;
  /** Whether it is heard now: the question says of which no stop may be delivered at once. */
  readonly heard: boolean;
}

export interface StopAll {
  readonly root: HTMLElement;
  /** Whom it would stop. With less than two it is not there. */
  update(targets: readonly Target[]): void;
}

/** `stop` is called with all of them, those that the question named. */
export function createStopAll(stop: (targets: readonly Target[]) => void): StopAll {
  const text = make("span");
  const button = make("button", { type: "button", class: "halt" }, text);
  const count = make("p", { class: "count" });
  const names = make("ul");
  const cancel = make("button", { type: "button" }, t("Cancel"));
  const question = make("div", { class: "question", role: "alertdialog", "aria-label": t("Stop all vessels"), hidden: "" }, count, names, cancel);
  const root = make("div", { class: "all", hidden: "" }, button, question);
  let targets: readonly Target[] = [];
  /** Whom the question names, while it stands. */
  let asked: { readonly targets: readonly Target[]; readonly ms: number; readonly timer: number } | undefined;

  const draw = (): void => {
    const about = asked?.targets ?? targets;
    setAttribute(root, "hidden", about.length > 1 ? null : "");
    setText(text, asked ? t("CONFIRM STOP {n}", { n: about.length }) : t("STOP ALL"));
    setAttribute(button, "data-asked", asked ? "" : null);
    setAttribute(question, "hidden", asked ? null : "");
  };
  const end = (): void => {
    window.clearTimeout(asked?.timer);
    asked = undefined;
    draw();
  };
  const ask = (): void => {
    window.clearTimeout(asked?.timer);
    asked = { targets, ms: performance.now(), timer: window.setTimeout(end, OFFERED_MS) };
    setText(count, t("This stops {n} vessels. Press again within {seconds} s.", { n: targets.length, seconds: OFFERED_MS / 1_000 }));
    names.replaceChildren(...targets.map(({ name, heard }) => make("li", {}, heard ? name : t("{name} (not heard)", { name }))));
    draw();
  };
  button.addEventListener("click", () => {
    const next = press(asked?.ms, performance.now());
    if (next === "ask") return ask();
    if (next === "nothing" || !asked) return;
    const all = asked.targets;
    end();
    stop(all);
  });
  cancel.addEventListener("click", () => {
    end();
    button.focus();
  });
  root.addEventListener("keydown", (event) => {
    if (event.key !== "Escape" || !asked) return;
    event.preventDefault();
    end();
    button.focus();
  });
  return {
    root,
    update(next) {
      targets = next;
      draw();
    },
  };
}
