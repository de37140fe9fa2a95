// Plans ashore and aboard side by side: pure functions from what the server and the vessels tell.

import type { PlanAboard, PlansAboard, PlanSummary } from "../api/types.gen";

/** How a vessel's copy is to the shore's. */
export type Copy = "same" | "differs" | "only ashore" | "only aboard" | "unknown";

/** A vessel that is heard, and what it said of its plans; undefined while it has not. */
export interface Aboard {
  readonly address: number;
  readonly name: string;
  readonly plans: PlansAboard | undefined;
}

/** A plan ashore, or one that vessels alone have. */
export interface Pair {
  readonly name: string;
  readonly ashore: PlanSummary | undefined;
  readonly copies: readonly { readonly vessel: Aboard; readonly copy: Copy; readonly aboard: PlanAboard | undefined }[];
}

/** All plans by name, each with the copies of all vessels. */
export function pairs(ashore: readonly PlanSummary[], vessels: readonly Aboard[]): Pair[] {
  const here = ashore.map((plan) => ({ name: plan.name, ashore: plan as PlanSummary | undefined }));
  const known = new Set(here.map(({ name }) => name));
  const there = new Set(vessels.flatMap(({ plans }) => plans?.plans ?? []).flatMap(({ plan_id }) => (known.has(plan_id) ? [] : [plan_id])));
  const all = [...here, ...[...there].map((name) => ({ name, ashore: undefined }))];
  return all
    .sort((one, other) => one.name.localeCompare(other.name))
    .map(({ name, ashore }) => ({ name, ashore, copies: vessels.map((vessel) => copyOf(name, ashore, vessel)) }));
}

function copyOf(name: string, ashore: PlanSummary | undefined, vessel: Aboard): Pair["copies"][number] {
  const aboard = vessel.plans?.plans.find((plan) => plan.plan_id === name);
  if (!vessel.plans || vessel.plans.time_us === null) return { vessel, aboard, copy: "unknown" };
  if (!aboard) return { vessel, aboard, copy: "only ashore" };
  if (!ashore) return { vessel, aboard, copy: "only aboard" };
  return { vessel, aboard, copy: aboard.md5 === ashore.digest ? "same" : "differs" };
}
