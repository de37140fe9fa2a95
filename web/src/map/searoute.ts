// A route on the sea chart under somebody's hands: the line, its ends and places to pass, which are dragged, and handles
// on the line, of which one makes a new place to pass.

import Feature from "ol/Feature";
import { LineString, Point, Polygon } from "ol/geom";
import PointerInteraction from "ol/interaction/Pointer";
import VectorLayer from "ol/layer/Vector";
import VectorSource from "ol/source/Vector";
import type MapBrowserEvent from "ol/MapBrowserEvent";
import { fromLonLat, toLonLat } from "ol/proj";
import { Circle, Fill, Stroke, Style, Text } from "ol/style";
import type { PlanPlace } from "../api/types.gen";
import { over } from "./layers";
import type { FleetMap } from "./map";
import { CANVAS_FONT } from "./palette";

/** A finger or pointer is on a handle within this, px. */
const NEAR_PX = 16;
/** Routes with more legs have handles on the longest of them only. */
const MOST_HANDLES = 40;

export interface SeaRouteHandlers {
  /** A chosen place is being dragged; `done` when it is let go. */
  moved(index: number, place: PlanPlace, done: boolean): void;
  /** The line was taken hold of on one of its legs: answers which chosen place that is now. */
  pulled(leg: number, place: PlanPlace): number;
  /** What stands on a chosen place; without it A and B on the ends, and numbers on the places between. */
  label?(index: number): string;
}

/** What is shown beside the route. */
export interface SeaRouteBeside {
  /** Areas to avoid, areas with a speed limit and what stands in them, and one that is being drawn. */
  readonly areas: readonly (readonly PlanPlace[])[];
  readonly slow: readonly { readonly corners: readonly PlanPlace[]; readonly label: string }[];
  readonly drawing: readonly PlanPlace[] | undefined;
  /** Other routes that may be chosen, by number. */
  readonly others: readonly { readonly number: number; readonly places: readonly PlanPlace[] }[];
  /** The narrowest gap, where nothing passes. */
  readonly gap: PlanPlace | undefined;
}

export interface SeaRouteOnMap {
  /** The chosen places, and the corners of the route between them; no corners while there is none. */
  update(chosen: readonly PlanPlace[], route: readonly PlanPlace[], beside?: SeaRouteBeside): void;
  clear(): void;
}

/** Without handlers it is only shown. */
export function createSeaRoute(map: FleetMap, handlers?: SeaRouteHandlers): SeaRouteOnMap {
  const [lines, places] = [new VectorSource(), new VectorSource()];
  const layers = ([[lines, "planLines"], [places, "planMarks"]] as const).map(([source, at]) => new VectorLayer({ source, style: (feature) => styleOf(feature as Feature), updateWhileInteracting: true, zIndex: over(at) }));
  for (const layer of layers) map.ol.addLayer(layer);
  map.onRepaint(() => layers.forEach((layer) => layer.changed()));

  const styleOf = (feature: Feature): Style[] => {
    const { ink, halo, series } = map.palette();
    const colour = series[1] ?? ink;
    const label = feature.get("label") as string | undefined;
    if (label !== undefined) {
      return [
        new Style({ image: new Circle({ radius: 13, fill: new Fill({ color: halo }), stroke: new Stroke({ color: halo, width: 4 }) }), zIndex: 3 }),
        new Style({
          image: new Circle({ radius: 12, fill: new Fill({ color: halo }), stroke: new Stroke({ color: colour, width: 3 }) }),
          text: new Text({ text: label, font: `700 13px ${CANVAS_FONT}`, fill: new Fill({ color: ink }) }),
          zIndex: 4,
        }),
      ];
    }
    if (feature.get("beside") !== undefined) return besideStyles(feature, ink, halo, map.palette().danger);
    if (feature.get("leg") !== undefined) {
      return [new Style({ image: new Circle({ radius: 5, fill: new Fill({ color: halo }), stroke: new Stroke({ color: colour, width: 2 }) }), zIndex: 2 })];
    }
    const dash = feature.get("wanted") === true ? { lineDash: [4, 8] } : {};
    return [new Style({ stroke: new Stroke({ color: halo, width: 8 }), zIndex: 0 }), new Style({ stroke: new Stroke({ color: colour, width: 4, ...dash }), zIndex: 1 })];
  };

  const at = (event: MapBrowserEvent): Feature | undefined => {
    const [x = 0, y = 0] = event.pixel;
    let [found, best]: [Feature | undefined, number] = [undefined, NEAR_PX ** 2];
    for (const feature of places.getFeatures()) {
      const pixel = map.ol.getPixelFromCoordinate((feature.getGeometry() as Point).getCoordinates());
      const away = pixel ? ((pixel[0] ?? 0) - x) ** 2 + ((pixel[1] ?? 0) - y) ** 2 : Infinity;
      // Where both are near, an end counts before a handle.
      const worth = feature.get("label") === undefined ? away + 1 : away;
      if (worth <= best) [found, best] = [feature, worth];
    }
    return found;
  };
  if (handlers) map.ol.addInteraction(dragging(at, handlers));

  const update = (chosen: readonly PlanPlace[], route: readonly PlanPlace[], beside?: SeaRouteBeside): void => {
    lines.clear(true);
    places.clear(true);
    if (beside) lines.addFeatures(besideOf(beside));
    const line = route.length > 1 ? route : chosen;
    if (line.length > 1) lines.addFeature(new Feature({ geometry: new LineString(line.map(xy)), wanted: route.length < 2 }));
    places.addFeatures(chosen.map((place, index) => new Feature({ geometry: new Point(xy(place)), index, label: handlers?.label?.(index) ?? name(index, chosen.length) })));
    if (!handlers) return;
    const legs = route.slice(1).map((to, leg) => ({ leg, from: xy(route[leg] ?? to), to: xy(to) }));
    const size = ({ from, to }: { from: number[]; to: number[] }): number => Math.hypot((to[0] ?? 0) - (from[0] ?? 0), (to[1] ?? 0) - (from[1] ?? 0));
    const handles = legs.sort((one, other) => size(other) - size(one)).slice(0, MOST_HANDLES);
    places.addFeatures(handles.map(({ leg, from, to }) => new Feature({ geometry: new Point([((from[0] ?? 0) + (to[0] ?? 0)) / 2, ((from[1] ?? 0) + (to[1] ?? 0)) / 2]), leg })));
  };
  return { update, clear: () => update([], []) };
}

