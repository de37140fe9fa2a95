// Steering by hand: the panel, its socket, and everything that ends it.
//
// Nothing moves but while a dead-man is held in a window that is seen, has the focus and has control. The browser says
// 20 times a second what the hands do; the server decides what that is worth. What goes wrong is told twice: by an
// explicit stop, and by samples that do not come any more.

import type { TeleopMessage, TeleopStop, TeleopStatus } from "../api/types.gen";
import type { Guard } from "../state/guard";
import { isNeutral, offNeutral, type Pad, padText, standing, tripText } from "../state/teleop";
import { make, setAttribute, setText } from "../ui/dom";
import { t, worded } from "../words/words";
import type { Confirm } from "./confirm";
import { createGuard } from "./guard";
import { createHands, type HandsSource } from "./hands";
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

export function createTeleop(root: HTMLElement, needs: TeleopNeeds): TeleopPanel {
  return new Helm(root, needs);
}

/** What the panel is made of. */
class HelmView {
  readonly begin = make("button", { type: "button" }, t("Steer by hand …"));
  readonly leave = make("button", { type: "button", class: "main" }, t("End steering by hand"));
  readonly keys = make("button", { type: "button", class: "helm-keys" }, t("Keys: click here, hold Space, steer with arrows or W A S D"));
  readonly knob = make("span", { class: "knob", "aria-hidden": "true" });
  readonly pad = make("div", { class: "helm-pad", role: "img", "aria-label": t("Touch pad: hold it and move from where you touch; up is ahead. Keys do the same.") }, this.knob);
  readonly padUse = make("button", { type: "button", "aria-pressed": "false", hidden: "" }, t("Leave the gamepad out"));
  readonly guardBox = make("div", { class: "helm-guard", hidden: "" });
  readonly helm: HTMLElement;
  private readonly most = make("input", { type: "range", min: "10", max: "100", step: "10", value: "40", "aria-label": t("Most thrust, %") });
  private readonly state = make("p", { class: "helm-state" });
  private readonly why = make("p", { class: "helm-why" });
  private readonly remedy = make("p", { class: "helm-remedy" });
  private readonly trip = make("p", { class: "helm-trip num" });
  private readonly gamepad = make("p", { class: "helm-gamepad" });
  // Its place is kept free, so that nothing moves under a finger.
  private readonly vigil = make("p", { class: "helm-vigil", "aria-live": "assertive" });
  private readonly note = make("p", { class: "note bad", role: "alert", hidden: "" });

  constructor(private readonly root: HTMLElement) {
    const mostTold = make("output", { class: "num" }, "40 %");
    this.most.addEventListener("input", () => setText(mostTold, `${this.most.value} %`));
    const told = make("div", { class: "helm-told", role: "status" }, this.state, this.why, this.remedy);
    const hands = make("div", {}, this.keys, make("label", { class: "row" }, `${t("Most thrust")} `, this.most, mostTold), this.gamepad, this.padUse, this.leave);
    this.helm = make("div", { class: "helm", hidden: "" }, told, this.vigil, this.trip, this.guardBox, make("div", { class: "helm-hands" }, hands, this.pad));
    root.append(make("h3", {}, t("Steer by hand")), this.begin, this.helm, this.note);
  }

  /** The most thrust, of 1. */
  mostThrust(): number {
    return this.most.valueAsNumber / 100;
  }

  /** Whether the gamepad is left out. */
  leftOut(): boolean {
    return this.padUse.getAttribute("aria-pressed") === "true";
  }

  /** Whoever steers sees this panel; the past is no time to steer in. */
  isSeen(): boolean {
    return document.visibilityState === "visible" && document.hasFocus() && this.helm.checkVisibility() && !this.helm.closest("[inert]");
  }

  /** What the person has to do so that the hands go on to count; whether that is news. */
  asks(text: string): boolean {
    const news = text !== "" && !this.vigil.textContent;
    setText(this.vigil, text);
    return news;
  }

  open(): void {
    setAttribute(this.helm, "hidden", null);
    setAttribute(this.begin, "hidden", "");
  }

  /** For who steers: into sight, with the keys at hand. */
  show(): void {
    this.root.scrollIntoView({ block: "start" });
    this.keys.focus({ preventScroll: true });
  }

  close(text: string): void {
    const { helm, begin, note } = this;
    setText(this.vigil, "");
    setAttribute(helm, "data-phase", "idle");
    const within = helm.contains(document.activeElement);
    setAttribute(helm, "hidden", "");
    setAttribute(begin, "hidden", null);
    if (within) begin.focus();
    setAttribute(note, "hidden", text ? null : "");
    setText(note, text);
  }

  /** `fresh`: what the server says, while that counts; `before`: whether it said anything yet. */
  draw(fresh: TeleopStatus | undefined, before: boolean, neutral: boolean, device: Pad | undefined): void {
    const out = this.leftOut();
    const now = standing(fresh, before, neutral, device && !out ? offNeutral(device) : "");
    setText(this.state, now.state);
    setText(this.why, now.why);
    setText(this.remedy, now.remedy);
    setAttribute(this.helm, "data-phase", fresh?.phase ?? (before ? "lost" : "idle"));
    setText(this.trip, tripText(fresh));
    setAttribute(this.trip, "data-slow", fresh?.slow ? "" : null);
    setText(this.gamepad, !device ? t("No gamepad: press one of its buttons to have it found.") : out ? t("Gamepad left out: {id}.", { id: device.id }) : padText(device));
    setAttribute(this.padUse, "hidden", device ? null : "");
  }
}

