// The link-loss panel of a vessel: three ages, and what the vessel will do without the link and when.

import { reason } from "../api/http";
import type { Command, System } from "../api/types.gen";
import { createOrders, Unanswered, windowKey } from "../control/orders";
import type { LinkLoss } from "../state/linkloss";
import { make, setAttribute, setText } from "./dom";
import { age, utc } from "./format";

export interface LinkLossPanel {
  update(system: System | undefined, loss: LinkLoss, commands: readonly Command[], nowUs: number, linked: boolean): void;
}

/** `may`: whether the person may ask the vessel for its settings. */
export function createLinkLoss(root: HTMLElement, address: number, may: boolean): LinkLossPanel {
  const title = make("strong");
  const ages = make("span", { class: "num" });
  const will = make("p");
  const settings = make("p", { class: "dim" }, "Its settings for this were not asked for.");
  const ask = make("button", { type: "button" }, "Ask for its settings");
  root.append(make("p", {}, title, " ", ages), will, settings, ...(may ? [make("div", { class: "row" }, ask)] : []));
  const orders = createOrders(address, windowKey());
  let entity: string | null = null;
  ask.addEventListener("click", () => {
    if (entity === null) return;
    setText(settings, "Asking …");
    orders.ask({ kind: "parameters.query", entity }).then(
      ({ parameters }) => setText(settings, parameters?.length ? `Set aboard: ${parameters.map(({ name, value }) => `${name} = ${value || "none"}`).join("; ")}.` : "The vessel reported no settings."),
      (error: unknown) => setText(settings, `Its settings are not known: ${error instanceof Unanswered ? error.message : reason(error)}`),
    );
  });
  return {
    update(system, loss, commands, nowUs, linked) {
      entity = loss.entity;
      ask.disabled = entity === null;
      const silent = !linked || !system || system.liveness === "lost";
      setAttribute(root, "data-lost", silent || loss.lost ? "" : null);
      setText(title, silent ? "Link lost." : loss.lost ? "The vessel hears no console." : "Link up.");
      const since = (us: number | undefined | null): string => (us ? `${age(Math.max(0, (nowUs - us) / 1e6))} ago` : "never");
      const answered = commands.flatMap((one) => one.steps.filter(({ stage }) => ["received", "executing", "effect seen"].includes(stage)).map(({ time_us }) => time_us));
      setText(ages, `Last message ${since(system?.heard_us)} · last position ${since(loss.placeUs)} · last order that it answered ${since(answered.length ? Math.max(...answered) : null)}`);
      setText(will, whatItWillDo(loss, nowUs));
    },
  };
}

function whatItWillDo({ entity, words, saidUs, dueUs }: LinkLoss, nowUs: number): string {
  if (entity === null) return "What it will do without the link is not known: it has reported no supervisor for lost communications.";
  if (saidUs === null || !words) return `What it will do without the link is not known: ${entity} has reported nothing.`;
  const left = dueUs === null ? "" : dueUs > nowUs ? ` That is in ${span((dueUs - nowUs) / 1e6)}.` : ` That time is past by ${span((nowUs - dueUs) / 1e6)}: it does so now unless it hears a console.`;
  // Words of a Lutra vessel that hears a console begin so; whether it still does is not what they are read for.
  const then = words.replace(/^(in contact|not heard for [^;]*); without: /, "");
  const heard = then === words ? "" : ", while it heard a console";
  return `What it will do without the link, as its ${entity} reported ${utc(saidUs, false)}${heard}: ${then}.${left}`;
}

function span(seconds: number): string {
  const whole = Math.round(seconds);
  return whole < 120 ? `${whole} s` : `${Math.floor(whole / 60)} min ${whole % 60} s`;
}
