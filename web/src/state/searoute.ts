// A route on the sea chart between places that a person chose: what is asked, in what words it is answered, and how it
// becomes part of a plan. No page in it.

import type { GuardReason, PlanDocument, PlanPlace, PlanSpeed, SeaRoute, SeaRouteAnswer, SeaRouteClosed, SeaRouteGaveUp, SeaRouteMoved, SeaRouteObjective, SeaRoutePassable, SeaRouteProgress, SeaRouteRefusal } from "../api/types.gen";
import { t } from "../words/words";
import { depthText } from "./chart";
import { KINDS } from "./plan";
import { spotLabel, spotName } from "./refusal";

/** What a way around something is for. */
export interface Around {
  readonly maneuver: string;
  readonly part: string;
  /** Number of the leg within the part. */
  readonly number: number;
}

/** Whether a refused leg can be sailed around: where it leads from one place to another. */
export function canGoAround(reason: GuardReason): boolean {
  return !!reason.from && !!reason.to && (reason.part === "transit" || reason.part === "track");
}

export function placesOfRoute(route: SeaRoute): PlanPlace[] {
  return route.points.map(([lat_deg, lon_deg]) => ({ lat_deg, lon_deg }));
}

/** How far a question has come: what the server knows, and not how long it still takes, which it cannot know. */
export function progressText({ waiting, tiles, most_tiles, spent_s }: SeaRouteProgress): string {
  const seconds = Math.round(spent_s);
  if (waiting) return t("Waiting for other routes: {seconds} s", { seconds });
  if (tiles > 0) return t("Searched {tiles} tiles of the chart, of {most} at most: {seconds} s", { tiles, most: most_tiles, seconds });
  return t("Preparing the water: {seconds} s", { seconds });
}

/** All routes of an answer: the one that was asked for, the shortest, then those that pass islands and shoals on the other side. */
export function routesOf(answer: SeaRouteAnswer | undefined): SeaRoute[] {
  return answer?.route ? [answer.route, ...(answer.shortest ? [answer.shortest] : []), ...answer.alternatives] : [];
}

/** What a route is called among those of an answer to a question for an objective. */
export function routeName(route: SeaRoute, index: number, { shortest, route: best }: Pick<SeaRouteAnswer, "route" | "shortest">, objective: SeaRouteObjective): string {
  const least = shortest ?? best;
  const isShortest = route === least;
  const longer = Math.round(route.length_m - (least?.length_m ?? 0));
  const chosen = index === 0 && !isShortest;
  const more = t("{n}: {length} longer", { n: index + 1, length: lengthOf(longer) });
  const name = isShortest ? t("Shortest") : chosen ? (longer < 1 ? chosenName(objective) : t("{name}, {length} longer", { name: chosenName(objective), length: lengthOf(longer) })) : more;
  const energy = shortest && route.energy_wh !== null ? ` · ${Math.round(route.energy_wh)} Wh` : "";
  return `${name} · ${routeText(route)}${energy}`;
}

function chosenName(objective: SeaRouteObjective): string {
  return { shortest: t("In deeper water"), fastest: t("Fastest"), least_energy: t("Least energy") }[objective];
}

/** What the chosen route saves against the shortest one, in words; empty where it is the shortest itself. */
export function savedText({ route, shortest }: Pick<SeaRouteAnswer, "route" | "shortest">): string {
  if (!route || !shortest) return "";
  const part = (words: (share: number) => string, now: number | null, before: number | null): string[] => {
    if (now === null || before === null || before <= 0) return [];
    const percent = Math.round(100 * (now / before - 1));
    return percent === 0 ? [] : [words(percent)];
  };
  const signed = (percent: number): string => `${percent > 0 ? "+" : "−"}${Math.abs(percent)} %`;
  const parts = [
    ...part((percent) => t("length {change}", { change: signed(percent) }), route.length_m, shortest.length_m),
    ...part((percent) => t("time {change}", { change: signed(percent) }), route.duration_s, shortest.duration_s),
    ...part((percent) => t("energy {change}", { change: signed(percent) }), route.energy_wh, shortest.energy_wh),
  ];
  return parts.length ? t("Against the shortest route: {changes}.", { changes: parts.join(", ") }) : "";
}

