// What is offered where two states of a plan meet: this browser's and the server's, or one's own and somebody else's.

import type { StoredPlan } from "../api/types.gen";
import { make } from "../ui/dom";
import { utc } from "../ui/format";
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
  const text = `${newer.author} changed this plan at ${utc(newer.updated_us, false)} (revision ${newer.revision}, ${newer.plan.maneuvers.length} maneuvers) while you did. Nothing is lost: theirs is on the server, yours is here.`;
  ask(root, "bad", text, [
    ["Keep mine as a plan of its own", () => answers.apart()],
    ["Go on with theirs", () => answers.theirs()],
    ["Put mine over theirs", () => answers.mine()],
  ]);
}

/** This browser holds a state that did not reach the server; `revision` is that of the server now. */
export function offerLeft(root: HTMLElement, left: Left, revision: number, take: () => void, drop: () => void): void {
  const other = left.revision === revision ? "" : ` Meanwhile the plan on the server went on from revision ${left.revision} to ${revision}.`;
  ask(root, "warn", `This browser holds a state of the plan from ${utc(left.savedMs * 1_000)} that did not reach the server.${other}`, [["Go on with it", take, "main"], ["Forget it", drop]]);
}

/** How it is kept, in words. */
export function keepingText(now: Keeping): string {
  switch (now.state) {
    case "kept":
      return `Kept as draft ${utc(now.stored.updated_us, false)}, revision ${now.stored.revision}`;
    case "saved":
      return `Saved ${utc(now.stored.updated_us, false)}, revision ${now.stored.revision}${now.stored.check.guard?.outcome === "refused" ? "; the chart refuses it as it is" : ""}`;
    case "changed":
    case "keeping":
      return "Keeping …";
    case "failed":
      return `Not on the server: ${now.text} ${now.local ? "It is kept in this browser" : "THIS BROWSER COULD NOT KEEP IT EITHER: do not close the page"}${now.again ? "; trying again …" : "."}`;
    case "conflict":
      return "Not on the server: somebody else changed the plan. Yours is kept in this browser.";
  }
}
