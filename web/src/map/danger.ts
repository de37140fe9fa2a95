// How what the chart refuses is drawn, whoever refused it: the leg in the colour of danger, and at the worst spot a mark
// with the reason.

import Feature from "ol/Feature";
import { LineString, Point } from "ol/geom";
import VectorLayer from "ol/layer/Vector";
import { fromLonLat } from "ol/proj";
import VectorSource from "ol/source/Vector";
import { Circle, Fill, Stroke, Style, Text } from "ol/style";
import type { PlanPlace } from "../api/types.gen";
import type { RefusedSpot } from "../state/refusal";
import { over } from "./layers";
import type { FleetMap } from "./map";
import { CANVAS_FONT, type Palette } from "./palette";

/** Where a spot is led to from farther out, the map comes this near. */
const NEAR_ZOOM = 15;

export interface RefusedOnMap {
  /** Marks these, and no others. */
  show(spots: readonly RefusedSpot[]): void;
  /** Leads to one. */
  go(spot: RefusedSpot): void;
}

export function createRefused(map: FleetMap): RefusedOnMap {
  const source = new VectorSource();
  const layer = new VectorLayer({ source, style: (feature) => dangerStyles(feature as Feature, map.palette()), updateWhileInteracting: true, zIndex: over("refused") });
  map.ol.addLayer(layer);
  map.onRepaint(() => layer.changed());
  return {
    show(spots) {
      source.clear(true);
      source.addFeatures(spots.flatMap(({ from, to }) => (from && to ? [new Feature(new LineString([xy(from), xy(to)]))] : [])));
      source.addFeatures(spots.map(({ place, label }) => new Feature({ geometry: new Point(xy(place)), text: label })));
    },
    go({ place }) {
      const view = map.ol.getView();
      view.setCenter(xy(place));
      if ((view.getZoom() ?? NEAR_ZOOM) < NEAR_ZOOM) view.setZoom(NEAR_ZOOM);
      map.ol.getTargetElement()?.scrollIntoView({ block: "nearest" });
    },
  };
}

/** A feature with a `text` is the mark of a spot, others are legs; those that are `round` are circles. */
export function dangerStyles(feature: Feature, { ink, halo, danger }: Palette): Style[] {
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
}

function xy(place: PlanPlace): number[] {
  return fromLonLat([place.lon_deg, place.lat_deg]);
}
