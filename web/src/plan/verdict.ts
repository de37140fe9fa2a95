// What the guard against grounding says of a plan, where it is: the refused legs, a mark at the worst spot of each with
// the reason, and a list whose entries lead there.

import Feature from "ol/Feature";
import { Circle as CircleGeometry, LineString, Point } from "ol/geom";
import VectorLayer from "ol/layer/Vector";
import VectorSource from "ol/source/Vector";
import { fromLonLat } from "ol/proj";
import type { Guard, GuardReason, PlanDocument, PlanLeg, PlanPlace } from "../api/types.gen";
import { dangerStyles } from "../map/danger";
import { over } from "../map/layers";
import type { FleetMap } from "../map/map";
import { nearestStretch } from "../state/chart";
import { wayOf } from "../state/plan";
import { reasonInFull, refusedText, warningWords } from "../state/planverdict";
import { spotLabel } from "../state/refusal";
import { canGoAround } from "../state/searoute";
import { make } from "../ui/dom";
import { t, tn } from "../words/words";

/** Reasons that are listed; the server tells no more than a hundred. */
const LISTED = 20;

export interface VerdictOnMap {
  update(plan: PlanDocument, legs: readonly PlanLeg[], guard: Guard | null): void;
  /** The list that goes with it; `go` leads to a spot, `around` looks for another way, where the plan may be changed. */
  list(plan: PlanDocument, guard: Guard | null, go: (reason: GuardReason) => void, around?: (reason: GuardReason) => void): HTMLElement[];
}

export function createVerdict(map: FleetMap): VerdictOnMap {
  // Legs lie beneath the places that one takes hold of, marks above.
  const [legs, marks] = [new VectorSource(), new VectorSource()];
  const layers = ([[legs, over("planLegs")], [marks, over("planMarks")]] as const).map(([source, zIndex]) => new VectorLayer({ source, style: (feature) => dangerStyles(feature as Feature, map.palette()), updateWhileInteracting: true, zIndex }));
  for (const layer of layers) map.ol.addLayer(layer);
  map.onRepaint(() => layers.forEach((layer) => layer.changed()));

  return {
    update(plan, ways, guard) {
      const reasons = guard?.reasons ?? [];
      legs.clear(true);
      legs.addFeatures(reasons.flatMap((reason) => legOf(plan, ways, reason) ?? []));
      marks.clear(true);
      marks.addFeatures(reasons.map((reason) => new Feature({ geometry: new Point(xy(reason)), text: spotLabel(reason) })));
    },
    list(plan, guard, go, around) {
      if (!guard) return [];
      const lines = guard.reasons.slice(0, LISTED).map((reason, at) => {
        const text = reasonInFull(plan, reason);
        const button = make("button", { type: "button", class: "spot", "data-key": `spot-${at}`, title: t("Show it on the map") }, text);
        button.addEventListener("click", () => go(reason));
        if (!around || !canGoAround(reason)) return make("li", {}, button);
        const other = make("button", { type: "button", class: "around", "data-key": `around-${at}`, "aria-label": t("Route around: {text}", { text }) }, t("Route around"));
        other.addEventListener("click", () => around(reason));
        return make("li", {}, button, " ", other);
      });
      const more = guard.reasons.length > LISTED ? [make("p", {}, tn(guard.reasons.length - LISTED, "and {n} more leg", "and {n} more legs"))] : [];
      const refused = guard.outcome === "refused" ? [make("div", { class: "note bad guard" }, make("strong", {}, t("Refused by the chart")), ...(lines.length ? [make("ul", {}, ...lines)] : [make("p", {}, refusedText(plan, guard))]), ...more)] : [];
      const own = guard.warnings.slice(0, LISTED).map((one) => make("li", {}, `${one.maneuver === null ? "" : `${one.maneuver}: `}${warningWords(one)}`));
      const warned = own.length ? [make("div", { class: "note warn guard" }, make("strong", {}, t("By the chart")), make("ul", {}, ...own))] : [];
      const good = guard.outcome === "ok" ? [make("p", { class: "guard-ok" }, t("Deep enough by the chart."))] : [];
      // What could not be held against a chart was held against nothing.
      const judged = guard.outcome !== "refused" || guard.reasons.length > 0;
      const by = make("p", { class: "guard-by" }, guard.of_vessel ? t("Checked against a least depth of {depth} m, the limit reported by the vessel.", { depth: guard.autonomous_m }) : t("Checked against a least depth of {depth} m, the server's limit.", { depth: guard.autonomous_m }));
      return [...refused, ...warned, ...good, ...(judged ? [by] : [])];
    },
  };
}

/** The leg that a reason is about: the circle, or the stretch of the maneuver's way that is nearest to the spot. */
function legOf(plan: PlanDocument, legs: readonly PlanLeg[], reason: GuardReason): Feature | undefined {
  const at = plan.maneuvers.findIndex((step) => step.id === reason.maneuver);
  const step = plan.maneuvers[at];
  if (!step) return undefined;
  const { task } = step;
  if ((reason.part === "circle" || reason.part === "station") && (task.kind === "loiter" || task.kind === "station_keeping")) {
    // A metre on the ground is more on this projection, the farther from the equator.
    const radius = task.radius_m / Math.max(0.01, Math.cos((task.at.lat_deg * Math.PI) / 180));
    return new Feature({ geometry: new CircleGeometry(fromLonLat([task.at.lon_deg, task.at.lat_deg]), radius), round: true });
  }
  if (reason.part === "transit" && reason.from && reason.to) return new Feature({ geometry: new LineString([xy(reason.from), xy(reason.to)]) });
  const line = wayOf(step, legs);
  const stretch = nearestStretch(line, reason);
  if (stretch === undefined) return undefined;
  return new Feature({ geometry: new LineString(line.slice(stretch, stretch + 2).map(xy)) });
}

function xy(place: PlanPlace): number[] {
  return fromLonLat([place.lon_deg, place.lat_deg]);
}