class Helm implements TeleopPanel {
  private readonly view: HelmView;
  private readonly hands: HandsSource;
  private readonly guard: ReturnType<typeof createGuard>;
  private socket: WebSocket | undefined;
  private asked = false;
  private last: { what: TeleopStatus; at: number } | undefined;
  private seq = 0;
  private timer: number | undefined;
  private neutral = true;
  private wasSeen = true;

  constructor(root: HTMLElement, private readonly needs: TeleopNeeds) {
    const view = (this.view = new HelmView(root));
    this.guard = createGuard(view.guardBox, needs.orders, needs.confirm, needs.name);
    this.hands = createHands(view.keys, view.pad, view.knob, () => view.mostThrust(), (why) => this.stop(why));
    view.begin.addEventListener("click", () => this.ask());
    view.padUse.addEventListener("click", () => {
      const out = !view.leftOut();
      setAttribute(view.padUse, "aria-pressed", String(out));
      this.hands.usePad(!out);
    });
    view.leave.addEventListener("click", () => {
      this.end();
      this.close("");
    });
    document.addEventListener("visibilitychange", () => {
      if (this.socket && document.visibilityState !== "visible") this.stop("hidden");
    });
    window.addEventListener("blur", () => {
      if (this.socket) this.stop("unfocused");
    });
    window.addEventListener("pagehide", () => {
      if (this.socket) this.end();
    });
  }

  update(here: boolean, guarded: Guard | undefined): void {
    const { begin } = this.view;
    begin.disabled = !here;
    begin.title = here ? t("The current plan or order of {name} will be cancelled; its motors stand still until you steer.", { name: this.needs.name() }) : t("Take control first.");
    this.guard.update(guarded);
    if (!here && this.socket) {
      this.stop("person");
      this.close(t("Ended: control of the vessel was lost. Its motors stand still. Take control again if you still need it."));
    }
  }

  private ask(): void {
    const name = this.needs.name();
    this.needs.confirm.ask(t("Steer {name} by hand?", { name }), [t("Vessel: {name}", { name }), t("The current plan or order will be cancelled. Its motors stand still until you hold a dead-man and steer.")], t("Steer by hand"), () => this.open());
  }

  private say(what: TeleopMessage): void {
    if (this.socket?.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(what));
  }

  private stop(why: TeleopStop): void {
    this.hands.release();
    this.say({ stop: { why } });
  }

  /** The person wants no more. */
  private end(): void {
    this.stop("person");
    this.say({ end: {} });
  }

  private sample(): void {
    const now = performance.now();
    const isSeen = this.view.isSeen();
    if (this.wasSeen && !isSeen) this.stop("hidden");
    this.wasSeen = isSeen;
    const { held, thrust, turn, change } = this.hands.sample(this.seq, now);
    this.seq += 1;
    this.neutral = isNeutral({ thrust, turn });
    const { socket, last, seq } = this;
    // A buffer that fills is a line that does not carry: what is in it comes too late.
    if (socket && socket.bufferedAmount === 0) {
      this.say({ sample: { seq, made_ms: now, change, stamp_us: last?.what.stamp_us ?? null, stamp_held_ms: last ? now - last.at : 0, held: held && isSeen, thrust, turn } });
    }
    this.draw();
  }

  private draw(): void {
    const { last } = this;
    if (this.view.asks(this.hands.asks())) this.needs.attention();
    const fresh = last && performance.now() - last.at < SILENCE_MS ? last.what : undefined;
    this.view.draw(fresh, last !== undefined, this.neutral, this.hands.gamepad());
  }

  private close(text: string): void {
    const old = this.socket;
    this.socket = undefined;
    this.last = undefined;
    this.asked = false;
    window.clearInterval(this.timer);
    old?.close();
    this.hands.release();
    this.view.close(text);
  }

  private open(): void {
    this.close("");
    const scheme = location.protocol === "https:" ? "wss:" : "ws:";
    const mine = new WebSocket(`${scheme}//${location.host}/api/v1/vessels/${this.needs.address}/teleop`);
    this.socket = mine;
    mine.onmessage = (event: MessageEvent<string>) => {
      if (this.socket === mine) this.heard(JSON.parse(event.data) as TeleopStatus);
    };
    mine.onclose = (event) => {
      if (this.socket === mine) this.close(t("Ended: {reason}. Start again when the vessel is live.", { reason: event.reason || t("the server is not reached; the vessel's motors stop by themselves") }));
    };
    this.view.open();
    this.draw();
    this.view.show();
    this.timer = window.setInterval(() => this.sample(), SAMPLE_MS);
  }

  private heard(what: TeleopStatus): void {
    this.last = { what, at: performance.now() };
    // Begun when the round trip is known, which takes a sample that came back.
    if (!this.asked && what.round_trip_ms !== null) {
      this.asked = true;
      this.say({ begin: { window: this.needs.key } });
    } else if (this.asked && what.phase === "idle" && what.why) {
      this.close([worded({ text: what.why, says: what.why_says }), worded({ text: what.remedy, says: what.remedy_says })].filter(Boolean).join(" "));
    }
  }
}
