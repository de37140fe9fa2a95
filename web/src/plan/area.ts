// An area on the map while it is drawn: its corners, its edge, and the way that a vessel would take over it.

import Feature from "ol/Feature";
import { LineString, Point } from "ol/geom";
import VectorLayer from "ol/layer/Vector";
import VectorSource from "ol/source/Vector";
import { fromLonLat } from "ol/proj";
import { Circle, Fill, Stroke, Style } from "ol/style";
import type { PlanPlace } from "../api/types.gen";
import { over } from "../map/layers";
import type { FleetMap } from "../map/map";
import type { SketchView } from "./sketching";

/** A polygon is closed by its first corner from so many on. */
const CLOSES = 3;

export interface AreaOnMap {
  draw(view: SketchView | undefined): void;
  /** Whether a click there closes the polygon. */
  closes(pixel: readonly number[]): boolean;
}

export function createArea(map: FleetMap, near_px: number): AreaOnMap {
  const source = new VectorSource();
  const layer = new VectorLayer({ source, style: (feature) => styles(feature as Feature), updateWhileInteracting: true, zIndex: over("planMarks") });
  map.ol.addLayer(layer);
  map.onRepaint(() => layer.changed());
  let corners: readonly PlanPlace[] = [];

  const styles = (feature: Feature): Style[] => {
    const { ink, halo, series } = map.palette();
    const colour = series[0] ?? ink;
    const kind = feature.get("kind") as "edge" | "way" | "corner" | "first";
    if (kind === "way") return [new Style({ stroke: new Stroke({ color: colour, width: 1.5 }), zIndex: 1 })];
    if (kind === "edge") return [new Style({ stroke: new Stroke({ color: halo, width: 6 }), zIndex: 0 }), new Style({ stroke: new Stroke({ color: ink, width: 2.5, lineDash: [8, 5] }), zIndex: 2 })];
    return [new Style({ image: new Circle({ radius: kind === "first" ? 10 : 7, fill: new Fill({ color: halo }), stroke: new Stroke({ color: ink, width: 3 }) }), zIndex: 3 })];
  };

  return {
    draw(view) {
      source.clear(true);
      corners = view?.corners ?? [];
      if (!view) return;
      const line = (kind: string, places: readonly PlanPlace[]): Feature[] => (places.length > 1 ? [new Feature({ geometry: new LineString(places.map(xy)), kind })] : []);
      const dots = corners.map((place, at) => new Feature({ geometry: new Point(xy(place)), kind: at ? "corner" : "first" }));
      source.addFeatures([...line("edge", view.edge), ...line("way", view.way), ...dots]);
    },
    closes([x = 0, y = 0]) {
      const [first] = corners;
      const pixel = first && corners.length >= CLOSES ? map.ol.getPixelFromCoordinate(xy(first)) : undefined;
      return pixel !== undefined && Math.hypot((pixel[0] ?? 0) - x, (pixel[1] ?? 0) - y) <= near_px;
    },
  };
}

function xy(place: PlanPlace): number[] {
  return fromLonLat([place.lon_deg, place.lat_deg]);
}
