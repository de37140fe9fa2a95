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
import { sideBySide } from "../state/explore";
import { over } from "./layers";

/** What the dots are drawn on, apart from what lies below them. */
export const SQUARES_LAYER = "squares-layer";
/** Radius of the dot of one detection, and of that where most were heard, px. */
const [LEAST_PX, MOST_PX, HALO_PX] = [3, 10, 1.5];

/** A dot on the map: how many were heard there. */
interface Counted {
  get(name: string): unknown;
}

export interface SquaresOnMap {
  show(squares: readonly SummarySquare[]): void;
  /** Brings all into view. */
  fit(): void;
  /** The dots as a drawing, over a picture of the map without them. */
  drawing(below: HTMLCanvasElement): string;
  dispose(): void;
}

export function createSquares(map: OlMap): SquaresOnMap {
  const source = new VectorSource<Feature<Point>>();
  let most = 1;
  const radiusOf = (feature: Counted): number => LEAST_PX + (MOST_PX - LEAST_PX) * Math.sqrt(Number(feature.get("count")) / most);
  const colours = (): readonly [string, string] => {
    const of = getComputedStyle(document.documentElement);
    return [`${of.getPropertyValue("--series-1").trim()}b0`, of.getPropertyValue("--map-halo").trim()];
  };
  const style = (feature: Counted): Style => {
    const [fill, halo] = colours();
    return new Style({ image: new Circle({ radius: radiusOf(feature), fill: new Fill({ color: fill }), stroke: new Stroke({ color: halo, width: HALO_PX }) }) });
  };
  const layer = new VectorLayer({ source, zIndex: over("tags"), style, className: `ol-layer ${SQUARES_LAYER}` });
  map.addLayer(layer);
  // Another palette has other colours.
  const palette = new MutationObserver(() => layer.changed());
  palette.observe(document.documentElement, { attributes: true, attributeFilter: ["data-palette"] });
  return {
    show(squares) {
      most = squares.reduce((all, { detections }) => Math.max(all, detections), 1);
      source.clear(true);
      const lons = sideBySide(squares.map(({ lon_deg }) => lon_deg));
      source.addFeatures(squares.map(({ lat_deg, lon_deg, detections }, at) => new Feature({ geometry: new Point(fromLonLat([lons[at] ?? lon_deg, lat_deg])), count: detections })));
    },
    drawing(below) {
      const [wide = 0, high = 0] = map.getSize() ?? [];
      const [fill, halo] = colours();
      const dots = source.getFeatures().map((one) => {
        const [x = 0, y = 0] = map.getPixelFromCoordinate(one.getGeometry()?.getCoordinates() ?? []) ?? [];
        return `<circle cx="${x.toFixed(1)}" cy="${y.toFixed(1)}" r="${radiusOf(one).toFixed(1)}"><title>${Number(one.get("count"))}</title></circle>`;
      });
      return `<svg xmlns="http://www.w3.org/2000/svg" width="${wide}" height="${high}" viewBox="0 0 ${wide} ${high}"><image href="${below.toDataURL("image/png")}" width="${wide}" height="${high}"/><g fill="${fill}" stroke="${halo}" stroke-width="${HALO_PX}">${dots.join("")}</g></svg>`;
    },
    dispose: () => palette.disconnect(),
    fit() {
      const places = source.getFeatures().map((one) => one.getGeometry()?.getCoordinates() ?? []);
      if (places.length) map.getView().fit(boundingExtent(places), { padding: [40, 40, 40, 40], maxZoom: 16, duration: 0 });
    },
  };
}
