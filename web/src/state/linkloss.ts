// What a vessel will do without the link, by what its own supervisor for lost communications reports: codes, of which words
// are made here, or of vessels without them their sentence.

import type { Update } from "../api/types.gen";
import { placeCameUs } from "./fleet";
import { type PartValues, partValues } from "./partvalues";
import { t } from "../words/words";
import { type Labels, meaning, type Values } from "./vitals";

export interface LinkLoss {
  /** Label of the supervisor; null where the vessel has told of none. */
  readonly entity: string | null;
  /** What it said last; empty for nothing. */
  readonly words: string;
  /** What it does next, in the page's words; undefined where it has reported no code for it. */
  readonly next: string | undefined;
  /** What it has begun to do, and how that stands, in the page's words; undefined where it has reported no code for it. */
  readonly now: string | undefined;
  /** When that came, µs since 1970 UTC. */
  readonly saidUs: number | null;
  /** When it acts next, as it said, µs since 1970 UTC; null where it named no time. */
  readonly dueUs: number | null;
  /** Whether it says that no console is heard. */
  readonly lost: boolean;
  /** When its place came last, by the server's clock like all ages, µs since 1970 UTC; null for never. */
  readonly placeUs: number | null;
}

const UNKNOWN: LinkLoss = { entity: null, words: "", next: undefined, now: undefined, saidUs: null, dueUs: null, lost: false, placeUs: null };

export function linkLoss(values: Values, labels: Labels): LinkLoss {
  const found = [...labels].find(([, label]) => /lost ?comm/i.test(label));
  const placeUs = placeCameUs(values);
  if (!found) return { ...UNKNOWN, placeUs };
  const [number, entity] = found;
  const state = [...values.values()].find((one) => one.abbrev === "EntityState" && one.entity === number);
  if (!state) return { ...UNKNOWN, entity, placeUs };
  const words = said(state);
  const told = partValues(values, number);
  return { entity, words, next: deed(told, "then", "plan"), now: now(told, words), saidUs: state.received_us, dueUs: due(told), lost: meaning(state, "state") !== "NORMAL", placeUs };
}

function said(state: Update): string {
  const value = state.fields.find((field) => field.name === "description")?.value;
  return typeof value === "string" ? value : "";
}

/** When it acts next, by the vessel's clock. */
function due(said: PartValues | undefined): number | null {
  const due_s = said?.values.get("due_s");
  return said && due_s ? said.timeUs + Number(due_s) * 1e6 : null;
}

const NEXT: Readonly<Record<string, string>> = {
  nothing: t("do nothing further"),
  carry_on: t("carry on"),
  hold: t("hold station"),
  stop: t("stop its motors and drift"),
};

/** The code of a deed in words; see `crates/onboard/src/supervise/next.rs`. */
function deed(said: PartValues | undefined, name: string, planName: string): string | undefined {
  const [code, plan] = [said?.values.get(name) ?? "", said?.values.get(planName)];
  return code === "run" && plan ? t("run plan {plan}", { plan }) : NEXT[code];
}

/** What a vessel says that has nothing to add to its codes: how it does something would be a part of its own. */
const PLAIN = /^no console is heard; [^;]*; next: [^;]*$/;

/** What it has begun to do, and its own sentence where that says more, such as how. */
function now(told: PartValues | undefined, words: string): string | undefined {
  const text = stands(told, words);
  const more = text !== undefined && told?.values.get("stands") !== "waits" && words && !PLAIN.test(words);
  return more ? `${text} ${t("Its words: {words}.", { words })}` : text;
}

/** How what it has begun to do stands; why that is not possible only its sentence says. */
function stands(said: PartValues | undefined, words: string): string | undefined {
  const deedNow = deed(said, "now", "now_plan");
  if (deedNow === undefined) return undefined;
  switch (said?.values.get("stands")) {
    case "holds":
      return t("It does this now: {deed}.", { deed: deedNow });
    case "outranked":
      return t("Another of its safeguards, as strong or stronger, is in force now: {deed}.", { deed: deedNow });
    case "blind":
      return t("It waits for a position with its motors stopped, then does this: {deed}.", { deed: deedNow });
    case "waits":
      return t("It tries to do this and cannot at present: {deed}. Its words: {words}.", { deed: deedNow, words });
    case "at_rest":
      return t("It would do this, but not before an operator has set it in motion: {deed}.", { deed: deedNow });
    case "settled":
      return t("It has done this, or an operator decided otherwise: {deed}.", { deed: deedNow });
    default:
      return undefined;
  }
}
