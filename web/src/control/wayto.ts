// Going somewhere by a route where the straight way is closed: the route is asked for before a person confirms, then it
// goes aboard as a plan and is started.

import { postJson, putJson, Refusal } from "../api/http";
import type { Command, Fix, PlanChange, PlanDocument, PlanUploadRequest, SeaRoute, SeaRouteAnswer, SeaRouteRequest, StoredPlan } from "../api/types.gen";
import { stageInFull } from "../state/orderwords";
import { placesOfRoute } from "../state/searoute";
import { t } from "../words/words";
import { type Orders, Unanswered } from "./orders";

const PATIENCE_MS = 15_000;
/** At the end it keeps to a circle of this radius, which lies within what the route keeps clear, m. */
const STAY_M = 10;

/** The route from where a vessel is; undefined where there is no chart to find one on. */
export async function routeTo(vessel: number, from: Fix, to: readonly [number, number], speed_mps: number): Promise<SeaRouteAnswer | undefined> {
  const ask: SeaRouteRequest = { points: [[from.lat_deg, from.lon_deg], [to[0], to[1]]], vessel, speed_mps, least_depth_m: null, clearance_m: null, turn_radius_m: null, stray_m: null, objective: "shortest", prefer_depth_m: null, prefer_off_m: null, prefer_factor: null, traffic_factor: null, zones: [], current: null, current_grid: null, depart_us: null, alternatives: 0, explain: false, progress: null };
  try {
    return await postJson<SeaRouteAnswer>("/api/v1/chart/route", PATIENCE_MS, ask);
  } catch (error) {
    if (error instanceof Refusal && error.status === 404) return undefined;
    throw error;
  }
}

/** Whether the route is the straight way itself. */
export function isStraight(route: SeaRoute): boolean {
  return route.legs.length <= 1 && !route.moved.length;
}

/** The route as a plan that ends by staying there. */
export function planOf(route: SeaRoute, vessel: number, mps: number, name: string): PlanDocument {
  const speed = { value: mps, unit: "mps" } as const;
  const points = placesOfRoute(route);
  const goal = points.at(-1);
  const stay = goal ? [{ id: "Stay", speed, task: { kind: "station_keeping", at: goal, radius_m: STAY_M, duration_s: 0 } } as const] : [];
  return { name, description: "A route on the sea chart, made by Go there", vessel, repeat: false, maneuvers: [{ id: "Route", speed, task: { kind: "follow_path", points: points.slice(1) } }, ...stay] };
}

/** Keeps the plan, brings it aboard and starts it; `told` says how far it is. */
export async function sail(plan: PlanDocument, vessel: number, window: string, orders: Orders, told: (text: string) => void): Promise<void> {
  told(t("Saving the route as a plan …"));
  const draft = await postJson<StoredPlan>("/api/v1/plans", PATIENCE_MS, plan);
  const stored = await putJson<StoredPlan>(`/api/v1/plans/${draft.id}`, { revision: draft.revision, draft: false, plan } satisfies PlanChange, PATIENCE_MS);
  told(t("Bringing the route aboard …"));
  const upload = await postJson<Command>(`/api/v1/plans/${stored.id}/upload`, PATIENCE_MS, { vessel, revision: stored.revision, window } satisfies PlanUploadRequest);
  const settled = await orders.settled(upload);
  const last = settled.steps.at(-1);
  if (last?.stage !== "effect seen") throw new Unanswered(t("The route did not get aboard: {text}. It is kept among the plans as {name}.", { text: last ? stageInFull(last) : t("not sent"), name: plan.name }));
  told("");
  await orders.give({ kind: "plan.start", plan_id: plan.name });
}
