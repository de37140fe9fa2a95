// STOP: always there, for one vessel never asked back, and true about how far it got.

import type { LiveFrame, LiveStopped, Ordered, System, Update } from "../api/types.gen";
import { createStopping, type StopLine, type StopNews, type Stopping } from "../control/stopping";
import { doing } from "../state/doing";
import { stepText } from "../state/orderwords";
import { meaning } from "../state/vitals";
import { allToStop } from "../state/stopall";
import { t } from "../words/words";
import { make, setAttribute, setText } from "./dom";
import { isShore, systemName, utc } from "./format";
import { createStopAll, type StopAll } from "./stopall";

/** A vessel that has not reported the effect by then is said not to have stopped, s. */
const EFFECT_S = 8;
/** A vessel that stopped is watched for so long whether it goes on, s. */
const WATCHED_S = 120;
/** The server gives a stop that its vessel has perhaps not heard again for so long, µs. */
const WAITS_US = 600_000_000;
/** Orders that are shown, and of a stop of all vessels one of each; older ones go, but for those without an answer. */
const SHOWN = 5;

interface Order {
  readonly address: number;
  readonly name: string;
  readonly root: HTMLElement;
  readonly text: HTMLElement;
  /** Closes it, or gives it up. */
  readonly away: HTMLElement;
  /** The time of day at which it was pressed. */
  readonly since: string;
  /** While the server has not answered. */
  asking: Stopping | undefined;
  ordered: Ordered | undefined;
  /** How often the server sent it, as far as is known. */
  sent: number;
  /** After so many seconds the effect was seen, in what came when (µs). */
  effectS: number | undefined;
  effectUs: number;
  over: boolean;
}

export interface Stop {
  /** The vessel that the page is about; undefined for none. */
  target(vessel: { address: number; name: string } | undefined): void;
  /** The server answered a stop by the live socket. */
  stopped(answer: LiveStopped): void;
  /** What vessels say, in which the effect of a stop is looked for. */
  frame(frame: LiveFrame): void;
  /** All that there are, of which those are offered that the person may stop. */
  vessels(systems: readonly System[], linked: boolean): void;
}

/**
 * `root` holds the buttons, `orders` what became of each stop, which goes by `line` and by a request. `given`: the names that
 * people gave, by address.
 */
export function createStop(root: HTMLElement, orders: HTMLElement, line: StopLine, given: Readonly<Record<string, string>>): Stop {
  return new Buttons(root, new Orders(orders, line), given);
}

/** The stops that were pressed here, and what became of each. */
class Orders {
  private readonly open: Order[] = [];
  /** Orders that are shown: at least all of one STOP ALL. */
  private shown = SHOWN;

  constructor(private readonly root: HTMLElement, private readonly line: StopLine) {}

  give(address: number, name: string): void {
    // Whoever presses again while nothing was answered wants the same, sooner.
    const before = this.open.find((one) => one.address === address && one.asking);
    if (before) return before.asking?.again();
    const text = make("span", { class: "what" }, t("STOP {name}: asking the server …", { name }));
    const away = make("button", { type: "button", class: "away", "aria-label": t("Close: STOP {name}", { name }) }, "✕");
    const row = make("div", { class: "order", "data-stage": "asked" }, text, away);
    const one: Order = { address, name, root: row, text, away, since: utc(Date.now() * 1_000, false), asking: undefined, ordered: undefined, sent: 1, effectS: undefined, effectUs: 0, over: false };
    away.addEventListener("click", () => close(one));
    this.open.push(one);
    this.root.prepend(row);
    one.asking = createStopping(this.line, address, newsOf(one));
    this.tidy();
  }

  all(targets: readonly { readonly address: number; readonly name: string }[]): void {
    this.shown = Math.max(SHOWN, targets.length);
    for (const { address, name } of targets) this.give(address, name);
  }

  stopped(answer: LiveStopped): void {
    for (const one of this.open) one.asking?.heard(answer);
  }

  frame(frame: LiveFrame): void {
    for (const one of this.open) follow(one, frame);
    for (let at = this.open.length - 1; at >= 0; at--) if (this.open[at]?.over) this.open.splice(at, 1);
  }

  /** Takes away the oldest orders beyond those that are shown. */
  private tidy(): void {
    const rows = [...this.root.children];
    const done = rows.filter((row) => !this.open.some((one) => one.root === row && one.asking));
    for (const row of done.reverse().slice(0, Math.max(0, rows.length - this.shown))) row.remove();
  }
}

/** The server answered, or the client no longer waits for it. */
function answered(one: Order): void {
  one.asking = undefined;
  setText(one.away, "✕");
  setAttribute(one.away, "aria-label", t("Close: STOP {name}", { name: one.name }));
}

function close(one: Order): void {
  const { asking, name, since } = one;
  if (asking) {
    asking.giveUp();
    answered(one);
    return end(one, "failed", t("STOP {name}: given up, without an answer since {since}. Nobody knows whether it was sent.", { name, since }));
  }
  one.root.remove();
  one.over = true;
}

