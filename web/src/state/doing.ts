// What a vessel does, in words: pure.

import { t } from "../words/words";
import type { Reading } from "./vitals";

/** A maneuver of the plan that runs. */
interface Leg {
  readonly id: string;
}

const MODES: Readonly<Record<string, string>> = {
  SERVICE: t("Ready"),
  CALIBRATION: t("Calibrating"),
  ERROR: t("Error"),
  EXTERNAL: t("External control"),
  BOOT: t("Starting"),
};

/** Whether a plan runs. */
export function runs(plan: Pick<Reading, "word">): boolean {
  return /^(EXECUTING|INITIALIZING)$/i.test(plan.word);
}

const PLAN_STATES: Readonly<Record<string, string>> = {
  BLOCKED: t("blocked"),
  READY: t("not running"),
  INITIALIZING: t("starting"),
  EXECUTING: t("running"),
};

/** The state of a plan, in words; a state that IMC does not define stands in the vessel's own word. */
export function planStateText(word: string): string {
  return PLAN_STATES[word.toUpperCase()] ?? word.toLowerCase();
}

/** What a vessel says of a stop: by whom, as an address. */
const STOPPED = /^stopped by 0x[0-9a-f]{4}$/i;

/** What the vessel says that it does. After a stop it is in IMC's mode of errors, though nothing is wrong. */
export function doing(mode: Pick<Reading, "word" | "ageS" | "note">, plan: Pick<Reading, "word">): string {
  if (mode.ageS === null) return t("State not reported");
  if (mode.word.toUpperCase() === "ERROR" && STOPPED.test(mode.note)) return t("Stopped");
  if (mode.word.toUpperCase() !== "MANEUVER") return MODES[mode.word.toUpperCase()] ?? mode.word;
  return runs(plan) ? t("Executing plan") : t("Executing maneuver");
}

/** Why the vessel is as it is, or what ended its last plan: who stopped it is among the commands, by name. */
export function whyText({ word, note }: Pick<Reading, "word" | "note">): string {
  if (!STOPPED.test(note)) return note;
  return word.toUpperCase() === "ERROR" ? t("after an order to stop") : t("last plan ended by a stop");
}

/** How far the plan is: the maneuver and how many there are, else its share, `unknown` before the vessel says either; empty while none runs. */
export function progressText(plan: Pick<Reading, "word">, progress: Pick<Reading, "value" | "note">, legs: readonly Leg[] | undefined, unknown = t("not reported")): string {
  if (!runs(plan)) return "";
  const at = legs?.findIndex(({ id }) => id === progress.note) ?? -1;
  if (legs && at >= 0) return t("{at} of {all}", { at: at + 1, all: legs.length });
  return progress.value === null ? unknown : `${progress.value.toFixed(0)} %`;
}
