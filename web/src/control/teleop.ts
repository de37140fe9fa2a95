// Steering by hand: the panel, its socket, and everything that ends it.
//
// Nothing moves but while a dead-man is held in a window that is seen, has the focus and has control. The browser says
// 20 times a second what the hands do; the server decides what that is worth. What goes wrong is told twice: by an
// explicit stop, and by samples that do not come any more.

import type { TeleopSay, TeleopStop, TeleopTold } from "../api/types.gen";
import { type Guard, isNeutral, offNeutral, padText, standing, tripText } from "../state/teleop";
import { make, setAttribute, setText } from "../ui/dom";
import type { Confirm } from "./confirm";
import { createGuard } from "./guard";
import { createHands } from "./hands";
import type { Orders } from "./orders";

const SAMPLE_MS = 50;
/** The server answers 20 times a second: after this silence nothing of what it said counts, ms. */
const SILENCE_MS = 1_000;

export interface TeleopPanel {
  /** Whether this window has control, and what the vessel's guard says. */
  update(here: boolean, guard: Guard | undefined): void;
}

export interface TeleopNeeds {
  readonly address: number;
  /** Tells this window from others of the same person. */
  readonly key: string;
  readonly orders: Orders;
  readonly confirm: Confirm;
  name(): string;
  /** Makes a sound for the person who steers, if sound is on. */
  attention(): void;
}