/** What becomes of a stop on its way to the server. */
function newsOf(one: Order): StopNews {
  const { name, since } = one;
  return {
    answered(ordered) {
      answered(one);
      one.ordered = ordered;
      if (!ordered.known) tell(one, "failed", unknownText(name, one.address));
      else if (ordered.waits) tell(one, "failed", waitsText(name, ordered));
      else if (ordered.reached) tell(one, "sent", sentText(name, ordered.time_us));
      else end(one, "failed", t("STOP {name}: NOT SENT. Stop the vessel by other means; try again.", { name }));
    },
    refused(why) {
      answered(one);
      end(one, "failed", t("STOP {name}: NOT SENT. {why}", { name, why }));
    },
    forgotten() {
      answered(one);
      end(one, "failed", t("STOP {name}: no answer in ten minutes. Nobody knows whether it was sent; it is not sent any more. Press STOP again if it is still wanted.", { name }));
    },
    unanswered(why) {
      tell(one, "failed", t("STOP {name}: NOT SENT as far as is known. {why} Trying again since {since} … Stop it by other means.", { name, why, since }));
      setText(one.away, t("Give up"));
      setAttribute(one.away, "aria-label", t("Give up: STOP {name}", { name }));
    },
  };
}

/** The buttons: of the vessel that the page is about, of others, and of all. */
class Buttons implements Stop {
  private readonly listed: string;
  private readonly form: HTMLFormElement | null;
  private readonly main = make("span", { class: "aim" });
  private readonly list = make("div", { class: "others" });
  private readonly summary = make("summary", { class: "halt" }, t("STOP …"));
  private readonly menu = make("details", { hidden: "" }, this.summary, this.list);
  private readonly every: StopAll;
  private aim: { address: number; name: string } | undefined;
  private others = "";

  constructor(private readonly root: HTMLElement, private readonly orders: Orders, private readonly given: Readonly<Record<string, string>>) {
    this.listed = root.dataset["stops"] ?? "";
    this.form = root.querySelector("form");
    this.form?.addEventListener("submit", (event) => {
      // Before the script knows its vessel, the form goes as it is.
      if (!this.aim) return;
      event.preventDefault();
      orders.give(this.aim.address, this.aim.name);
    });
    this.every = createStopAll((targets) => orders.all(targets));
    root.append(...(this.form ? [this.menu, this.every.root] : [this.main, this.menu, this.every.root]));
    document.addEventListener("keydown", (event) => {
      // A chord, so that no slip of a finger stops a boat and no text field loses a letter.
      if (!(event.ctrlKey && event.key === ".") || event.repeat) return;
      event.preventDefault();
      this.chord();
    });
  }

  target(vessel: { address: number; name: string } | undefined): void {
    const aim = vessel && this.may(vessel.address) ? vessel : undefined;
    if (this.aim?.address === aim?.address && this.aim?.name === aim?.name) return;
    this.aim = aim;
    const { root, form } = this;
    setAttribute(root, "data-aim", aim ? "" : null);
    for (const halt of form ? form.querySelectorAll(".halt") : []) if (aim) setText(halt, t("STOP {name}", { name: aim.name }));
    if (!form) this.main.replaceChildren(...(aim ? [this.button(aim.address, aim.name)] : []));
    root.title = aim ? t("Cancels the current plan or order and stops the motors. Ctrl and . do the same.") : "";
    this.others = "";
  }

  stopped(answer: LiveStopped): void {
    this.orders.stopped(answer);
  }

  frame(frame: LiveFrame): void {
    this.orders.frame(frame);
  }

  /** Whom it stops; while the page has no link, none of them is known to be heard. */
  vessels(systems: readonly System[], linked: boolean): void {
    const vessels = systems.filter((system) => this.may(system.address) && !isShore(system) && system.kind !== "CCU");
    const here = vessels.map((system) => `${system.address}/${systemName(system)}`).join("\n");
    if (here !== this.others) {
      const rest = vessels.filter((system) => system.address !== this.aim?.address);
      setAttribute(this.menu, "hidden", rest.length ? null : "");
      setText(this.summary, this.aim ? t("Others …") : t("STOP …"));
      this.list.replaceChildren(...rest.map((system) => this.button(system.address, systemName(system))));
      this.others = here;
    }
    this.every.update(allToStop(vessels, this.given).map((system) => ({ address: system.address, name: systemName(system), heard: linked && (system.liveness === "live" || system.liveness === "late") })));
  }

  private may(address: number): boolean {
    return this.listed === "all" || this.listed.split(",").includes(String(address));
  }

  private button(address: number, name: string): HTMLButtonElement {
    const made = make("button", { type: "button", class: "halt" }, t("STOP {name}", { name }));
    made.addEventListener("click", () => this.orders.give(address, name));
    return made;
  }

  private chord(): void {
    const { aim, menu } = this;
    if (aim) return this.orders.give(aim.address, aim.name);
    // Where the page is about no vessel, somebody has to say which.
    if (menu.hasAttribute("hidden")) return;
    menu.open = true;
    this.list.querySelector("button")?.focus();
  }
}