function besideOf({ areas, slow, drawing, others, gap }: SeaRouteBeside): Feature[] {
  const ring = (corners: readonly PlanPlace[]): number[][] => [...corners, ...corners.slice(0, 1)].map(xy);
  return [
    ...areas.map((corners, at) => new Feature({ geometry: new Polygon([ring(corners)]), beside: "area", number: String(at + 1) })),
    ...slow.map(({ corners, label }) => new Feature({ geometry: new Polygon([ring(corners)]), beside: "slow", number: label })),
    ...others.map(({ number, places }) => new Feature({ geometry: new LineString(places.map(xy)), beside: "other", number: String(number) })),
    ...(drawing?.length ? [new Feature({ geometry: new LineString(drawing.map(xy)), beside: "drawing" }), ...drawing.map((place) => new Feature({ geometry: new Point(xy(place)), beside: "corner" }))] : []),
    ...(gap ? [new Feature({ geometry: new Point(xy(gap)), beside: "gap" })] : []),
  ];
}

function besideStyles(feature: Feature, ink: string, halo: string, danger: string): Style[] {
  switch (feature.get("beside") as string) {
    case "area":
    case "slow": {
      const colour = feature.get("beside") === "area" ? danger : ink;
      return [new Style({
        fill: new Fill({ color: `${colour}${colour === danger ? "33" : "1a"}` }),
        stroke: new Stroke({ color: colour, width: 2.5, lineDash: [8, 5] }),
        text: new Text({ text: feature.get("number") as string, overflow: true, font: `700 15px ${CANVAS_FONT}`, fill: new Fill({ color: ink }), stroke: new Stroke({ color: halo, width: 4 }) }),
        zIndex: -1,
      })];
    }
    case "other":
      return [
        new Style({ stroke: new Stroke({ color: halo, width: 6 }), zIndex: -3 }),
        new Style({
          stroke: new Stroke({ color: ink, width: 2 }),
          text: new Text({ text: feature.get("number") as string, placement: "line", overflow: true, font: `700 15px ${CANVAS_FONT}`, fill: new Fill({ color: ink }), stroke: new Stroke({ color: halo, width: 5 }) }),
          zIndex: -2,
        }),
      ];
    case "gap":
      return [new Style({ image: new Circle({ radius: 14, stroke: new Stroke({ color: halo, width: 7 }) }), zIndex: 5 }), new Style({ image: new Circle({ radius: 14, stroke: new Stroke({ color: danger, width: 3 }) }), zIndex: 6 })];
    case "corner":
      return [new Style({ image: new Circle({ radius: 5, fill: new Fill({ color: halo }), stroke: new Stroke({ color: ink, width: 2.5 }) }), zIndex: 3 })];
    default:
      return [new Style({ stroke: new Stroke({ color: halo, width: 6 }) }), new Style({ stroke: new Stroke({ color: ink, width: 2.5, lineDash: [8, 5] }) })];
  }
}

function dragging(at: (event: MapBrowserEvent) => Feature | undefined, handlers: SeaRouteHandlers): PointerInteraction {
  let held: number | undefined;
  return new PointerInteraction({
    handleDownEvent: (event) => {
      const feature = at(event);
      if (!feature) return false;
      const leg = feature.get("leg") as number | undefined;
      held = leg === undefined ? (feature.get("index") as number) : handlers.pulled(leg, placeOf(event));
      return true;
    },
    handleDragEvent: (event) => {
      if (held !== undefined) handlers.moved(held, placeOf(event), false);
    },
    handleUpEvent: (event) => {
      if (held !== undefined) handlers.moved(held, placeOf(event), true);
      held = undefined;
      return false;
    },
  });
}

/** A and B for the ends, numbers for the places between. */
function name(index: number, count: number): string {
  return index === 0 ? "A" : index === count - 1 ? "B" : String(index);
}

function placeOf(event: MapBrowserEvent): PlanPlace {
  const [lon_deg = 0, lat_deg = 0] = toLonLat(event.coordinate);
  return { lat_deg, lon_deg };
}

function xy(place: PlanPlace): number[] {
  return fromLonLat([place.lon_deg, place.lat_deg]);
}