/** The speed of a plan along a route: the route's, where that is slower to save energy. */
export function speedFor(route: Pick<SeaRoute, "speed_mps">, speed: PlanSpeed): PlanSpeed {
  const slower = speed.unit === "mps" && route.speed_mps < speed.value - 1e-6;
  return slower ? { value: Math.round(100 * route.speed_mps) / 100, unit: "mps" } : speed;
}

/** What the plan's speed is, where the route was reckoned with another one; empty where both are the same. */
export function keptSpeedText(route: Pick<SeaRoute, "speed_mps">, speed: PlanSpeed): string {
  return speed.unit === "mps" && Math.abs(speed.value - route.speed_mps) < 0.006 ? "" : t("The plan keeps its own speed; time and energy are for {speed} m/s.", { speed: route.speed_mps.toFixed(2) });
}

/** Length, time, and what there is around it, in a line. */
export function routeText(route: SeaRoute): string {
  const depth = route.least_depth_m === null ? "" : ` · ${t("least depth {depth} m", { depth: route.least_depth_m.toFixed(1) })}`;
  const clear = ` · ${route.least_clearance_m === null ? t("clear by more than 5 km") : t("clear by {distance} m", { distance: Math.floor(route.least_clearance_m) })}`;
  return `${lengthOf(route.length_m)} · ${timeOf(route)}${depth}${clear}`;
}

function timeOf({ duration_s, current_unknown_m, current_too_strong }: SeaRoute): string {
  if (duration_s === null) {
    const unknown = current_unknown_m > 0 ? [t("the current is not known everywhere")] : [];
    return [...(current_too_strong || !unknown.length ? [t("the current is too strong")] : []), ...unknown].join(", ");
  }
  const minutes = Math.max(1, Math.round(duration_s / 60));
  return minutes < 90 ? `${minutes} min` : `${Math.floor(minutes / 60)} h ${minutes % 60} min`;
}

/** What it takes from the batteries; empty where that is not known. */
export function energyOf({ energy_wh, speed_mps }: Pick<SeaRoute, "energy_wh" | "speed_mps">): string {
  return energy_wh === null ? "" : t("About {energy} Wh from the batteries at {speed} m/s (estimate).", { energy: Math.round(energy_wh), speed: speed_mps.toFixed(2) });
}

export function lengthOf(metres: number): string {
  return metres < 10_000 ? `${Math.round(metres)} m` : `${(metres / 1000).toFixed(1)} km`;
}

/** What is to be known of an answer beside the route itself. */
export function remarks({ route, refusal }: Pick<SeaRouteAnswer, "route" | "refusal">): string[] {
  if (refusal) return refusalTexts(refusal);
  if (!route) return [];
  const { guard } = route;
  const slow = route.legs.some(({ limit_mps }) => typeof limit_mps === "number") ? [t("The route enters areas with a speed limit. Time and energy are reckoned with it; the plan has one speed for the whole path: split it, or set a speed within the limit.")] : [];
  const part = route.part_only ? [t("The charts hold so much here that only part of the water was looked at. A shorter route may lead elsewhere: add places to pass to lead it there.")] : [];
  return [...route.moved.map(movedText), ...part, ...narrowTexts(route), ...trafficTexts(route), ...slow, ...(guard ? [t("The guard would refuse leg {number}: {why}", { number: guard.number + 1, why: spotLabel(guard) })] : [])];
}

/** Which legs lead through ordered traffic. */
function trafficTexts({ legs }: SeaRoute): string[] {
  return legs.flatMap(({ traffic }, index) => {
    if (!traffic) return [];
    const number = index + 1;
    if (traffic.against) return [t("Leg {number} leads against the direction of a traffic lane.", { number })];
    if (traffic.kind === "lane") return [t("Leg {number} leads through a traffic lane.", { number })];
    if (traffic.kind === "deep_water") return [t("Leg {number} leads through a deep-water route.", { number })];
    return [traffic.kind === "junction" ? t("Leg {number} leads through a junction of traffic lanes.", { number }) : t("Leg {number} leads through a traffic separation zone.", { number })];
  });
}