/** Looks what the server made of a stop: it was sent once more, or never will be. Its effect is looked for from there. */
function followServer(order: Order, ordered: Ordered, frame: LiveFrame): Ordered | undefined {
  const steps = frame.commands.find(({ id }) => id === ordered.id)?.steps ?? [];
  const sent = steps.filter(({ stage }) => stage === "sent");
  // One that was given to a silent vessel may show its effect without being sent again.
  const shown = steps.find(({ stage }) => ["received", "executing", "effect seen"].includes(stage));
  const [latest, last] = [sent.at(-1) ?? shown, steps.at(-1)];
  if (latest && (ordered.waits || sent.length > order.sent)) {
    order.sent = Math.max(1, sent.length);
    order.effectS = undefined;
    order.ordered = { ...ordered, waits: false, reached: true, time_us: latest.time_us };
    tell(order, "sent", sentText(order.name, latest.time_us));
    return order.ordered;
  }
  if (last && (["expired", "refused"].includes(last.stage) || (ordered.waits && last.stage === "timed out"))) {
    end(order, "failed", ordered.reached ? t("STOP {name}: NO EFFECT SEEN: {text}. Stop the vessel by other means; try again.", { name: order.name, text: stepText(last) }) : t("STOP {name}: NOT SENT: {text}. Stop the vessel by other means; try again.", { name: order.name, text: stepText(last) }));
    return undefined;
  }
  if (ordered.waits && frame.now_us > ordered.time_us + WAITS_US) end(order, "failed", t("STOP {name}: the vessel was not heard in ten minutes; it is not sent any more.", { name: order.name }));
  return ordered.waits ? undefined : ordered;
}

/** What the vessel has probably not heard. */
function waitsText(name: string, { reached, time_us }: Ordered): string {
  const until = utc(time_us + WAITS_US, false);
  return reached
    ? t("STOP {name}: sent {time}, but the vessel is silent. It is sent again as soon as the vessel is heard, until {until}. Until then stop it by other means.", { name, time: utc(time_us, false), until })
    : t("STOP {name}: NOT SENT YET. No way leads to the vessel. It is sent as soon as the vessel is heard, until {until}. Until then stop it by other means.", { name, until });
}

/** The vessel of the page may have been removed, or its address mistyped. */
function unknownText(name: string, address: number): string {
  return t("STOP {name}: ordered, but no vessel with the address {address} is known here. Check the address; stop the vessel by other means.", { name, address: `0x${address.toString(16).padStart(4, "0").toUpperCase()}` });
}

function sentText(name: string, timeUs: number): string {
  return t("STOP {name}: accepted, sent {time}; waiting for the vessel to say that it stopped …", { name, time: utc(timeUs, false) });
}

/** Looks for the effect in what the vessel says. */
function follow(order: Order, frame: LiveFrame): void {
  const ordered = order.ordered && followServer(order, order.ordered, frame);
  if (order.over || !ordered) return;
  const after = (update: Update): boolean =>
    update.system === order.address && update.abbrev === "VehicleState" && update.received_us >= ordered.time_us;
  const state = frame.values.find(after);
  const took = ((state?.received_us ?? frame.now_us) - ordered.time_us) / 1e6;
  const mode = state ? meaning(state, "op_mode") : "";
  const does = doing({ word: mode, ageS: took, note: "" }, { word: "" });
  if (order.effectS !== undefined) {
    if (took > WATCHED_S) order.over = true;
    // Two lines tell of the vessel, and the slower one may still tell what was before.
    else if (state && state.received_us > order.effectUs && !["ERROR", "SERVICE", "BOOT"].includes(mode)) {
      end(order, "failed", t("STOP {name}: stopped after {took} s, but GOES ON since {time}: {does}. It was started again.", { name: order.name, took: tenths(order.effectS), time: utc(state.received_us, false), does }));
    }
  } else if (mode === "ERROR") {
    order.effectS = took;
    order.effectUs = state?.received_us ?? 0;
    tell(order, "done", t("STOP {name}: stopped after {took} s. Motors off, drifting.", { name: order.name, took: tenths(took) }));
  } else if (took > EFFECT_S) {
    const values = { name: order.name, seconds: EFFECT_S };
    tell(order, "failed", state ? t("STOP {name}: sent, but NO EFFECT SEEN in {seconds} s; it reports: {does}. Press STOP again or stop it by other means.", { ...values, does }) : t("STOP {name}: sent, but NO EFFECT SEEN in {seconds} s; it does not say that it stopped. Press STOP again or stop it by other means.", values));
    // The effect may still come, above all where the server sends it again to a vessel that was silent.
    order.over = took * 1e6 > WAITS_US;
  }
}

function tell(order: Order, stage: string, text: string): void {
  order.root.dataset["stage"] = stage;
  setText(order.text, text);
}

function end(order: Order, stage: string, text: string): void {
  tell(order, stage, text);
  order.over = true;
}

/** Seconds; nothing takes none. */
function tenths(seconds: number): string {
  return Math.max(0.1, seconds).toFixed(1);
}
