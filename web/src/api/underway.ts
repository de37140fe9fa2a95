// The maneuvers of the plans that vessels sail: asked for once for each start of a plan, and a few times more while not known.

import type { PlanUnderWay, RouteLeg } from "./types.gen";
import { getJson } from "./http";

/** A plan that is not known yet is looked for again so often, ms, and so many times. */
const AGAIN_MS = 3_000;
const TRIES = 5;

interface Known {
  readonly plan: string;
  legs: readonly RouteLeg[] | undefined;
}

export interface PlansUnderWay {
  /** The maneuvers of the plan that the vessel says it sails, as soon as they are known; `plan` is empty for none. */
  legs(address: number, plan: string): readonly RouteLeg[] | undefined;
}

export function createPlansUnderWay(): PlansUnderWay {
  const known = new Map<number, Known>();
  const ask = async (address: number, wanted: Known, tries: number): Promise<void> => {
    try {
      const { plan_id, legs } = await getJson<PlanUnderWay>(`/api/v1/vessels/${address}/plan`);
      if (plan_id === wanted.plan && legs.length) wanted.legs = legs;
    } catch {
      // Progress is told without it.
    }
    if (!wanted.legs && tries < TRIES && known.get(address) === wanted) window.setTimeout(() => void ask(address, wanted, tries + 1), AGAIN_MS);
  };
  return {
    legs(address, plan) {
      const before = known.get(address);
      if (before?.plan === plan) return before.legs;
      const wanted: Known = { plan, legs: undefined };
      known.set(address, wanted);
      if (plan) void ask(address, wanted, 1);
      return undefined;
    },
  };
}
