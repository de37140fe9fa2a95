// A plan on the map: drawn, clicked and dragged. What changes is told, not changed here.

import Feature from "ol/Feature";
import type MapBrowserEvent from "ol/MapBrowserEvent";
import { Circle as CircleGeometry, LineString, Point, Polygon } from "ol/geom";
import DoubleClickZoom from "ol/interaction/DoubleClickZoom";
import PointerInteraction from "ol/interaction/Pointer";
import VectorLayer from "ol/layer/Vector";
import VectorSource from "ol/source/Vector";
import { boundingExtent } from "ol/extent";
import { fromLonLat, toLonLat } from "ol/proj";
import { Circle, Fill, RegularShape, Stroke, Style, Text } from "ol/style";
import type { PlanDocument, PlanLeg, PlanPlace } from "../api/types.gen";
import { over } from "../map/layers";
import type { FleetMap } from "../map/map";
import { middle, type Vertex, vertices, wayOf } from "../state/plan";
import { rowsCorners } from "../state/rows";
import { type Grip, gripsOf } from "../state/wholes";
import { createArea } from "./area";
import { GRIP_PX, gripOffset, gripStyle } from "./grips";
import type { SketchView } from "./sketching";
import { CANVAS_FONT } from "../map/palette";

/** A finger or pointer is on a vertex within this, px. */
const NEAR_PX = 14;
/** Lines with more vertices than this have no handles between them, which would only hide it. */
const MOST_HANDLES = 150;
/** A copy lies so far beside its original, px. */
const APART_PX = 26;

export interface CanvasHandlers {
  /** Whether a tool is in hand, so that a click draws. */
  draws(): boolean;
  /** An area is being drawn: what lies there is not taken hold of. */
  sketches(): boolean;
  /** A rectangle is drawn from one corner to the other; answers whether that is what a drag does. */
  stretches(): boolean;
  stretched(from: PlanPlace, to: PlanPlace, done: boolean): void;
  /** The rectangle was not meant. */
  dropped(): void;
  /** The pointer is here while an area is drawn. */
  led(place: PlanPlace): void;
  /** The first corner of an area was clicked again. */
  closed(): void;
  /** Somebody clicked beside everything. */
  clicked(place: PlanPlace): void;
  select(vertex: Vertex): void;
  /** A vertex is being dragged; `done` when it is let go. */
  moved(vertex: Vertex, place: PlanPlace, done: boolean): void;
  /** A place between a vertex and the next is taken hold of; answers which vertex it is then. */
  between(after: Vertex, place: PlanPlace): Vertex;
  /** A whole maneuver is pulled by a grip that was taken at `from`; `done` when it is let go. */
  pulled(grip: Grip, from: PlanPlace, to: PlanPlace, done: boolean): void;
  /** Whether there are grips: not for who may only look. */
  readonly grips: boolean;
}

export interface PlanCanvas {
  update(plan: PlanDocument, selected: Vertex | undefined, legs: readonly PlanLeg[]): void;
  /** The area that is being drawn; undefined for none. */
  sketch(view: SketchView | undefined): void;
  /** Brings all of the plan into view. */
  fit(): void;
  centre(): PlanPlace;
  /** Brings a place into view if it is not. */
  reveal(place: PlanPlace): void;
  /** How far apart two things are that one tells apart here, m. */
  apart(): number;
}

