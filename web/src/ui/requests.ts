// Somebody asks for control that this person has: told on every page, for without an answer it is soon theirs.

import { reason } from "../api/http";
import type { LeaseAction, LiveFrame } from "../api/types.gen";
import { createOrders } from "../control/orders";
import { type ControlState, withControls } from "../state/control";
import { windowKey } from "../state/window";
import { t } from "../words/words";
import { make, setText } from "./dom";

interface Row {
  readonly root: HTMLElement;
  readonly left: HTMLElement;
}

export interface Requests {
  frame(frame: LiveFrame, nameOf: (address: number) => string): void;
}

/** Rows in `root` for `me`. */
export function createRequests(root: HTMLElement, me: string): Requests {
  let controls: ReadonlyMap<number, ControlState> = new Map();
  const rows = new Map<string, Row>();

  const row = (vessel: number, by: string, name: string, why: string): Row => {
    const failed = make("span", { class: "bad-text", role: "alert" });
    const left = make("span", { "aria-live": "off" });
    const answer = (word: string, action: LeaseAction): HTMLButtonElement => {
      const made = make("button", { type: "button", "aria-label": `${word}: ${by}, ${name}` }, word);
      made.addEventListener("click", () => {
        setText(failed, "");
        createOrders(vessel, windowKey()).lease(action).catch((error: unknown) => setText(failed, reason(error)));
      });
      return made;
    };
    const made = make("div", { class: "order", "data-stage": "asked" }, make("span", { class: "what" }, `${t("{by} asks for control of {name}", { by, name })}${why ? `: ${why}` : ""}.`, " ", left, " ", failed), answer(t("Grant"), "grant"), answer(t("Decline"), "decline"));
    root.append(made);
    return { root: made, left };
  };

  return {
    frame(frame, nameOf) {
      controls = withControls(controls, frame);
      const here = new Set<string>();
      for (const [vessel, { lease }] of controls) {
        const { holder, waiting } = lease ?? {};
        if (holder?.name !== me || !waiting || waiting.name === me) continue;
        const key = `${vessel}/${waiting.name}/${waiting.reason}`;
        here.add(key);
        const shown = rows.get(key) ?? row(vessel, waiting.name, nameOf(vessel), waiting.reason);
        rows.set(key, shown);
        setText(shown.left, t("Granted in {seconds} s unless you answer.", { seconds: Math.max(0, Math.round((waiting.granted_us - frame.now_us) / 1e6)) }));
      }
      for (const [key, { root: gone }] of rows) {
        if (here.has(key)) continue;
        gone.remove();
        rows.delete(key);
      }
    },
  };
}
