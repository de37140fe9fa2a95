// The route of the plan that a vessel sails: all maneuvers, and which one it is at.

import Feature from "ol/Feature";
import { Circle as CircleGeometry, LineString, Point } from "ol/geom";
import VectorLayer from "ol/layer/Vector";
import VectorSource from "ol/source/Vector";
import { fromLonLat } from "ol/proj";
import { Circle, Fill, Stroke, Style, Text } from "ol/style";
import type { PlanPlace, PlanUnderWay } from "../api/types.gen";
import { over } from "./layers";
import type { FleetMap } from "./map";
import { CANVAS_FONT } from "./palette";
import { NAMES } from "./symbols";

/** Of longer routes the names would hide the route. */
const MOST_NAMES = 40;

export interface Route {
  /** Draws a plan with the maneuver that the vessel is at; null takes it away. */
  draw(plan: PlanUnderWay | null, maneuver: string): void;
}

export function createRoute(map: FleetMap): Route {
  const source = new VectorSource();
  const layer = new VectorLayer({ source, zIndex: over("route"), declutter: NAMES, style: (feature) => styleOf(feature as Feature) });
  map.ol.addLayer(layer);
  map.onRepaint(() => layer.changed());
  const styleOf = (feature: Feature): Style[] => {
    const { ink, halo, series } = map.palette();
    const now = feature.get("now") === true;
    const colour = series[0] ?? ink;
    const name = feature.get("name") as string | undefined;
    if (name !== undefined) {
      const image = new Circle({ radius: now ? 8 : 5, fill: new Fill({ color: now ? colour : halo }), stroke: new Stroke({ color: now ? ink : colour, width: 2 }), declutterMode: "none" });
      const text = new Text({ text: name, font: `${now ? 700 : 500} 13px ${CANVAS_FONT}`, offsetY: -16, overflow: true, fill: new Fill({ color: ink }), stroke: new Stroke({ color: halo, width: 4 }) });
      return [new Style({ image, zIndex: now ? 4 : 3 }), new Style({ text, zIndex: now ? 3 : 4 })];
    }
    const stroke = now ? new Stroke({ color: colour, width: 4 }) : new Stroke({ color: colour, width: 2, lineDash: [7, 6] });
    return [new Style({ stroke: new Stroke({ color: halo, width: now ? 8 : 5 }), zIndex: 0 }), new Style({ stroke, zIndex: now ? 2 : 1 })];
  };

  return {
    draw(plan, maneuver) {
      source.clear(true);
      if (!plan) return;
      const features: Feature[] = [];
      const legs = plan.legs.filter((leg) => leg.places.length);
      const ends = legs.map((leg) => leg.places.at(-1));
      legs.forEach((leg, index) => {
        const now = leg.id === maneuver;
        // The way to a maneuver belongs to it; to the first one there is one only in a plan that begins again.
        const from = index ? ends[index - 1] : plan.repeats ? ends.at(-1) : undefined;
        const line = [...(from ? [from] : []), ...leg.places].map(xy);
        if (line.length > 1) features.push(made(new LineString(line), now));
        const [first] = leg.places;
        if (!first) return;
        // A metre on the ground is more on this projection, the farther from the equator.
        if (leg.radius_m) features.push(made(new CircleGeometry(xy(first), leg.radius_m / Math.max(0.01, Math.cos((first.lat_deg * Math.PI) / 180))), now));
        const place = made(new Point(xy(leg.places.at(-1) ?? first)), now);
        place.set("name", now || legs.length <= MOST_NAMES ? shortened(leg.id) : "", true);
        features.push(place);
      });
      source.addFeatures(features);
    },
  };
}

function made(geometry: LineString | CircleGeometry | Point, now: boolean): Feature {
  const feature = new Feature(geometry as Point);
  feature.set("now", now, true);
  return feature;
}

function shortened(text: string): string {
  return text.length > 30 ? `${text.slice(0, 29)}…` : text;
}

function xy(place: PlanPlace): number[] {
  return fromLonLat([place.lon_deg, place.lat_deg]);
}