export function createTeleop(root: HTMLElement, { address, key, orders, confirm, name, attention }: TeleopNeeds): TeleopPanel {
  const begin = make("button", { type: "button" }, "Steer by hand …");
  const leave = make("button", { type: "button", class: "main" }, "End steering by hand");
  const [state, why, remedy] = [make("p", { class: "helm-state" }), make("p", { class: "helm-why" }), make("p", { class: "helm-remedy" })];
  const trip = make("p", { class: "helm-trip num" });
  const most = make("input", { type: "range", min: "10", max: "100", step: "10", value: "40", "aria-label": "Most thrust, %" });
  const mostTold = make("output", { class: "num" }, "40 %");
  const keys = make("button", { type: "button", class: "helm-keys" }, "Keys: click here, hold Space, steer with arrows or W A S D");
  const knob = make("span", { class: "knob", "aria-hidden": "true" });
  const pad = make("div", { class: "helm-pad", role: "img", "aria-label": "Touch pad: hold it and move from where you touch; up is ahead. Keys do the same." }, knob);
  const gamepad = make("p", { class: "helm-gamepad" });
  const padUse = make("button", { type: "button", "aria-pressed": "false", hidden: "" }, "Leave the gamepad out");
  const guardBox = make("div", { class: "helm-guard", hidden: "" });
  const told = make("div", { class: "helm-told", role: "status" }, state, why, remedy);
  // Its place is kept free, so that nothing moves under a finger.
  const vigil = make("p", { class: "helm-vigil", "aria-live": "assertive" });
  const helm = make("div", { class: "helm", hidden: "" }, told, vigil, trip, guardBox, make("div", { class: "helm-hands" }, make("div", {}, keys, make("label", { class: "row" }, "Most thrust ", most, mostTold), gamepad, padUse, leave), pad));
  const note = make("p", { class: "note bad", role: "alert", hidden: "" });
  root.append(make("h3", {}, "Steer by hand"), begin, helm, note);
  most.addEventListener("input", () => setText(mostTold, `${most.value} %`));
  const guard = createGuard(guardBox, orders, confirm, name);

  let socket: WebSocket | undefined;
  let asked = false;
  let last: { what: TeleopTold; at: number } | undefined;
  let seq = 0;
  let timer: number | undefined;
  let neutral = true;

  const say = (what: TeleopSay): void => {
    if (socket?.readyState === WebSocket.OPEN) socket.send(JSON.stringify(what));
  };
  const stop = (why: TeleopStop): void => {
    hands.release();
    say({ stop: { why } });
  };
  const hands = createHands(keys, pad, knob, () => most.valueAsNumber / 100, stop);

  /** Whoever steers sees this panel; the past is no time to steer in. */
  const seen = (): boolean => document.visibilityState === "visible" && document.hasFocus() && helm.checkVisibility() && !helm.closest("[inert]");
  let wasSeen = true;
  const sample = (): void => {
    const now = performance.now();
    const isSeen = seen();
    if (wasSeen && !isSeen) stop("hidden");
    wasSeen = isSeen;
    const { held, thrust, turn, change } = hands.sample(seq, now);
    seq += 1;
    neutral = isNeutral({ thrust, turn });
    // A buffer that fills is a line that does not carry: what is in it comes too late.
    if (socket && socket.bufferedAmount === 0) {
      say({ sample: { seq, made_ms: now, change, stamp_us: last?.what.stamp_us ?? null, stamp_held_ms: last ? now - last.at : 0, held: held && isSeen, thrust, turn } });
    }
    draw();
  };
  const draw = (): void => {
    const asks = hands.asks();
    if (asks && !vigil.textContent) attention();
    setText(vigil, asks);
    const fresh = last && performance.now() - last.at < SILENCE_MS ? last.what : undefined;
    const device = hands.gamepad();
    const out = padUse.getAttribute("aria-pressed") === "true";
    const now = standing(fresh, last !== undefined, neutral, device && !out ? offNeutral(device) : "");
    setText(state, now.state);
    setText(why, now.why);
    setText(remedy, now.remedy);
    setAttribute(helm, "data-phase", fresh?.phase ?? (last ? "lost" : "idle"));
    setText(trip, tripText(fresh));
    setAttribute(trip, "data-slow", fresh?.slow ? "" : null);
    setText(gamepad, !device ? "No gamepad: press one of its buttons to have it found." : out ? `Gamepad left out: ${device.id}.` : padText(device));
    setAttribute(padUse, "hidden", device ? null : "");
  };
  const close = (text: string): void => {
    const old = socket;
    socket = undefined;
    last = undefined;
    asked = false;
    window.clearInterval(timer);
    old?.close();
    hands.release();
    setText(vigil, "");
    setAttribute(helm, "data-phase", "idle");
    const within = helm.contains(document.activeElement);
    setAttribute(helm, "hidden", "");
    setAttribute(begin, "hidden", null);
    if (within) begin.focus();
    setAttribute(note, "hidden", text ? null : "");
    setText(note, text);
  };
  const open = (): void => {
    close("");
    const scheme = location.protocol === "https:" ? "wss:" : "ws:";
    const mine = new WebSocket(`${scheme}//${location.host}/api/v1/vessels/${address}/teleop`);
    socket = mine;
    mine.onmessage = (event: MessageEvent<string>) => {
      if (socket !== mine) return;
      const what = JSON.parse(event.data) as TeleopTold;
      last = { what, at: performance.now() };
      // Begun when the round trip is known, which takes a sample that came back.
      if (!asked && what.round_trip_ms !== null) {
        asked = true;
        say({ begin: { window: key } });
      } else if (asked && what.phase === "idle" && what.why) {
        close([what.why, what.remedy].filter(Boolean).join(" "));
      }
    };
    mine.onclose = (event) => {
      if (socket === mine) close(`Ended: ${event.reason || "the server is not reached; the vessel's motors stop by themselves"}. Start again when the vessel is live.`);
    };
    setAttribute(helm, "hidden", null);
    setAttribute(begin, "hidden", "");
    draw();
    root.scrollIntoView({ block: "start" });
    keys.focus({ preventScroll: true });
    timer = window.setInterval(sample, SAMPLE_MS);
  };
  begin.addEventListener("click", () => {
    confirm.ask(`Steer ${name()} by hand?`, [`Vessel: ${name()}`, "The current plan or order will be cancelled. Its motors stand still until you hold a dead-man and steer."], "Steer by hand", open);
  });
  padUse.addEventListener("click", () => {
    const out = padUse.getAttribute("aria-pressed") !== "true";
    setAttribute(padUse, "aria-pressed", String(out));
    hands.usePad(!out);
  });
  leave.addEventListener("click", () => {
    stop("person");
    say({ end: {} });
    close("");
  });
  document.addEventListener("visibilitychange", () => {
    if (socket && document.visibilityState !== "visible") stop("hidden");
  });
  window.addEventListener("blur", () => {
    if (socket) stop("unfocused");
  });
  window.addEventListener("pagehide", () => {
    if (!socket) return;
    stop("person");
    say({ end: {} });
  });

  return {
    update(here, guarded) {
      begin.disabled = !here;
      begin.title = here ? `What ${name()} does ends; its motors stand still until you steer.` : "Take control first.";
      guard.update(guarded);
      if (!here && socket) {
        stop("person");
        close("Ended: control of the vessel was lost. Its motors stand still. Take control again if you still need it.");
      }
    },
  };
}