/** Where the water has no room for a vessel that is off its track. */
function narrowTexts({ narrow }: SeaRoute): string[] {
  if (!narrow) return [];
  const { legs, leg, least_m, needed_m } = narrow;
  return [t("On {legs} legs danger is nearer than the {needed} m that a vessel needs before its path monitor ends a plan off the track: {least} m from leg {number}. Keep clear by more, or prefer water farther off.", { legs, needed: Math.round(needed_m), least: Math.round(least_m), number: leg + 1 })];
}

function movedText({ end, via, distance_m }: SeaRouteMoved): string {
  const distance = Math.round(distance_m);
  if (end === "via") return t("Place {number} on the way lies too near land, shallow water, a danger or an area to avoid; it was moved by {distance} m.", { number: via ?? 0, distance });
  return end === "start"
    ? t("The start lies too near land, shallow water, a danger or an area to avoid; it was moved by {distance} m.", { distance })
    : t("The goal lies too near land, shallow water, a danger or an area to avoid; it was moved by {distance} m.", { distance });
}

/** Why there is no route, and what would give one. What has no code is said as the server said it. */
function refusalTexts(refusal: SeaRouteRefusal): string[] {
  const { code, text, gap_m, closed, apart_m, looked_m, gave_up, via, by, passable } = refusal;
  const looked = Math.round((looked_m ?? 0) / 1000);
  if (closed && code === "closed_via") return [closedViaText(via ?? 0, closed, gap_m)];
  if (closed) return [closedText(code === "closed_start", closed, gap_m)];
  if (gave_up) return [gaveUpText(gave_up, looked)];
  if (code === "not_found") return [t("No route was found in the water that was looked at, up to {looked} km from the start. The nearest place there that can be reached is {distance} m from the goal. Add places on the way.", { looked, distance: Math.round(gap_m ?? 0) })];
  if (apart_m && by.length > 0) return [t("Start and goal are {distance} km apart; routes are planned up to {most} km here. Add places on the way, such as {places}.", { distance: Math.round(apart_m[0] / 1000), most: Math.round(apart_m[1] / 1000), places: by.map(([lat, lon]) => `${lat.toFixed(4)}, ${lon.toFixed(4)}`).join("; ") })];
  if (apart_m) return [t("Start and goal are {distance} km apart; routes are planned up to {most} km: add places on the way.", { distance: Math.round(apart_m[0] / 1000), most: Math.round(apart_m[1] / 1000) })];
  if (code !== "no_way") return [text];
  const distance = Math.round(gap_m ?? 0);
  const none = looked_m === null
    ? t("No route is deep enough and keeps this clearance. The nearest place that can be reached is {distance} m from the goal.", { distance })
    : t("No route is deep enough and keeps this clearance. The nearest place that can be reached is {distance} m from the goal (searched {looked} km around the start).", { distance, looked });
  return passable ? [none, ...passableTexts(passable)] : [none];
}

function gaveUpText({ tiles, out_of_time }: SeaRouteGaveUp, looked: number): string {
  return out_of_time
    ? t("The search was stopped: its time is used up. It searched {tiles} tiles of the chart, up to {looked} km from the start, and found no route yet. Add places on the way, ask for a shorter route, or ask again: what was searched is kept for a while.", { tiles, looked })
    : t("The search was stopped: it may search no more of the chart. It searched {tiles} tiles, up to {looked} km from the start, and found no route yet. Add places on the way, or ask for a shorter route.", { tiles, looked });
}

function closedWhy({ code, depth_m }: SeaRouteClosed): string {
  return code === "too-shallow" && depth_m !== null ? t("charted depth {depth}, or too near a danger", { depth: depthText(depth_m) }) : spotName(code);
}

function closedViaText(number: number, closed: SeaRouteClosed, gap_m: number | null): string {
  if (closed.code === "zone") return t("No route can pass place {number}: it lies in an area to avoid, or too near its edge.", { number });
  const why = closedWhy(closed);
  return gap_m === null
    ? t("No route can pass place {number} ({why}), and there is no open water within 50 km.", { number, why })
    : t("No route can pass place {number} ({why}). The nearest open water is {distance} m away; the place is moved by {most} m at most.", { number, why, distance: Math.round(gap_m), most: Math.round(closed.may_move_m) });
}

