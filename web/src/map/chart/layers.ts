// The chart as layers beneath everything: areas and lines, which OpenLayers keeps as pictures while the map is moved,
// and above them symbols and text, which must not cover each other.

import type OlMap from "ol/Map";
import type RenderFeature from "ol/render/Feature";
import MVT from "ol/format/MVT";
import VectorTileLayer from "ol/layer/VectorTile";
import VectorTileSource from "ol/source/VectorTile";
import type VectorTile from "ol/VectorTile";
import { linearRingsContainsXY } from "ol/geom/flat/contains";
import { transformExtent } from "ol/proj";
import { getTile } from "../../api/http";
import type { ChartSet } from "../../api/types.gen";
import { CHART } from "../layers";
import type { ChartStyles } from "./style";

/** Finer tiles are not asked for; those of this zoom are drawn larger. A tile is some 600 m wide then. */
const FINEST_ZOOM = 16;
const TILE_PX = 512;

export interface ChartLayers {
  /** Shows this chart set; none with null. */
  show(chart: ChartSet): void;
  changed(): void;
  /** Asks for all tiles in view again. */
  again(): void;
  /** Scale of the chart that is drawn at a coordinate: undefined outside of any, 0 where the chart does not tell. */
  scaleAt(coordinate: readonly number[]): number | undefined;
  /** The scale of the best chart in the picture; undefined where nothing is drawn. */
  finest(): number | undefined;
}

/** `arrived` is called with each tile that is there, `failed` with each that the server did not give. */
export function createLayers(map: OlMap, styles: ChartStyles, arrived: () => void, failed: () => void): ChartLayers {
  const common = { declutter: false, renderBuffer: 48, updateWhileAnimating: false, updateWhileInteracting: false, visible: false } as const;
  const base = new VectorTileLayer<VectorTileSource, RenderFeature>({ ...common, zIndex: CHART.base, renderMode: "hybrid", style: (feature, resolution) => styles.base(feature, resolution) });
  const points = new VectorTileLayer<VectorTileSource, RenderFeature>({
    ...common,
    zIndex: CHART.symbols,
    declutter: "chart",
    renderMode: "vector",
    renderOrder: (one, other) => styles.order(one, other),
    style: (feature, resolution) => styles.points(feature, resolution),
  });
  map.addLayer(base);
  map.addLayer(points);
  let shown: string | null = null;

  return {
    show(chart) {
      if (chart.set === shown) return;
      shown = chart.set;
      base.setVisible(shown !== null);
      points.setVisible(shown !== null);
      if (shown === null) return;
      const source = new VectorTileSource({
        format: new MVT(),
        maxZoom: FINEST_ZOOM,
        tileSize: TILE_PX,
        url: `/api/v1/chart/tiles/{z}/{x}/{y}?set=${shown}`,
        wrapX: true,
        // Tiles are many: they leave the connections to what is asked and ordered.
        tileLoadFunction: (tile, url) => load(tile as VectorTile<RenderFeature>, url),
      });
      source.on("tileloadend", arrived);
      source.on("tileloaderror", failed);
      const bounds = chart.bounds;
      if (bounds && bounds.west_deg < bounds.east_deg) {
        const extent = transformExtent([bounds.west_deg, bounds.south_deg, bounds.east_deg, bounds.north_deg], "EPSG:4326", "EPSG:3857");
        base.setExtent(extent);
        points.setExtent(extent);
      }
      base.setSource(source);
      points.setSource(source);
    },
    changed() {
      base.changed();
      points.changed();
    },
    again() {
      base.getSource()?.refresh();
    },
    finest() {
      const size = map.getSize();
      if (!base.getVisible() || !size) return undefined;
      const scales = base.getFeaturesInExtent(map.getView().calculateExtent(size)).filter((one) => ["water", "land"].includes(String(one.get("layer")))).map((one) => Number(one.get("scale") ?? 0)).filter((scale) => scale > 0);
      return scales.length ? scales.reduce((best, scale) => Math.min(best, scale)) : undefined;
    },
    scaleAt([x = 0, y = 0]) {
      if (!base.getVisible()) return undefined;
      let found: number | undefined;
      for (const feature of base.getFeaturesInExtent([x, y, x, y])) {
        if (!["water", "land", "cover"].includes(String(feature.get("layer")))) continue;
        if (!contains(feature, x, y)) continue;
        const scale = Number(feature.get("scale") ?? 0);
        // Land and water are of the chart that decides; a cover only tells that there is one.
        if (feature.get("layer") !== "cover") return scale;
        found ??= scale;
      }
      return found;
    },
  };
}

function load(tile: VectorTile<RenderFeature>, url: string): void {
  tile.setLoader((extent, _resolution, projection) => {
    getTile(url)
      .then((bytes) => tile.onLoad(tile.getFormat().readFeatures(bytes, { extent, featureProjection: projection }), projection))
      .catch(() => tile.onError());
  });
}

function contains(feature: RenderFeature, x: number, y: number): boolean {
  if (feature.getType() !== "Polygon") return false;
  const ends = (feature.getEnds() ?? []).flat() as number[];
  return linearRingsContainsXY(feature.getFlatCoordinates(), 0, ends, feature.getStride(), x, y);
}
