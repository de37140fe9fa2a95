// Who has control: told to all, asked for, given, kept, taken over.

import { reason } from "../api/http";
import type { LeaseAction } from "../api/types.gen";
import { type ControlState, type Part, partOf, whoHas } from "../state/control";
import { make, setAttribute, setText } from "../ui/dom";
import { t } from "../words/words";
import type { Confirm } from "./confirm";
import type { Orders } from "./orders";

export interface LeaseView {
  update(state: ControlState, nowUs: number): Part;
}

export function createLeaseView(root: HTMLElement, me: string, key: string, may: boolean, orders: Orders, confirm: Confirm, failed: (text: string) => void): LeaseView {
  const who = make("p", { class: "who", role: "status", tabindex: "-1" });
  const asked = make("div", { class: "asked", role: "status" });
  const left = make("p", { class: "left" });
  const why = make("input", { type: "text", maxlength: "200" });
  const whyBox = make("label", { class: "why" }, `${t("Reason, for the one who has control")} `, why);
  const row = make("div", { class: "row" });
  root.append(who, asked, left, whyBox, row);
  let part: Part = "free";
  let drawn = "";
  let overTaken: string | undefined;
  const ask = async (action: LeaseAction, text = ""): Promise<void> => {
    failed("");
    try {
      await orders.lease(action, text);
      why.value = "";
    } catch (error) {
      failed(reason(error));
    }
  };
  const button = (text: string, act: () => void, kind = ""): HTMLButtonElement => {
    const made = make("button", { type: "button", ...(kind ? { class: kind } : {}) }, text);
    made.addEventListener("click", act);
    return made;
  };
  const takeOver = (from: string): void => {
    const text = why.value.trim();
    if (!text) {
      failed(t("Enter a reason for taking over: {from} will see it.", { from }));
      why.focus();
      return;
    }
    overTaken = from;
    confirm.ask(t("Take over?"), [t("{from} loses control at once and sees: {text}", { from, text }), t("A plan goes on until you order something else. A vessel that is steered by hand stops, and is not steered by hand any more.")], t("Take over now"), () => void ask("take", text));
  };

  return {
    update({ lease }, nowUs) {
      part = partOf(lease, me, key);
      setText(who, whoHas(lease, part));
      const { holder, waiting } = lease ?? {};
      // What was to be confirmed named somebody else.
      if (overTaken !== undefined && holder?.name !== overTaken) {
        overTaken = undefined;
        confirm.close();
      }
      const mine = part === "here" || part === "elsewhere";
      const request = waiting ? `${waiting.name === me ? t("You ask for control") : t("{name} asks for control", { name: waiting.name })}${waiting.reason ? `: ${waiting.reason}` : "."}` : "";
      setText(asked, request);
      setAttribute(asked, "data-mine", waiting && mine ? "" : null);
      const seconds = (until: number): number => Math.max(0, Math.round((until - nowUs) / 1e6));
      setText(left, waiting ? t("Without an answer it is granted in {seconds} s.", { seconds: seconds(waiting.granted_us) }) : holder && !mine ? t("Expires in {seconds} s unless renewed.", { seconds: seconds(holder.until_us) }) : "");
      setAttribute(whyBox, "hidden", may && (part === "other" || part === "waiting") ? null : "");
      const now = `${part}/${waiting?.name ?? ""}/${holder?.name ?? ""}`;
      if (now === drawn) return part;
      drawn = now;
      const buttons: HTMLButtonElement[] = [];
      if (may && waiting && mine) buttons.push(button(t("Grant to {name}", { name: waiting.name }), () => void ask("grant"), "main"), button(t("Decline"), () => void ask("decline")));
      if (may && part === "free") buttons.push(button(t("Take control"), () => void ask("request"), "main"));
      if (may && part === "elsewhere") buttons.push(button(t("Take control here"), () => void ask("request"), "main"));
      if (may && part === "other") buttons.push(button(t("Ask for control"), () => void ask("request", why.value.trim()), "main"));
      if (may && part === "waiting") buttons.push(button(t("Withdraw the request"), () => void ask("decline")));
      if (may && holder && (part === "other" || part === "waiting")) buttons.push(button(t("Take over …"), () => takeOver(holder.name), "danger"));
      if (may && mine) buttons.push(button(t("Release control"), () => void ask("release")));
      const focused = row.contains(document.activeElement) ? document.activeElement?.textContent : null;
      row.replaceChildren(...buttons);
      // Never another button under the same finger: a key that was on its way would grant what was just asked for.
      if (focused !== null) (buttons.find((one) => one.textContent === focused) ?? who).focus();
      return part;
    },
  };
}