function closedText(start: boolean, closed: SeaRouteClosed, gap_m: number | null): string {
  const { code, may_move_m } = closed;
  if (code === "zone") return start ? t("No route can begin there: it lies in an area to avoid, or too near its edge.") : t("No route can end there: it lies in an area to avoid, or too near its edge.");
  const why = closedWhy(closed);
  if (gap_m === null) return start ? t("No route can begin there ({why}), and there is no open water within 50 km.", { why }) : t("No route can end there ({why}), and there is no open water within 50 km.", { why });
  const values = { why, distance: Math.round(gap_m), most: Math.round(may_move_m) };
  return start
    ? t("No route can begin there ({why}). The nearest open water is {distance} m away; the start is moved by {most} m at most.", values)
    : t("No route can end there ({why}). The nearest open water is {distance} m away; the goal is moved by {most} m at most.", values);
}

function passableTexts({ depth_m, clearance_m, gap_width_m, by_rule_alone, by_zones_alone }: SeaRoutePassable): string[] {
  const depth = depth_m === null ? "" : t("a least depth of {depth} m", { depth: depth_m });
  const clearance = clearance_m === null ? "" : t("a clearance of {distance} m", { distance: clearance_m });
  const both = depth && clearance ? t("{one}, or with {other}", { one: depth, other: clearance }) : depth || clearance;
  const would = both ? t("There is one with {what}.", { what: both }) : t("No smaller depth or clearance was found that gives one.");
  return [
    would,
    ...(gap_width_m === null ? [] : [t("The narrowest gap is {distance} m wide; the map shows it.", { distance: Math.floor(gap_width_m) })]),
    ...(by_rule_alone ? [t("Areas where entry is prohibited or restricted are in the way; without them there is a route.")] : []),
    ...(by_zones_alone ? [t("The areas to avoid are in the way; without them there is a route.")] : []),
  ];
}

/** With the route as a path of its own after a maneuver, or at the end. */
export function withRoute(plan: PlanDocument, route: SeaRoute, speed: PlanSpeed, after = plan.maneuvers.length - 1): PlanDocument {
  return inserted(plan, after + 1, placesOfRoute(route), speed);
}

/** With the route in place of a refused leg; the same plan where that leg is no longer there. */
export function withWayAround(plan: PlanDocument, route: SeaRoute, around: Around): PlanDocument {
  const at = plan.maneuvers.findIndex((step) => step.id === around.maneuver);
  const step = plan.maneuvers[at];
  const between = placesOfRoute(route).slice(1, -1);
  if (!step || !between.length) return plan;
  if (around.part === "track" && step.task.kind === "follow_path") {
    const points = [...step.task.points];
    points.splice(around.number + 1, 0, ...between);
    return { ...plan, maneuvers: plan.maneuvers.map((one, index) => (index === at ? { ...one, task: { kind: "follow_path", points } } : one)) };
  }
  if (around.part !== "transit") return plan;
  return inserted(plan, at, between, step.speed);
}

function inserted(plan: PlanDocument, at: number, points: PlanPlace[], speed: PlanSpeed): PlanDocument {
  const taken = new Set(plan.maneuvers.map((step) => step.id));
  const name = KINDS.find(([kind]) => kind === "follow_path")?.[1] ?? "Path";
  let number = 1;
  while (taken.has(`${name} ${number}`)) number++;
  const maneuvers = [...plan.maneuvers];
  maneuvers.splice(at, 0, { id: `${name} ${number}`, speed, task: { kind: "follow_path", points } });
  return { ...plan, maneuvers };
}

/** Where a new place to pass belongs: between the two chosen places whose stretch of the route it lies nearest to. */
export function stretchAt(chosen: readonly PlanPlace[], route: readonly PlanPlace[], leg: number): number {
  let stretch = 0;
  for (let at = 1; at <= leg && stretch < chosen.length - 2; at++) {
    const next = chosen[stretch + 1];
    const here = route[at];
    if (next && here && Math.abs(here.lat_deg - next.lat_deg) < 1e-7 && Math.abs(here.lon_deg - next.lon_deg) < 1e-7) stretch++;
  }
  return stretch;
}
