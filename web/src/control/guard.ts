// The vessel's guard against grounding while somebody steers by hand: what it says, and how an operator lifts it for a
// while, such as to go to a quay. The vessel wants the same time twice; both stand in the audit log and its log book.

import { reason } from "../api/http";
import { type Guard, GUARD_ENTITY } from "../state/guard";
import { make, setAttribute, setText } from "../ui/dom";
import { t } from "../words/words";
import type { Confirm } from "./confirm";
import type { Orders } from "./orders";

/** The guard is lifted for so long at once, s. */
const LIFTED_S = 60;

export interface GuardView {
  update(guard: Guard | undefined): void;
}

export function createGuard(root: HTMLElement, orders: Orders, confirm: Confirm, name: () => string): GuardView {
  const text = make("p", { role: "status" });
  const lift = make("button", { type: "button" }, t("Steer unguarded …"));
  const restore = make("button", { type: "button", class: "main" }, t("Guard again"));
  const failed = make("p", { class: "note bad", role: "alert", hidden: "" });
  root.append(text, make("div", { class: "row" }, lift, restore), failed);
  let now: Guard | undefined;

  const set = (parameter: string, seconds: number): Promise<unknown> => orders.ask({ kind: "parameters.set", entity: GUARD_ENTITY, values: [{ name: parameter, value: String(seconds) }] });
  const act = (what: string, work: () => Promise<unknown>): void => {
    setAttribute(failed, "hidden", "");
    work().catch((error: unknown) => {
      setText(failed, `${what}: ${error instanceof Error ? error.message : reason(error)}`);
      setAttribute(failed, "hidden", null);
    });
  };
  lift.addEventListener("click", () => {
    const lines = [t("Vessel: {name}", { name: name() }), t("The sea chart aboard says: {text}", { text: now?.text ?? t("nothing") }), t("For {seconds} s nothing holds your thrust back from land and shoals. You look out yourself.", { seconds: LIFTED_S }), t("It is written into the audit log in your name.")];
    confirm.ask(t("Steer {name} unguarded?", { name: name() }), lines, t("Steer unguarded for {seconds} s", { seconds: LIFTED_S }), () =>
      act(t("The guard stays"), async () => {
        await set("Override Request", LIFTED_S);
        await set("Override Confirmation", LIFTED_S);
      }),
    );
  });
  restore.addEventListener("click", () => act(t("Unknown whether the guard is back"), () => set("Override Request", 0)));

  return {
    update(guard) {
      now = guard;
      setAttribute(root, "hidden", guard ? null : "");
      if (!guard) return;
      setText(text, `${guard.blocks ? t("BLOCKED") : guard.lifted ? t("UNGUARDED") : t("Guarded by the sea chart")}: ${guard.text}`);
      setAttribute(root, "data-guard", guard.blocks ? "blocks" : guard.lifted ? "lifted" : "watches");
      setAttribute(lift, "hidden", guard.lifted ? "" : null);
      setAttribute(restore, "hidden", guard.lifted ? null : "");
    },
  };
}
