// What was ordered lately, and how far each got.

import type { Command, CommandStep } from "../api/types.gen";
import { orderText, stageText, stepText } from "../state/orderwords";
import { reasonInFull } from "../state/planverdict";
import { legsOfGoto } from "../state/refusal";
import { make, setAttribute, setText } from "../ui/dom";
import { utc } from "../ui/format";
import { t } from "../words/words";

export interface CommandList {
  update(commands: readonly Command[]): void;
}

/** `heard` is a polite live region that tells how the newest command goes on. */
export function createCommandList(root: HTMLElement, heard: HTMLElement): CommandList {
  const list = make("ol", { class: "commands", "aria-label": t("Recent commands") });
  const empty = make("p", { class: "empty" }, t("Nothing was ordered since the server started."));
  root.append(make("h3", {}, t("Recent commands")), empty, list);
  let shown: readonly Command[] = [];
  return {
    update(commands) {
      if (commands === shown) return;
      const mine = shown.length > 0;
      shown = commands;
      empty.hidden = commands.length > 0;
      list.replaceChildren(...commands.map(row));
      const newest = commands.find((one) => !one.order.endsWith(".list") && !one.order.endsWith(".get"));
      const last = newest?.steps.at(-1);
      if (!newest || !last || !mine) return;
      setText(heard, `${[orderText(newest.order), newest.subject].join(" ").trim()}: ${[stageText(last.stage), stepWords(newest.order, last)].filter(Boolean).join(", ")}`);
      setAttribute(heard, "data-stage", stageOf(newest));
    },
  };
}

function stageOf(command: Command): "open" | "done" | "failed" {
  const last = command.steps.at(-1);
  const good = last?.stage === "effect seen" || (command.over && last?.stage === "received");
  return !command.over ? "open" : good ? "done" : "failed";
}

/** Why, or what the vessel said; of a leg that it refused, the leg. */
function stepWords(order: string, step: CommandStep): string {
  const { leg } = step;
  return leg ? reasonInFull(undefined, (order === "goto" ? legsOfGoto([leg])[0] : undefined) ?? leg) : stepText(step);
}

function row(command: Command): HTMLElement {
  const steps = command.steps.map((step) =>
    make("li", {}, make("span", { class: "num" }, utc(step.time_us, false)), ` ${stageText(step.stage)}`, step.text ? make("span", { class: "why" }, ` ${stepWords(command.order, step)}`) : ""),
  );
  return make(
    "li",
    { "data-stage": stageOf(command), "data-order": command.order },
    make("p", {}, make("strong", {}, orderText(command.order)), ` ${command.subject} `, make("span", { class: "by" }, t("by {by}", { by: command.by }))),
    make("ol", { class: "steps" }, ...steps),
    make("p", { class: "number" }, t("Command {id}", { id: String(command.id) })),
  );
}
