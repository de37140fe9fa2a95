// Why and where something was refused, by the codes of the refusal itself. Pure.

import type { GuardReason, PlanDocument, PlanPlace, RefusalReason } from "../api/types.gen";
import { t } from "../words/words";
import { depthText } from "./chart";
import { plainRefusal } from "./plainrefusal";
import { reasonWords, refusedText } from "./planverdict";

export interface RefusedSpot {
  /** Which leg does what. */
  readonly text: string;
  /** The same in two words, for the map. */
  readonly label: string;
  readonly place: PlanPlace;
  /** The leg, where it is known. */
  readonly from?: PlanPlace;
  readonly to?: PlanPlace;
}

const CODES: Readonly<Record<string, string>> = {
  land: t("land"),
  obstacle: t("obstacle"),
  "unknown-depth": t("depth unknown"),
  "no-data": t("no chart"),
  "too-low": t("too low overhead"),
  "too-shallow": t("too shallow"),
  "too-shallow-alone": t("too shallow"),
  "entry-prohibited": t("entry prohibited"),
  "entry-restricted": t("entry restricted"),
};

/** What a code of the guard is called. */
export function spotName(code: string): string {
  return CODES[code] ?? code;
}

/** What is wrong at a spot, for the map. */
export function spotLabel({ code, depth_m }: GuardReason): string {
  return `${spotName(code)}${depth_m === null ? "" : `, ${depthText(depth_m)}`}`;
}

/** The spots of refused legs. */
export function spotsOf(reasons: readonly GuardReason[], plan?: PlanDocument): RefusedSpot[] {
  return reasons.map((one) => {
    // Of turns and circles the ends are no line that is sailed.
    const line = one.from && one.to && (one.part === "transit" || one.part === "track") ? { from: one.from, to: one.to } : {};
    return { text: reasonWords(plan, one), label: spotLabel(one), place: { lat_deg: one.lat_deg, lon_deg: one.lon_deg }, ...line };
  });
}

/** An order to go somewhere is a plan of these two: the way, and staying there. */
const STAY = "stay";

/** The legs of an order to go somewhere as people say them: the way to the chosen place, and the place itself once. */
export function legsOfGoto(reasons: readonly GuardReason[]): GuardReason[] {
  const maneuver = t("the chosen place");
  const way = reasons.filter((one) => one.maneuver !== STAY).map((one) => ({ ...one, maneuver }));
  const place = reasons.find((one) => one.maneuver === STAY);
  return place ? [...way, { ...place, maneuver, part: "place", from: null, to: null }] : way;
}

/** Why something was refused, in the person's language. What the catalogue lacks is said as the server said it. */
export function refusalText(why: RefusalReason, plan?: PlanDocument): string {
  return why.guard ? t("The chart shows danger: {text}", { text: refusedText(plan, why.guard) }) : plainRefusal(why);
}
