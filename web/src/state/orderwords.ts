// Orders and what becomes of them, as people say it: pure.

import type { CommandStep } from "../api/types.gen";
import { t, worded } from "../words/words";

const ORDERS: Readonly<Record<string, string>> = {
  "vessel.abort": t("STOP"),
  "plan.start": t("Start plan"),
  "plan.stop": t("Stop plan"),
  "goto": t("Go to"),
  "teleop.begin": t("Steer by hand"),
  "teleop.end": t("End steering by hand"),
  "plan.upload": t("Upload plan"),
  "plan.delete": t("Delete plan aboard"),
  "plan.list": t("List plans aboard"),
  "plan.get": t("Fetch plan"),
  "parameters.query": t("Read parameters"),
  "parameters.set": t("Set parameters"),
  "parameters.save": t("Save parameters"),
};

const STAGES: Readonly<Record<string, string>> = { "effect seen": t("done"), "asked": t("asked"), "accepted": t("accepted"), "waiting": t("waiting"), "sent": t("sent"), "executing": t("executing"), "refused": t("refused"), "expired": t("expired"), "received": t("received by the vessel"), "timed out": t("timed out without an effect") };

/** An order by its code. */
export function orderText(code: string): string {
  return ORDERS[code] ?? code;
}

/** What is said of a stage: why, or what the vessel said, whose own words have no wording and stay as they are. */
export function stepText({ text, says, late }: Pick<CommandStep, "text" | "says" | "late">): string {
  if (!late) return says ? worded({ text, says }) : text;
  // Its English says so itself.
  return text === "late" ? t("late") : says ? t("late: {why}", { why: worded({ text, says }) }) : text;
}

/** A stage by its code, with what is said of it. */
export function stageInFull(step: CommandStep): string {
  return [stageText(step.stage), stepText(step)].filter(Boolean).join(": ");
}

/** A stage by its code. */
export function stageText(code: string): string {
  return STAGES[code] ?? code;
}
