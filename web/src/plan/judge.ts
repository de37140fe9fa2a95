// What a plan takes and what is wrong with it: asked of the server soon after each change, and told beside the map.

import { postJson, Refusal } from "../api/http";
import type { GuardReason, PlanCheck, PlanDocument, PlanLeg, PlanPlace, PlanTrouble } from "../api/types.gen";
import { wayOfAll } from "../state/plan";
import { troubleText } from "../state/plantrouble";
import type { Judgement } from "../state/planverdict";
import { make, setText } from "../ui/dom";
import { t, tn } from "../words/words";
import { rebuilt } from "./fields";
import type { Profile } from "./profile";
import { durationText, energyText, lengthText } from "./steps";
import type { VerdictOnMap } from "./verdict";

/** What is drawn is judged this long after the last change, ms. */
const CHECK_MS = 200;
const PATIENCE_MS = 10_000;
/** Problems and warnings of one kind that are listed. */
const LISTED = 20;

export interface JudgeNeeds {
  readonly totals: HTMLElement;
  readonly troubles: HTMLElement;
  readonly verdict: VerdictOnMap;
  readonly profile: Pick<Profile, "update">;
  /** As it is drawn. */
  plan(): PlanDocument;
  /** The answer is there. */
  judged(check: PlanCheck): void;
  /** What is known of the verdict by now. */
  told(now: Judgement): void;
  /** Leads to a place. */
  go(place: PlanPlace): void;
  /** Looks for a way around a refused leg, where the plan may be changed. */
  readonly around: ((reason: GuardReason) => void) | undefined;
}

export interface Judge {
  /** Asks soon. */
  ask(): void;
  show(check: PlanCheck): void;
  readonly legs: () => readonly PlanLeg[];
}

export function createJudge(needs: JudgeNeeds, first: PlanCheck): Judge {
  const { totals, troubles, verdict, profile, plan } = needs;
  let check = first;
  let settle: number | undefined;
  // Of several questions the last one counts, also while it is not yet put.
  let asked = 0;
  const ask = async (): Promise<void> => {
    const number = asked;
    try {
      const answer = await postJson<PlanCheck>("/api/v1/plans/check", PATIENCE_MS, plan());
      // Where there are problems, what was laid out before is nearer to the truth than nothing.
      if (number === asked) show({ ...answer, maneuvers: answer.maneuvers.length ? answer.maneuvers : check.maneuvers });
    } catch (error) {
      if (number !== asked) return;
      setText(totals, t("Length, time and energy are not known"));
      rebuilt(troubles, make("p", { class: "note warn" }, error instanceof Refusal ? error.message : t("The server cannot be reached: the plan is not judged.")));
      needs.told({ kind: "failed", text: error instanceof Refusal ? error.message : t("no server") });
    }
  };
  const empty = (): void => {
    // That there is nothing yet is no problem to shout about.
    setText(totals, t("Nothing is drawn yet"));
    totals.removeAttribute("data-bad");
    troubles.replaceChildren();
    verdict.update(plan(), [], null);
    profile.update([]);
  };
  const show = (answer: PlanCheck): void => {
    check = answer;
    needs.told({ kind: "known", check: answer });
    if (!plan().maneuvers.length) return empty();
    const { guard, problems, warnings, maneuvers } = answer;
    setText(totals, totalText(answer, plan().repeat));
    totals.toggleAttribute("data-bad", problems.length > 0 || guard?.outcome === "refused");
    rebuilt(troubles, ...box("bad", t("Problems"), problems), ...verdict.list(plan(), guard, needs.go, needs.around), ...box("warn", t("Good to know"), warnings));
    verdict.update(plan(), maneuvers, guard);
    profile.update(wayOfAll(plan(), maneuvers));
    needs.judged(answer);
  };
  return {
    ask() {
      window.clearTimeout(settle);
      asked++;
      needs.told({ kind: "asked" });
      settle = window.setTimeout(() => void ask(), CHECK_MS);
    },
    show,
    legs: () => check.maneuvers,
  };
}

/** What it takes in a line, or how many problems it has. */
export function totalText({ total: { length_m, duration_s, energy_j }, problems, guard }: Pick<PlanCheck, "total" | "problems" | "guard">, repeats: boolean): string {
  if (problems.length) return tn(problems.length, "1 problem: cannot be sailed as it is", "{n} problems: cannot be sailed as it is");
  const takes = t("{length} · {duration} · {energy} (estimate)", { length: lengthText(length_m), duration: durationText(duration_s), energy: energyText(energy_j) });
  return `${repeats ? `${t("Per lap:")} ` : ""}${takes}${guard?.outcome === "refused" ? `: ${t("refused by the chart")}` : ""}`;
}

function box(kind: string, title: string, all: readonly PlanTrouble[]): HTMLElement[] {
  if (!all.length) return [];
  const words = all.slice(0, LISTED).map((one) => (one.maneuver === null ? troubleText(one) : `${one.maneuver}: ${troubleText(one)}`));
  return [make("div", { class: `note ${kind}` }, make("strong", {}, title), make("ul", {}, ...words.map((text) => make("li", {}, text))))];
}
