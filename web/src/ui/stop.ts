// STOP: always there, for one vessel never asked back, and true about how far it got.

import type { LiveFrame, LiveStopped, Ordered, System, Update } from "../api/types.gen";
import { createStopping, type StopLine, type Stopping } from "../control/stopping";
import { meaning } from "../state/vitals";
import { allToStop } from "../state/stopall";
import { make, setAttribute, setText } from "./dom";
import { isShore, systemName, utc } from "./format";
import { createStopAll } from "./stopall";

/** A vessel that has not told of the effect by then is said not to have stopped, s. */
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
  vessels(systems: readonly System[]): void;
}

/**
 * `root` holds the buttons, `orders` what became of each stop, which goes by `line` and by a request. `given`: the names that
 * people gave, by address.
 */
export function createStop(root: HTMLElement, orders: HTMLElement, line: StopLine, given: Readonly<Record<string, string>>): Stop {
  const listed = root.dataset["stops"] ?? "";
  const may = (address: number): boolean => listed === "all" || listed.split(",").includes(String(address));
  const open: Order[] = [];
  let aim: { address: number; name: string } | undefined;
  let others = "";
  /** Orders that are shown: at least all of one STOP ALL. */
  let shown = SHOWN;

  const order = (address: number, name: string): void => {
    // Whoever presses again while nothing was answered wants the same, sooner.
    const before = open.find((one) => one.address === address && one.asking);
    if (before) return before.asking?.again();
    const text = make("span", { class: "what" }, `STOP ${name}: asking the server …`);
    const away = make("button", { type: "button", class: "away", "aria-label": `Put away: STOP ${name}` }, "✕");
    const row = make("div", { class: "order", "data-stage": "asked" }, text, away);
    const one: Order = { address, name, root: row, text, asking: undefined, ordered: undefined, sent: 1, effectS: undefined, effectUs: 0, over: false };
    const since = utc(Date.now() * 1_000, false);
    const answered = (): void => {
      one.asking = undefined;
      setText(away, "✕");
      setAttribute(away, "aria-label", `Put away: STOP ${name}`);
    };
    away.addEventListener("click", () => {
      if (one.asking) {
        one.asking.giveUp();
        answered();
        return end(one, "failed", `STOP ${name}: given up, without an answer since ${since}. Nobody knows whether it was sent.`);
      }
      row.remove();
      one.over = true;
    });
    open.push(one);
    orders.prepend(row);
    one.asking = createStopping(line, address, {
      answered(ordered) {
        answered();
        one.ordered = ordered;
        if (ordered.waits) tell(one, "failed", waitsText(name, ordered));
        else if (ordered.reached) tell(one, "sent", sentText(name, ordered.time_us));
        else end(one, "failed", `STOP ${name}: NOT SENT. Stop the vessel by other means; try again.`);
      },
      refused(why) {
        answered();
        end(one, "failed", `STOP ${name}: NOT SENT. ${why}`);
      },
      forgotten() {
        answered();
        end(one, "failed", `STOP ${name}: no answer in ten minutes. Nobody knows whether it was sent; it is not sent any more. Press STOP again if it is still wanted.`);
      },
      unanswered(why) {
        tell(one, "failed", `STOP ${name}: NOT SENT as far as is known. ${why} Trying again since ${since} … Stop it by other means.`);
        setText(away, "Give up");
        setAttribute(away, "aria-label", `Give up: STOP ${name}`);
      },
    });
    tidy();
  };
  /** Takes away the oldest orders beyond those that are shown. */
  const tidy = (): void => {
    const done = [...orders.children].filter((row) => !open.some((one) => one.root === row && one.asking));
    for (const row of done.reverse().slice(0, Math.max(0, orders.children.length - shown))) row.remove();
  };

  const button = (address: number, name: string): HTMLButtonElement => {
    const made = make("button", { type: "button", class: "halt" }, `STOP ${name}`);
    made.addEventListener("click", () => order(address, name));
    return made;
  };
  const form = root.querySelector("form");
  const main = make("span", { class: "aim" });
  const list = make("div", { class: "others" });
  const summary = make("summary", { class: "halt" }, "STOP …");
  const menu = make("details", { hidden: "" }, summary, list);
  if (form) {
    form.addEventListener("submit", (event) => {
      // Before the script knows its vessel, the form goes as it is.
      if (!aim) return;
      event.preventDefault();
      order(aim.address, aim.name);
    });
  }
  const all = createStopAll((targets) => {
    shown = Math.max(SHOWN, targets.length);
    for (const { address, name } of targets) order(address, name);
  });
  root.append(...(form ? [menu, all.root] : [main, menu, all.root]));
  document.addEventListener("keydown", (event) => {
    // A chord, so that no slip of a finger stops a boat and no text field loses a letter.
    if (!(event.ctrlKey && event.key === ".") || event.repeat) return;
    event.preventDefault();
    if (aim) return order(aim.address, aim.name);
    // Where the page is about no vessel, somebody has to say which.
    if (menu.hasAttribute("hidden")) return;
    menu.open = true;
    list.querySelector("button")?.focus();
  });

  return {
    target(vessel) {
      if (vessel && !may(vessel.address)) vessel = undefined;
      if (aim?.address === vessel?.address && aim?.name === vessel?.name) return;
      aim = vessel;
      setAttribute(root, "data-aim", aim ? "" : null);
      for (const halt of form ? form.querySelectorAll(".halt") : []) if (aim) setText(halt, `STOP ${aim.name}`);
      if (!form) main.replaceChildren(...(aim ? [button(aim.address, aim.name)] : []));
      root.title = aim ? "Ends what the vessel does and stops its motors. Ctrl and . do the same." : "";
      others = "";
    },
    stopped(answer) {
      for (const one of open) one.asking?.heard(answer);
    },
    frame(frame) {
      for (const one of open) follow(one, frame);
      for (let at = open.length - 1; at >= 0; at--) if (open[at]?.over) open.splice(at, 1);
    },
    vessels(systems) {
      const vessels = systems.filter((system) => may(system.address) && !isShore(system) && system.kind !== "CCU");
      const here = vessels.map((system) => `${system.address}/${systemName(system)}`).join("\n");
      if (here !== others) {
        const rest = vessels.filter((system) => system.address !== aim?.address);
        setAttribute(menu, "hidden", rest.length ? null : "");
        setText(summary, aim ? "Others …" : "STOP …");
        list.replaceChildren(...rest.map((system) => button(system.address, systemName(system))));
        others = here;
      }
      all.update(allToStop(vessels, given).map((system) => ({ address: system.address, name: systemName(system) })));
    },
  };
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
    end(order, "failed", `STOP ${order.name}: ${ordered.reached ? "NO EFFECT SEEN" : "NOT SENT"}: ${last.text}. Stop the vessel by other means; try again.`);
    return undefined;
  }
  if (ordered.waits && frame.now_us > ordered.time_us + WAITS_US) end(order, "failed", `STOP ${order.name}: the vessel was not heard in ten minutes; it is not sent any more.`);
  return ordered.waits ? undefined : ordered;
}

