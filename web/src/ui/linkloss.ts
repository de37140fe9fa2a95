// The link-loss panel of a vessel: three ages, and what the vessel will do without the link and when.

import { reason } from "../api/http";
import type { Command, System } from "../api/types.gen";
import { createOrders, Unanswered, windowKey } from "../control/orders";
import type { LinkLoss } from "../state/linkloss";
import { t } from "../words/words";
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
  const settings = make("p", { class: "dim" }, t("Its settings for this have not been read."));
  const ask = make("button", { type: "button" }, t("Read its settings"));
  root.append(make("p", {}, title, " ", ages), will, settings, ...(may ? [make("div", { class: "row" }, ask)] : []));
  const orders = createOrders(address, windowKey());
  let entity: string | null = null;
  ask.addEventListener("click", () => {
    if (entity === null) return;
    setText(settings, t("Reading …"));
    orders.ask({ kind: "parameters.query", entity }).then(
      ({ parameters }) => setText(settings, parameters?.length ? t("Set aboard: {settings}.", { settings: parameters.map(({ name, value }) => `${name} = ${value || t("none")}`).join("; ") }) : t("The vessel reported no settings.")),
      (error: unknown) => setText(settings, t("Its settings are not known: {why}", { why: error instanceof Unanswered ? error.message : reason(error) })),
    );
  });
  return {
    update(system, loss, commands, nowUs, linked) {
      entity = loss.entity;
      ask.disabled = entity === null;
      const silent = !linked || !system || system.liveness === "lost";
      setAttribute(root, "data-lost", silent || loss.lost ? "" : null);
      setText(title, silent ? t("Link lost.") : loss.lost ? t("The vessel hears no console.") : t("Link up."));
      const since = (us: number | undefined | null): string => (us ? t("{age} ago", { age: age(Math.max(0, (nowUs - us) / 1e6)) }) : t("never"));
      const answered = commands.flatMap((one) => one.steps.filter(({ stage }) => ["received", "executing", "effect seen"].includes(stage)).map(({ time_us }) => time_us));
      setText(ages, t("Last message {heard} · last position {placed} · last command answered {answered}", { heard: since(system?.heard_us), placed: since(loss.placeUs), answered: since(answered.length ? Math.max(...answered) : null) }));
      setText(will, whatItWillDo(loss, nowUs));
    },
  };
}

function whatItWillDo({ entity, words, next, now, saidUs, dueUs, lost }: LinkLoss, nowUs: number): string {
  if (entity === null) return t("Unknown what it will do without the link: it has reported no supervisor for lost communications.");
  if (saidUs === null || !words) return t("Unknown what it will do without the link: {entity} has reported nothing.", { entity });
  const left = dueUs === null ? "" : ` ${dueUs > nowUs ? t("That is in {span}.", { span: span((dueUs - nowUs) / 1e6) }) : t("That was {span} ago: it does so now unless it hears a console.", { span: span((nowUs - dueUs) / 1e6) })}`;
  const at = dueUs === null ? "" : ` ${t("at {time}", { time: utc(dueUs, false) })}`;
  if (lost && now !== undefined) {
    return `${now}${next === undefined ? "" : ` ${t("Next: {next}.", { next: `${next}${at}` })}`}${left} ${t("{entity} reported this {said}.", { entity, said: utc(saidUs, false) })}`;
  }
  // Of older vessels its sentence says more without the link: what it does now, what was not possible, and why.
  if (next !== undefined && !lost) {
    return `${t("Without the link it will {next}.", { next: `${next}${at}` })}${left} ${t("{entity} reported this {said}.", { entity, said: utc(saidUs, false) })}`;
  }
  // Words of a Lutra vessel that hears a console begin so; whether it still does is not what they are read for.
  const then = words.replace(/^(in contact|not heard for [^;]*); without: /, "");
  const values = { entity, said: utc(saidUs, false), then };
  const told = then === words ? t("What it will do without the link, as its {entity} reported {said}: {then}.", values) : t("What it will do without the link, as its {entity} reported {said}, while it heard a console: {then}.", values);
  return told + left;
}

function span(seconds: number): string {
  const whole = Math.round(seconds);
  return whole < 120 ? `${whole} s` : `${Math.floor(whole / 60)} min ${whole % 60} s`;
}
