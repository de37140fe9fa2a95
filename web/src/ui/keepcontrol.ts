// Who has control keeps it on every page of the window that took it; where the server does not answer that, it is said before
// control ends.

import { reason } from "../api/http";
import type { LiveFrame } from "../api/types.gen";
import { createOrders } from "../control/orders";
import { type ControlState, endsSoon_s, partOf, withControls } from "../state/control";
import { windowKey } from "../state/window";
import { t } from "../words/words";
import { make, setText } from "./dom";

/** Control lasts a minute; it is renewed this often, and at once on a page that is opened, ms. */
const RENEW_MS = 10_000;
const LOOK_MS = 1_000;

export interface KeepControl {
  frame(frame: LiveFrame, nameOf: (address: number) => string): void;
}

/** Rows in `root` for `me`. */
export function createKeepControl(root: HTMLElement, me: string): KeepControl {
  let controls: ReadonlyMap<number, ControlState> = new Map();
  let nameOf: (address: number) => string = String;
  /** The server's time of the last frame, µs, and when it came, ms of the steady clock. */
  let heard = { us: 0, ms: performance.now() };
  const rows = new Map<number, { readonly root: HTMLElement; readonly text: HTMLElement; readonly failed: HTMLElement }>();
  const mine = (): number[] => [...controls].flatMap(([vessel, { lease }]) => (partOf(lease, me, windowKey()) === "here" ? [vessel] : []));
  const renew = async (vessel: number): Promise<void> => {
    try {
      await createOrders(vessel, windowKey()).lease("renew");
    } catch (error) {
      const row = rows.get(vessel);
      if (row) setText(row.failed, reason(error));
    }
  };
  const row = (vessel: number): { root: HTMLElement; text: HTMLElement; failed: HTMLElement } => {
    const [text, failed] = [make("span", { "aria-live": "off" }), make("span", { class: "bad-text", role: "alert" })];
    const keep = make("button", { type: "button", "aria-label": t("Keep control of {name}", { name: nameOf(vessel) }) }, t("Keep control"));
    keep.addEventListener("click", () => void renew(vessel));
    const made = { root: make("div", { class: "order", "data-stage": "asked" }, make("span", { class: "what" }, text, " ", failed), keep), text, failed };
    root.append(made.root);
    rows.set(vessel, made);
    return made;
  };
  let renewedMs = -Infinity;
  const renewAll = (): void => {
    const vessels = mine();
    if (!vessels.length || performance.now() - renewedMs < RENEW_MS) return;
    renewedMs = performance.now();
    for (const vessel of vessels) void renew(vessel);
  };
  const look = (): void => {
    renewAll();
    const nowUs = heard.us + (performance.now() - heard.ms) * 1e3;
    const here = new Set(mine());
    for (const vessel of here) {
      const left_s = endsSoon_s(controls.get(vessel)?.lease, nowUs);
      if (left_s === undefined) here.delete(vessel);
      else setText((rows.get(vessel) ?? row(vessel)).text, left_s > 0 ? t("Your control of {name} ends in {left} s: it was not renewed.", { name: nameOf(vessel), left: left_s }) : t("Your control of {name} has ended by now: it was not renewed.", { name: nameOf(vessel) }));
    }
    for (const [vessel, { root: gone }] of rows) {
      if (here.has(vessel)) continue;
      gone.remove();
      rows.delete(vessel);
    }
  };
  window.setInterval(look, LOOK_MS);
  return {
    frame(frame, called) {
      nameOf = called;
      heard = { us: frame.now_us, ms: performance.now() };
      controls = withControls(controls, frame);
    },
  };
}
