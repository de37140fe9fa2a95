// Detections counted in squares: a dot at the middle of each, larger where more were heard.

import type OlMap from "ol/Map";
import Feature from "ol/Feature";
import { boundingExtent } from "ol/extent";
import { Point } from "ol/geom";
import VectorLayer from "ol/layer/Vector";
import VectorSource from "ol/source/Vector";
import { fromLonLat } from "ol/proj";
import { Circle, Fill, Stroke, Style } from "ol/style";
import type { SummarySquare } from "../api/types.gen";
import { over } from "./layers";

/** Radius of the dot of one detection, and of that where most were heard, px. */
const [LEAST_PX, MOST_PX] = [3, 10];

export interface SquaresOnMap {
  show(squares: readonly SummarySquare[]): void;
  /** Brings all into view. */
  fit(): void;
  dispose(): void;
}

export function createSquares(map: OlMap): SquaresOnMap {
  const source = new VectorSource<Feature<Point>>();
  let most = 1;
  const style = (feature: { get(name: string): unknown }): Style => {
    const colours = getComputedStyle(document.documentElement);
    const radius = LEAST_PX + (MOST_PX - LEAST_PX) * Math.sqrt(Number(feature.get("count")) / most);
    return new Style({ image: new Circle({ radius, fill: new Fill({ color: `${colours.getPropertyValue("--series-1").trim()}b0` }), stroke: new Stroke({ color: colours.getPropertyValue("--map-halo").trim(), width: 1.5 }) }) });
  };
  const layer = new VectorLayer({ source, zIndex: over("tags"), style });
  map.addLayer(layer);
  // Another palette has other colours.
  const palette = new MutationObserver(() => layer.changed());
  palette.observe(document.documentElement, { attributes: true, attributeFilter: ["data-palette"] });
  return {
    show(squares) {
      most = squares.reduce((all, { detections }) => Math.max(all, detections), 1);
      source.clear(true);
      source.addFeatures(squares.map(({ lat_deg, lon_deg, detections }) => new Feature({ geometry: new Point(fromLonLat([lon_deg, lat_deg])), count: detections })));
    },
    dispose: () => palette.disconnect(),
    fit() {
      const places = source.getFeatures().map((one) => one.getGeometry()?.getCoordinates() ?? []);
      if (places.length) map.getView().fit(boundingExtent(places), { padding: [40, 40, 40, 40], maxZoom: 16, duration: 0 });
    },
  };
}
