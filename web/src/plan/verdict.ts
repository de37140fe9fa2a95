// What the guard against grounding says of a plan, where it is: the refused legs, a mark at the worst spot of each with
// the reason, and a list whose entries lead there.

import Feature from "ol/Feature";
import { Circle as CircleGeometry, LineString, Point } from "ol/geom";
import VectorLayer from "ol/layer/Vector";
import VectorSource from "ol/source/Vector";
import { fromLonLat } from "ol/proj";
import { Circle, Fill, Stroke, Style, Text } from "ol/style";
import type { Guard, GuardReason, PlanDocument, PlanLeg, PlanPlace } from "../api/types.gen";
import { over } from "../map/layers";
import type { FleetMap } from "../map/map";
import { nearestStretch } from "../state/chart";
import { wayOf } from "../state/plan";
import { canGoAround } from "../state/searoute";
import { make } from "../ui/dom";
import { CANVAS_FONT } from "../map/palette";

/** Reasons that are listed; the server tells no more than a hundred. */
const LISTED = 20;
const CODES: Readonly<Record<string, string>> = {
  land: "land",
  obstacle: "obstacle",
  "unknown-depth": "depth unknown",
  "no-data": "no chart",
  "too-low": "too low overhead",
  "too-shallow": "too shallow",
  "too-shallow-alone": "too shallow",
};

export interface VerdictOnMap {
  update(plan: PlanDocument, legs: readonly PlanLeg[], guard: Guard | null): void;
  /** The list that goes with it; `go` leads to a spot, `around` looks for another way, where the plan may be changed. */
  list(guard: Guard | null, go: (reason: GuardReason) => void, around?: (reason: GuardReason) => void): HTMLElement[];
}

export function createVerdict(map: FleetMap): VerdictOnMap {
  // Legs lie beneath the places that one takes hold of, marks above.
  const [legs, marks] = [new VectorSource(), new VectorSource()];
  const layers = ([[legs, over("planLegs")], [marks, over("planMarks")]] as const).map(([source, zIndex]) => new VectorLayer({ source, style: (feature) => styles(feature as Feature), updateWhileInteracting: true, zIndex }));
  for (const layer of layers) map.ol.addLayer(layer);
  map.onRepaint(() => layers.forEach((layer) => layer.changed()));

  const styles = (feature: Feature): Style[] => {
    const { ink, halo, danger } = map.palette();
    const text = feature.get("text") as string | undefined;
    if (text === undefined) {
      const dash = feature.get("round") === true ? { lineDash: [8, 5] } : {};
      return [
        new Style({ stroke: new Stroke({ color: ink, width: 9 }), zIndex: 0 }),
        new Style({ stroke: new Stroke({ color: halo, width: 7 }), zIndex: 1 }),
        new Style({ stroke: new Stroke({ color: danger, width: 4, ...dash }), zIndex: 2 }),
      ];
    }
    return [
      new Style({ image: new Circle({ radius: 12, fill: new Fill({ color: danger }), stroke: new Stroke({ color: halo, width: 3 }) }), zIndex: 3 }),
      new Style({
        image: new Circle({ radius: 14, stroke: new Stroke({ color: ink, width: 1.5 }) }),
        text: new Text({ text: "!", font: `800 17px ${CANVAS_FONT}`, fill: new Fill({ color: halo }) }),
        zIndex: 4,
      }),
      new Style({
        text: new Text({ text, font: `700 13px ${CANVAS_FONT}`, offsetY: 26, overflow: true, fill: new Fill({ color: danger }), stroke: new Stroke({ color: halo, width: 5 }) }),
        zIndex: 5,
      }),
    ];
  };

  return {
    update(plan, ways, guard) {
      const reasons = guard?.reasons ?? [];
      legs.clear(true);
      legs.addFeatures(reasons.flatMap((reason) => legOf(plan, ways, reason) ?? []));
      marks.clear(true);
      marks.addFeatures(reasons.map((reason) => new Feature({ geometry: new Point(xy(reason)), text: label(reason) })));
    },
    list(guard, go, around) {
      if (!guard) return [];
      const lines = guard.reasons.slice(0, LISTED).map((reason, at) => {
        const button = make("button", { type: "button", class: "spot", "data-key": `spot-${at}`, title: "Show it on the map" }, reason.text);
        button.addEventListener("click", () => go(reason));
        if (!around || !canGoAround(reason)) return make("li", {}, button);
        const other = make("button", { type: "button", class: "around", "data-key": `around-${at}`, "aria-label": `Route around: ${reason.text}` }, "Route around");
        other.addEventListener("click", () => around(reason));
        return make("li", {}, button, " ", other);
      });
      const more = guard.reasons.length > LISTED ? [make("p", {}, `and ${guard.reasons.length - LISTED} more legs`)] : [];
      const refused = guard.outcome === "refused" ? [make("div", { class: "note bad guard" }, make("strong", {}, "Refused by the chart"), ...(lines.length ? [make("ul", {}, ...lines)] : [make("p", {}, guard.text)]), ...more)] : [];
      const own = guard.warnings.slice(0, LISTED).map((one) => make("li", {}, one.maneuver === null ? one.text : `${one.maneuver}: ${one.text}`));
      const warned = own.length ? [make("div", { class: "note warn guard" }, make("strong", {}, "By the chart"), make("ul", {}, ...own))] : [];
      const good = guard.outcome === "ok" ? [make("p", { class: "guard-ok" }, "Deep enough by the chart.")] : [];
      // What could not be held against a chart was held against nothing.
      const judged = guard.outcome !== "refused" || guard.reasons.length > 0;
      const by = make("p", { class: "guard-by" }, `Held against ${guard.autonomous_m} m of water, ${guard.of_vessel ? "the limit that the vessel told" : "the server's limit"}.`);
      return [...refused, ...warned, ...good, ...(judged ? [by] : [])];
    },
  };
}

function label(reason: GuardReason): string {
  const depth = reason.depth_m === null ? "" : reason.depth_m < 0 ? `, dries ${(-reason.depth_m).toFixed(1)} m` : `, ${reason.depth_m.toFixed(1)} m`;
  return `${CODES[reason.code] ?? reason.code}${depth}`;
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
  if (reason.part === "transit") return new Feature({ geometry: new LineString([xy(reason.from), xy(reason.to)]) });
  const line = wayOf(step, legs);
  const stretch = nearestStretch(line, reason);
  if (stretch === undefined) return undefined;
  return new Feature({ geometry: new LineString(line.slice(stretch, stretch + 2).map(xy)) });
}

function xy(place: PlanPlace): number[] {
  return fromLonLat([place.lon_deg, place.lat_deg]);
}
