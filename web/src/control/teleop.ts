// Steering by hand: the panel, its socket, and everything that ends it.
//
// Nothing moves but while a dead-man is held in a window that is seen, has the focus and has control. The browser says
// 20 times a second what the hands do; the server decides what that is worth. What goes wrong is told twice: by an
// explicit stop, and by samples that do not come any more.

import type { TeleopSay, TeleopTold } from "../api/types.gen";
import { make, setAttribute, setText } from "../ui/dom";
import type { Confirm } from "./confirm";
import { createHands } from "./hands";

const SAMPLE_MS = 50;
/** The server answers 20 times a second: after this silence nothing of what it said counts, ms. */
const SILENCE_MS = 1_000;

const WORDS: Readonly<Record<TeleopTold["phase"], string>> = {
  idle: "Not steering by hand.",
  starting: "Asking the vessel to be steered by hand …",
  locked: "STOPPED. Let go of everything: the dead-man released, the sticks in neutral.",
  ready: "Ready, motors stand still. Hold the dead-man first, then steer.",
  steering: "STEERING. Let go to stop.",
};

export interface TeleopPanel {
  /** Whether this window has control. */
  update(here: boolean): void;
}

export function createTeleop(root: HTMLElement, address: number, key: string, name: () => string, confirm: Confirm): TeleopPanel {
  const begin = make("button", { type: "button" }, "Steer by hand …");
  const leave = make("button", { type: "button", class: "main" }, "End steering by hand");
  const state = make("p", { class: "helm-state", role: "status" }, "");
  const trip = make("p", { class: "helm-trip num" });
  const most = make("input", { type: "range", min: "10", max: "100", step: "10", value: "40", "aria-label": "Most thrust, %" });
  const mostTold = make("output", { class: "num" }, "40 %");
  const keys = make("button", { type: "button", class: "helm-keys" }, "Keys: click here, hold Space, steer with arrows or W A S D");
  const knob = make("span", { class: "knob", "aria-hidden": "true" });
  const pad = make("div", { class: "helm-pad", role: "img", "aria-label": "Touch pad: hold it and move from where you touch; up is ahead. Keys do the same." }, knob);
  const gamepad = make("p", { class: "helm-gamepad" });
  const helm = make("div", { class: "helm", hidden: "" }, state, trip, make("label", { class: "row" }, "Most thrust ", most, mostTold), make("div", { class: "helm-hands" }, keys, pad), gamepad, leave);
  root.append(make("h3", {}, "Steer by hand"), begin, helm);
  most.addEventListener("input", () => setText(mostTold, `${most.value} %`));

  let socket: WebSocket | undefined;
  let asked = false;
  let told: { what: TeleopTold; at: number } | undefined;
  let last = "";
  let seq = 0;
  let timer: number | undefined;
  let trouble = "";

  const say = (what: TeleopSay): void => {
    if (socket?.readyState === WebSocket.OPEN) socket.send(JSON.stringify(what));
  };
  const stop = (): void => {
    hands.release();
    say({ stop: {} });
  };
  const hands = createHands(keys, pad, knob, () => most.valueAsNumber / 100, stop);

  const sample = (): void => {
    const now = performance.now();
    const { held, thrust, turn, change } = hands.sample(seq);
    seq += 1;
    const seen = document.visibilityState === "visible" && document.hasFocus();
    // A buffer that fills is a line that does not carry: what is in it comes too late.
    if (socket && socket.bufferedAmount === 0) {
      say({ sample: { seq, made_ms: now, change, stamp_us: told?.what.stamp_us ?? null, stamp_held_ms: told ? now - told.at : 0, held: held && seen, thrust, turn } });
    }
    draw();
  };
  const draw = (): void => {
    const fresh = told && performance.now() - told.at < SILENCE_MS ? told.what : undefined;
    const phase = fresh?.phase ?? "idle";
    const words = !fresh ? "The server is not heard: nothing you do here reaches the vessel." : phase === "idle" ? fresh.why || trouble || WORDS.idle : phase === "locked" && fresh.why ? `${WORDS.locked} (${fresh.why})` : WORDS[phase];
    if (words !== last) setText(state, (last = words));
    setAttribute(helm, "data-phase", fresh ? phase : "lost");
    const ms = fresh?.round_trip_ms;
    const way = fresh?.with_vessel ? "to the vessel and back" : "to the server and back; the vessel's part is not known";
    setText(trip, ms === null || ms === undefined ? "Round trip: not known" : `Round trip ${Math.round(ms)} ms ${way}${fresh?.slow ? ". SLOW: steer with care." : ""}${fresh && fresh.cap < 1 ? ` Thrust is limited to ${Math.round(fresh.cap * 100)} %.` : ""}`);
    setAttribute(trip, "data-slow", fresh?.slow ? "" : null);
    const device = hands.gamepad();
    setText(gamepad, device ? `Gamepad: ${device}. Hold a trigger or shoulder button, steer with the left stick.` : "No gamepad: press one of its buttons to have it found.");
  };
  const close = (why: string): void => {
    const old = socket;
    socket = undefined;
    told = undefined;
    asked = false;
    window.clearInterval(timer);
    old?.close();
    hands.release();
    setAttribute(helm, "hidden", "");
    setAttribute(begin, "hidden", null);
    trouble = why;
    setAttribute(note, "hidden", why ? null : "");
    setText(note, why);
  };
  const open = (): void => {
    close("");
    const scheme = location.protocol === "https:" ? "wss:" : "ws:";
    const mine = new WebSocket(`${scheme}//${location.host}/api/v1/vessels/${address}/teleop`);
    socket = mine;
    mine.onmessage = (event: MessageEvent<string>) => {
      if (socket !== mine) return;
      const what = JSON.parse(event.data) as TeleopTold;
      told = { what, at: performance.now() };
      // Begun when the round trip is known, which takes a sample that came back.
      if (!asked && what.round_trip_ms !== null) {
        asked = true;
        say({ begin: { window: key } });
      } else if (asked && what.phase === "idle" && what.why) {
        close(what.why);
      }
    };
    mine.onclose = (event) => {
      if (socket === mine) close(`Steering by hand ended: ${event.reason || "the server is not reached"}.`);
    };
    setAttribute(helm, "hidden", null);
    setAttribute(begin, "hidden", "");
    keys.focus();
    timer = window.setInterval(sample, SAMPLE_MS);
  };
  const note = make("p", { class: "note", role: "alert", hidden: "" });
  root.append(note);
  begin.addEventListener("click", () => {
    confirm.ask(`Steer ${name()} by hand?`, [`Vessel: ${name()}`, "What the vessel does now ends. Its motors stand still until you hold a dead-man and steer."], "Steer by hand", open);
  });
  leave.addEventListener("click", () => {
    say({ stop: {} });
    say({ end: {} });
    close("");
    begin.focus();
  });
  document.addEventListener("visibilitychange", () => {
    if (socket && document.visibilityState !== "visible") stop();
  });
  window.addEventListener("blur", () => {
    if (socket) stop();
  });
  window.addEventListener("pagehide", () => {
    if (!socket) return;
    stop();
    say({ end: {} });
  });

  return {
    update(here) {
      begin.disabled = !here;
      begin.title = here ? `What ${name()} does ends; its motors stand still until you steer.` : "Take control first.";
      if (!here && socket) {
        stop();
        close("Steering by hand ended: you do not have control of this vessel any more.");
      }
    },
  };
}
