// No-go areas on the map: what people closed to all vessels. They are shown whatever of the chart is, as the guard holds plans
// against them.

import type OlMap from "ol/Map";
import Feature from "ol/Feature";
import { boundingExtent } from "ol/extent";
import { Polygon } from "ol/geom";
import VectorLayer from "ol/layer/Vector";
import VectorSource from "ol/source/Vector";
import { fromLonLat } from "ol/proj";
import { Fill, Stroke, Style, Text } from "ol/style";
import { getJson } from "../api/http";
import type { NoGoArea, NoGoAreaRequest, NoGoAreas } from "../api/types.gen";
import { over } from "./layers";
import { CANVAS_FONT, type Palette } from "./palette";

const PATIENCE_MS = 20_000;
/** Between the lines of the hatching, px. */
const HATCH_PX = 10;
/** Names are written on areas that are so wide on the screen, px. */
const NAMED_PX = 40;

export interface NoGoOnMap {
  /** Asks the server which areas are closed. */
  learn(): Promise<void>;
  show(areas: readonly NoGoArea[]): void;
  /** Brings one into view. */
  fit(area: NoGoAreaRequest): void;
  repaint(): void;
}

export function createNoGo(map: OlMap, palette: () => Palette): NoGoOnMap {
  const source = new VectorSource();
  const layer = new VectorLayer({ source, zIndex: over("nogo"), style: (feature, resolution) => style(feature as Feature<Polygon>, resolution) });
  map.addLayer(layer);
  let [colour, pattern]: [string, CanvasPattern | undefined] = ["", undefined];

  const hatch = (danger: string): CanvasPattern | undefined => {
    if (danger !== colour) [colour, pattern] = [danger, hatched(danger)];
    return pattern;
  };
  const style = (feature: Feature<Polygon>, resolution: number): Style => {
    const { ink, halo, danger } = palette();
    const [west = 0, , east = 0] = feature.getGeometry()?.getExtent() ?? [];
    const text = new Text({ text: feature.get("name") as string, overflow: true, font: `700 13px ${CANVAS_FONT}`, fill: new Fill({ color: ink }), stroke: new Stroke({ color: halo, width: 4 }) });
    return new Style({
      fill: new Fill({ color: hatch(danger) ?? `${danger}33` }),
      stroke: new Stroke({ color: danger, width: 2 }),
      ...((east - west) / resolution >= NAMED_PX ? { text } : {}),
    });
  };
  /** An answer to what was asked before something newer was shown is not drawn. */
  let asked = 0;
  const draw = (areas: readonly NoGoArea[]): void => {
    source.clear(true);
    source.addFeatures(areas.map((area) => new Feature({ geometry: new Polygon([ring(area.area)]), name: area.area.name })));
  };
  return {
    show(areas) {
      asked++;
      draw(areas);
    },
    async learn() {
      const mine = ++asked;
      // What was known stays until it is known better.
      const found = await getJson<NoGoAreas>("/api/v1/no-go-areas", AbortSignal.timeout(PATIENCE_MS)).catch(() => undefined);
      if (found && mine === asked) draw(found.areas);
    },
    fit(area) {
      if (area.corners.length > 0) map.getView().fit(boundingExtent(ring(area)), { padding: [80, 80, 80, 80], maxZoom: 17, duration: 0 });
    },
    repaint: () => layer.changed(),
  };
}

function ring({ corners }: NoGoAreaRequest): number[][] {
  return [...corners, ...corners.slice(0, 1)].map(([lat_deg, lon_deg]) => fromLonLat([lon_deg, lat_deg]));
}

/** Slanting lines. */
function hatched(colour: string): CanvasPattern | undefined {
  const tile = document.createElement("canvas");
  [tile.width, tile.height] = [HATCH_PX, HATCH_PX];
  const pen = tile.getContext("2d");
  if (!pen) return undefined;
  pen.strokeStyle = `${colour}80`;
  pen.lineWidth = 1.5;
  pen.beginPath();
  // Also across the corners, so that the tiles join.
  for (const shift of [-HATCH_PX, 0, HATCH_PX]) {
    pen.moveTo(shift - 1, HATCH_PX + 1);
    pen.lineTo(shift + HATCH_PX + 1, -1);
  }
  pen.stroke();
  return pen.createPattern(tile, "repeat") ?? undefined;
}
