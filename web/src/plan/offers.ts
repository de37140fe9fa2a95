// What is offered where two states of a plan meet: this browser's and the server's, or one's own and somebody else's.

import type { StoredPlan } from "../api/types.gen";
import { make } from "../ui/dom";
import { utc } from "../ui/format";
import { t } from "../words/words";
import type { Keeping, Left } from "./keeper";

/** A question with its answers; each takes it away, unless it answers false. */
function ask(root: HTMLElement, kind: string, text: string, answers: readonly (readonly [string, () => unknown, string?])[]): void {
  const buttons = answers.map(([words, act, look]) => {
    const made = make("button", { type: "button", ...(look ? { class: look } : {}) }, words);
    made.addEventListener("click", async () => {
      if ((await act()) !== false) root.replaceChildren();
    });
    return made;
  });
  root.replaceChildren(make("div", { class: `note ${kind}`, role: "alert" }, make("p", {}, text), make("div", { class: "row" }, ...buttons)));
}

export interface ConflictAnswers {
  /** Keeps one's own as another plan; answers whether that worked. */
  apart(): Promise<boolean>;
  theirs(): void;
  mine(): void;
}

/** Somebody else changed the plan meanwhile. */
export function offerConflict(root: HTMLElement, newer: StoredPlan, answers: ConflictAnswers): void {
  const text = t("{author} changed this plan at {time} (revision {revision}, {n} maneuvers) while you did. Nothing is lost: theirs is on the server, yours is here.", { author: newer.author, time: utc(newer.updated_us, false), revision: newer.revision, n: newer.plan.maneuvers.length });
  ask(root, "bad", text, [
    [t("Keep mine as a separate plan"), () => answers.apart()],
    [t("Use theirs"), () => answers.theirs()],
    [t("Replace theirs with mine"), () => answers.mine()],
  ]);
}

/** This browser holds a state that did not reach the server; `revision` is that of the server now. */
export function offerLeft(root: HTMLElement, left: Left, revision: number, take: () => void, drop: () => void): void {
  const other = left.revision === revision ? "" : ` ${t("Meanwhile the plan on the server changed from revision {from} to {to}.", { from: left.revision, to: revision })}`;
  ask(root, "warn", `${t("This browser has changes to the plan from {time} that did not reach the server.", { time: utc(left.savedMs * 1_000) })}${other}`, [[t("Go on with it"), take, "main"], [t("Forget it"), drop]]);
}

/** How it is kept, in words. */
export function keepingText(now: Keeping): string {
  switch (now.state) {
    case "kept":
      return t("Kept as draft {time}, revision {revision}", { time: utc(now.stored.updated_us, false), revision: now.stored.revision });
    case "saved":
      return `${t("Saved {time}, revision {revision}", { time: utc(now.stored.updated_us, false), revision: now.stored.revision })}${now.stored.check.guard?.outcome === "refused" ? `; ${t("the chart refuses it as it is")}` : ""}`;
    case "changed":
    case "keeping":
      return t("Keeping …");
    case "failed":
      return `${t("Not on the server: {text}", { text: now.text })} ${now.local ? t("It is kept in this browser") : t("THIS BROWSER COULD NOT KEEP IT EITHER: do not close the page")}${now.again ? `; ${t("trying again …")}` : "."}`;
    case "conflict":
      return t("Not on the server: somebody else changed the plan. Yours is kept in this browser.");
  }
}