/** Draws on `map`. */
export function createCanvas(map: FleetMap, handlers: CanvasHandlers): PlanCanvas {
  const lines = new VectorSource();
  const source = new VectorSource();
  const route = new Feature(new LineString([]));
  const area = createArea(map, NEAR_PX);
  let drawn: PlanDocument | undefined;
  let selected: Vertex | undefined;
  // What is told of legs lies between the lines and what one takes hold of.
  const layers = ([[lines, "planLines"], [source, "planPlaces"]] as const).map(([of, at]) => new VectorLayer({ source: of, style: (feature) => styleOf(feature as Feature), updateWhileInteracting: true, zIndex: over(at) }));
  for (const layer of layers) map.ol.addLayer(layer);
  map.onRepaint(() => layers.forEach((layer) => layer.changed()));

  const styleOf = (feature: Feature): Style[] => {
    const { ink, halo, series } = map.palette();
    const colour = series[0] ?? ink;
    const grip = feature.get("grip") as Grip | undefined;
    if (grip) return [gripStyle(grip, map.palette(), map.ol.getView().getRotation())];
    if (feature.get("area")) return [new Style({ stroke: new Stroke({ color: colour, width: 1.5, lineDash: [2, 5] }), zIndex: 0 })];
    const vertex = feature.get("vertex") as Vertex | undefined;
    if (vertex) {
      const chosen = vertex.step === selected?.step && vertex.point === selected.point;
      const fill = new Fill({ color: chosen ? ink : halo });
      const first = vertex.point === 0;
      const label = new Text({
        text: feature.get("label") as string,
        font: `600 13px ${CANVAS_FONT}`,
        offsetY: -18,
        overflow: true,
        fill: new Fill({ color: ink }),
        stroke: new Stroke({ color: halo, width: 4 }),
      });
      const image = (stroke: Stroke): Circle | RegularShape =>
        first ? new Circle({ radius: chosen ? 10 : 8, fill, stroke }) : new RegularShape({ points: 4, angle: Math.PI / 4, radius: chosen ? 11 : 8, fill, stroke });
      return [
        new Style({ image: image(new Stroke({ color: halo, width: 6 })), zIndex: 3 }),
        new Style({ image: image(new Stroke({ color: chosen ? ink : colour, width: 3 })), text: label, zIndex: chosen ? 5 : 4 }),
      ];
    }
    if (feature.get("after")) {
      const image = new Circle({ radius: 5, fill: new Fill({ color: halo }), stroke: new Stroke({ color: colour, width: 1.5 }) });
      return [new Style({ image, zIndex: 2 })];
    }
    const dashed = feature !== route;
    const stroke = dashed ? new Stroke({ color: colour, width: 2, lineDash: [6, 5] }) : new Stroke({ color: colour, width: 3 });
    return [new Style({ stroke: new Stroke({ color: halo, width: 6 }), zIndex: 0 }), new Style({ stroke, zIndex: 1 })];
  };

  /** How far a feature is from the pointer, px: by distance, which needs no picture to be read back. */
  const away = (feature: Feature, [x = 0, y = 0]: readonly number[]): number => {
    const [left, top] = map.ol.getPixelFromCoordinate((feature.getGeometry() as Point).getCoordinates()) ?? [];
    if (left === undefined || top === undefined) return Infinity;
    const grip = feature.get("grip") as Grip | undefined;
    const [right, down] = grip ? gripOffset(grip, map.ol.getView().getRotation()) : [0, 0];
    return Math.hypot(left + right - x, top + down - y);
  };
  /** The vertex or grip under the pointer, whichever is nearer, or else a handle between two. */
  const at = (event: MapBrowserEvent): Feature | undefined => {
    const near = (kind: "vertex" | "grip" | "after", within: number): { feature?: Feature; px: number } => {
      let best: { feature?: Feature; px: number } = { px: within };
      for (const feature of source.getFeatures()) {
        const px = feature.get(kind) ? away(feature, event.pixel) : Infinity;
        if (px <= best.px) best = { feature, px };
      }
      return best;
    };
    if (handlers.sketches()) return undefined;
    const [vertex, grip] = [near("vertex", NEAR_PX), near("grip", GRIP_PX)];
    const taken = vertex.feature && (!grip.feature || vertex.px <= grip.px) ? vertex : grip;
    return taken.feature ?? near("after", NEAR_PX).feature;
  };
  const placeOf = (event: MapBrowserEvent): PlanPlace => {
    const [lon = 0, lat = 0] = toLonLat(event.coordinate);
    return { lat_deg: lat, lon_deg: lon };
  };
  let held: { pull: (place: PlanPlace, done: boolean) => void; moved: boolean } | undefined;
  /** What a drag that begins on a feature does. */
  const taken = (feature: Feature, from: PlanPlace): ((place: PlanPlace, done: boolean) => void) => {
    const grip = feature.get("grip") as Grip | undefined;
    if (grip) return (place, done) => handlers.pulled(grip, from, place, done);
    const vertex = (feature.get("vertex") as Vertex | undefined) ?? handlers.between(feature.get("after") as Vertex, from);
    handlers.select(vertex);
    return (place, done) => handlers.moved(vertex, place, done);
  };
  const drop = (): void => {
    held = undefined;
    handlers.dropped();
  };
  map.ol.addInteraction(
    new PointerInteraction({
      handleDownEvent: (event) => {
        const [feature, from] = [at(event), placeOf(event)];
        if (!feature && !handlers.stretches()) return false;
        held = { pull: feature ? taken(feature, from) : (to, done) => handlers.stretched(from, to, done), moved: false };
        return true;
      },
      handleDragEvent: (event) => {
        if (!held) return;
        // A second finger leads the map.
        if (handlers.stretches() && (event.activePointers?.length ?? 1) > 1) return drop();
        held.moved = true;
        held.pull(placeOf(event), false);
      },
      handleUpEvent: (event) => {
        if (held?.moved) held.pull(placeOf(event), true);
        held = undefined;
        return false;
      },
    }),
  );
  // At once: one who draws does not wait whether a second click comes.
  map.ol.on("click", (event) => {
    if (handlers.sketches() && area.closes(event.pixel)) handlers.closed();
    else if (!at(event)) handlers.clicked(placeOf(event));
  });
  map.clicks.claim("edit", (event) => handlers.draws() || at(event) !== undefined);
  map.ol.on("pointermove", (event) => {
    if (event.dragging) return;
    if (handlers.sketches()) handlers.led(placeOf(event));
    (map.ol.getTargetElement() ?? document.body).dataset["over"] = overWhat(at(event));
  });
  // Two quick clicks are two points here.
  for (const one of map.ol.getInteractions().getArray()) if (one instanceof DoubleClickZoom) one.setActive(false);

  const centre = (): PlanPlace => {
    const [lon = 0, lat = 0] = toLonLat(map.ol.getView().getCenter() ?? [0, 0]);
    return { lat_deg: lat, lon_deg: lon };
  };

  return {
    sketch: area.draw,
    update(plan, vertex, legs) {
      [drawn, selected] = [plan, vertex];
      const ways = plan.maneuvers.map((step) => wayOf(step, legs));
      const line = ways.flat();
      const [first] = line;
      if (plan.repeat && first) line.push(first);
      route.getGeometry()?.setCoordinates(line.map(xy));
      const drawnLines: Feature[] = [route];
      const features: Feature[] = [];
      for (const { task } of plan.maneuvers) {
        if (task.kind !== "station_keeping" && task.kind !== "loiter") continue;
        // A metre on the ground is more on this projection, the farther from the equator.
        const radius = task.radius_m / Math.max(0.01, Math.cos((task.at.lat_deg * Math.PI) / 180));
        drawnLines.push(new Feature(new CircleGeometry(xy(task.at), radius)));
      }
      const all = vertices(plan);
      all.forEach(({ vertex: one, place }, index) => {
        const step = plan.maneuvers[one.step];
        const feature = new Feature({ geometry: new Point(xy(place)), vertex: one });
        feature.set("label", one.point === 0 ? `${one.step + 1} ${step?.id ?? ""}` : "", true);
        features.push(feature);
        const next = all[index + 1];
        if (!next || all.length > MOST_HANDLES) return;
        const from = next.vertex.step === one.step ? place : (ways[one.step]?.at(-1) ?? place);
        features.push(new Feature({ geometry: new Point(xy(middle(from, next.place))), after: one }));
      });
      const chosen = vertex && plan.maneuvers[vertex.step]?.task;
      if (chosen?.kind === "rows") drawnLines.push(new Feature({ geometry: new Polygon([[...rowsCorners(chosen), chosen.at].map(xy)]), area: true }));
      if (vertex && handlers.grips && !handlers.sketches()) for (const grip of gripsOf(plan, vertex.step)) features.push(new Feature({ geometry: new Point(xy(grip.place)), grip }));
      lines.clear(true);
      lines.addFeatures(drawnLines);
      source.clear(true);
      source.addFeatures(features);
    },
    fit() {
      const places = drawn ? vertices(drawn).map(({ place }) => xy(place)) : [];
      for (const [x = 0, y = 0] of route.getGeometry()?.getCoordinates() ?? []) places.push([x, y]);
      if (places.length) map.ol.getView().fit(boundingExtent(places), { padding: [90, 70, 70, 70], maxZoom: 17, duration: 0 });
    },
    apart: () => (map.ol.getView().getResolution() ?? 1) * APART_PX * Math.cos((centre().lat_deg * Math.PI) / 180),
    centre,
    reveal(place) {
      const extent = map.ol.getView().calculateExtent(map.ol.getSize());
      const [x = 0, y = 0] = xy(place);
      const [west = 0, south = 0, east = 0, north = 0] = extent;
      if (x < west || x > east || y < south || y > north) map.ol.getView().setCenter([x, y]);
    },
  };
}

/** What a pointer over it looks like. */
function overWhat(feature: Feature | undefined): string {
  return feature ? ((feature.get("grip") as Grip | undefined)?.kind ?? "vertex") : "";
}

function xy(place: PlanPlace): number[] {
  return fromLonLat([place.lon_deg, place.lat_deg]);
}