/** What the vessel has probably not heard. */
function waitsText(name: string, { reached, time_us }: Ordered): string {
  const until = utc(time_us + WAITS_US, false);
  return reached
    ? `STOP ${name}: sent ${utc(time_us, false)}, but the vessel is silent. It is sent again as soon as the vessel is heard, until ${until}. Until then stop it by other means.`
    : `STOP ${name}: NOT SENT YET. No way leads to the vessel. It is sent as soon as the vessel is heard, until ${until}. Until then stop it by other means.`;
}

function sentText(name: string, timeUs: number): string {
  return `STOP ${name}: accepted, sent ${utc(timeUs, false)}; waiting for the vessel to say that it stopped …`;
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
  if (order.effectS !== undefined) {
    if (took > WATCHED_S) order.over = true;
    // Two lines tell of the vessel, and the slower one may still tell what was before.
    else if (state && state.received_us > order.effectUs && !["ERROR", "SERVICE", "BOOT"].includes(mode)) {
      end(order, "failed", `STOP ${order.name}: stopped after ${order.effectS.toFixed(1)} s, but GOES ON since ${utc(state.received_us, false)}: mode ${mode}. It was started again.`);
    }
  } else if (mode === "ERROR") {
    order.effectS = took;
    order.effectUs = state?.received_us ?? 0;
    tell(order, "done", `STOP ${order.name}: stopped after ${took.toFixed(1)} s. Motors off, drifting.`);
  } else if (took > EFFECT_S) {
    const said = state ? `it says mode ${mode}` : "it does not say that it stopped";
    tell(order, "failed", `STOP ${order.name}: sent, but NO EFFECT SEEN in ${EFFECT_S} s; ${said}. Press STOP again or stop it by other means.`);
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
