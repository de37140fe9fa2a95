// The plan that the vessel of a page sails: drawn where it is known ashore, whoever started it, and else said.

import { getJson, postJson } from "../api/http";
import type { PlanUnderWay, RouteLeg, VesselQuery, VesselQuerySent } from "../api/types.gen";
import type { FleetMap } from "../map/map";
import { createRoute } from "../map/route";
import type { Vitals } from "../state/vitals";
import { make, setAttribute, setText } from "../ui/dom";
import { t, tn } from "../words/words";

const PATIENCE_MS = 8_000;
/** A plan that is not known yet is looked for again so often, ms: the vessel is asked, and may answer. */
const AGAIN_MS = 3_000;
/** How often the vessel is asked at all. */
const ASKS = 3;

export interface UnderWay {
  /** `present`: whether the page shows the present; what is sailed then is not drawn over the past. */
  update(vitals: Pick<Vitals, "plan" | "progress">, present: boolean): void;
  /** The maneuvers of what is sailed, where they are known. */
  legs(): readonly RouteLeg[] | undefined;
}

export function createUnderWay(root: HTMLElement, map: FleetMap, address: number): UnderWay {
  const path = `/api/v1/vessels/${address}`;
  const line = make("p", { class: "under-way", role: "status", hidden: "" });
  root.append(line);
  const route = createRoute(map);
  let known: PlanUnderWay | null = null;
  /** What the vessel says it sails; a start of the same plan is another one. */
  let sails = "";
  let drawn = "";
  let [asks, timer]: [number, number | undefined] = [0, undefined];

  const look = async (wanted: string, plan: string): Promise<void> => {
    window.clearTimeout(timer);
    try {
      const now = await getJson<PlanUnderWay>(`${path}/plan`);
      if (wanted !== sails) return;
      known = now.plan_id === plan ? now : null;
      drawn = "";
      if (known?.source) return;
      if (known && asks < ASKS) {
        asks++;
        await postJson<VesselQuerySent>(`${path}/ask`, PATIENCE_MS, { about: "plan", plan_id: plan } satisfies VesselQuery);
      }
    } catch {
      // The next look tells; meanwhile nothing is drawn that is not known.
    }
    if (wanted === sails) timer = window.setTimeout(() => void look(wanted, plan), AGAIN_MS);
  };

  return {
    legs: () => known?.legs,
    update({ plan, progress }, present) {
      const runs = /^(EXECUTING|INITIALIZING)$/i.test(plan.word);
      const now = runs ? `${plan.note}\n${/^INIT/i.test(plan.word)}` : "";
      if (now !== sails) {
        [sails, known, asks] = [now, null, 0];
        drawn = "";
        window.clearTimeout(timer);
        if (now) void look(now, plan.note);
      }
      const shown = present && runs ? known : null;
      const maneuver = progress.note;
      const state = `${shown ? "" : "no"}${sails}\n${maneuver}\n${present}\n${plan.old}`;
      if (state === drawn) return;
      drawn = state;
      route.draw(shown?.source ? shown : null, maneuver);
      const at = shown?.legs.findIndex((leg) => leg.id === maneuver) ?? -1;
      const where = shown?.legs.length ? (at >= 0 ? t("maneuver {at} of {all}, {maneuver}", { at: at + 1, all: shown.legs.length, maneuver }) : tn(shown.legs.length, "{n} maneuver", "{n} maneuvers")) : "";
      const from = shown?.source === "shore" ? ` ${t("(as kept ashore: the vessel's digest is the same)")}` : "";
      const sailed = plan.old ? t("When last heard it sailed") : t("Sails");
      const text = !shown ? "" : shown.trouble ? `${sailed} ${plan.note}. ${shown.trouble}` : `${sailed} ${plan.note}: ${where}${from}`;
      setText(line, text);
      setAttribute(line, "hidden", text ? null : "");
      setAttribute(line, "data-known", shown?.source && !shown.trouble && !plan.old ? "" : null);
    },
  };
}
