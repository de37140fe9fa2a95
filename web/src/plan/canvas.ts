// A plan on the map: drawn, clicked and dragged. What changes is told, not changed here.

import type Feature from "ol/Feature";
import type MapBrowserEvent from "ol/MapBrowserEvent";
import type { Point } from "ol/geom";
import DoubleClickZoom from "ol/interaction/DoubleClickZoom";
import PointerInteraction from "ol/interaction/Pointer";
import VectorLayer from "ol/layer/Vector";
import VectorSource from "ol/source/Vector";
import { boundingExtent } from "ol/extent";
import { toLonLat } from "ol/proj";
import type { PlanDocument, PlanLeg, PlanPlace } from "../api/types.gen";
import { over } from "../map/layers";
import type { FleetMap } from "../map/map";
import { type Vertex, vertices } from "../state/plan";
import type { Grip } from "../state/wholes";
import { createArea } from "./area";
import { areasOf, canvasStyle, emptyLine, holdsOf, routeOf, xy } from "./canvasfeatures";
import { GRIP_PX, gripOffset } from "./grips";
import type { SketchView } from "./sketching";

/** A finger or pointer is on a vertex within this, px. */
const NEAR_PX = 14;
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
  return new Canvas(map, handlers);
}

type Pull = (place: PlanPlace, done: boolean) => void;

class Canvas implements PlanCanvas {
  private readonly lines = new VectorSource();
  private readonly source = new VectorSource();
  private readonly route = emptyLine();
  private readonly area: ReturnType<typeof createArea>;
  private drawn: PlanDocument | undefined;
  private selected: Vertex | undefined;
  /** What is dragged. */
  private held: { readonly pull: Pull; moved: boolean } | undefined;

  constructor(private readonly map: FleetMap, private readonly handlers: CanvasHandlers) {
    this.area = createArea(map, NEAR_PX);
    // What is told of legs lies between the lines and what one takes hold of.
    const layers = ([[this.lines, "planLines"], [this.source, "planPlaces"]] as const).map(([of, at]) => new VectorLayer({ source: of, style: (feature) => this.styleOf(feature as Feature), updateWhileInteracting: true, zIndex: over(at) }));
    for (const layer of layers) map.ol.addLayer(layer);
    map.onRepaint(() => layers.forEach((layer) => layer.changed()));
    map.ol.addInteraction(new PointerInteraction({ handleDownEvent: (event) => this.down(event), handleDragEvent: (event) => this.drag(event), handleUpEvent: (event) => this.up(event) }));
    this.listen();
    // Two quick clicks are two points here.
    for (const one of map.ol.getInteractions().getArray()) if (one instanceof DoubleClickZoom) one.setActive(false);
  }

  sketch(view: SketchView | undefined): void {
    this.area.draw(view);
  }

  update(plan: PlanDocument, vertex: Vertex | undefined, legs: readonly PlanLeg[]): void {
    [this.drawn, this.selected] = [plan, vertex];
    this.route.getGeometry()?.setCoordinates(routeOf(plan, legs));
    this.lines.clear(true);
    this.lines.addFeatures([this.route, ...areasOf(plan, vertex)]);
    this.source.clear(true);
    this.source.addFeatures(holdsOf(plan, legs, vertex, this.handlers.grips && !this.handlers.sketches()));
  }

  fit(): void {
    const places = this.drawn ? vertices(this.drawn).map(({ place }) => xy(place)) : [];
    for (const [x = 0, y = 0] of this.route.getGeometry()?.getCoordinates() ?? []) places.push([x, y]);
    if (places.length) this.map.ol.getView().fit(boundingExtent(places), { padding: [90, 70, 70, 70], maxZoom: 17, duration: 0 });
  }

  apart(): number {
    return (this.map.ol.getView().getResolution() ?? 1) * APART_PX * Math.cos((this.centre().lat_deg * Math.PI) / 180);
  }

  centre(): PlanPlace {
    return placeAt(this.map.ol.getView().getCenter() ?? [0, 0]);
  }

  reveal(place: PlanPlace): void {
    const { ol } = this.map;
    const [x = 0, y = 0] = xy(place);
    const [west = 0, south = 0, east = 0, north = 0] = ol.getView().calculateExtent(ol.getSize());
    if (x < west || x > east || y < south || y > north) ol.getView().setCenter([x, y]);
  }

  private styleOf(feature: Feature): ReturnType<typeof canvasStyle> {
    const { map, selected, route } = this;
    return canvasStyle(feature, { palette: map.palette(), selected, route, rotation: map.ol.getView().getRotation() });
  }

  private listen(): void {
    const { map, handlers } = this;
    // At once: one who draws does not wait whether a second click comes.
    map.ol.on("click", (event) => {
      if (handlers.sketches() && this.area.closes(event.pixel)) handlers.closed();
      else if (!this.at(event)) handlers.clicked(placeAt(event.coordinate));
    });
    map.clicks.claim("edit", (event) => handlers.draws() || this.at(event) !== undefined);
    map.ol.on("pointermove", (event) => {
      if (event.dragging) return;
      if (handlers.sketches()) handlers.led(placeAt(event.coordinate));
      (map.ol.getTargetElement() ?? document.body).dataset["over"] = overWhat(this.at(event));
    });
  }

  // Dragging.

  private down(event: MapBrowserEvent): boolean {
    const { handlers } = this;
    const [feature, from] = [this.at(event), placeAt(event.coordinate)];
    if (!feature && !handlers.stretches()) return false;
    this.held = { pull: feature ? this.taken(feature, from) : (to, done) => handlers.stretched(from, to, done), moved: false };
    return true;
  }

  private drag(event: MapBrowserEvent): void {
    const { held, handlers } = this;
    if (!held) return;
    // A second finger leads the map.
    if (handlers.stretches() && (event.activePointers?.length ?? 1) > 1) {
      this.held = undefined;
      return handlers.dropped();
    }
    held.moved = true;
    held.pull(placeAt(event.coordinate), false);
  }

  private up(event: MapBrowserEvent): boolean {
    if (this.held?.moved) this.held.pull(placeAt(event.coordinate), true);
    this.held = undefined;
    return false;
  }

  /** What a drag that begins on a feature does. */
  private taken(feature: Feature, from: PlanPlace): Pull {
    const { handlers } = this;
    const grip = feature.get("grip") as Grip | undefined;
    if (grip) return (place, done) => handlers.pulled(grip, from, place, done);
    const vertex = (feature.get("vertex") as Vertex | undefined) ?? handlers.between(feature.get("after") as Vertex, from);
    handlers.select(vertex);
    return (place, done) => handlers.moved(vertex, place, done);
  }

  /** The vertex or grip under the pointer, whichever is nearer, or else a handle between two. */
  private at(event: MapBrowserEvent): Feature | undefined {
    if (this.handlers.sketches()) return undefined;
    const [vertex, grip] = [this.near(event, "vertex", NEAR_PX), this.near(event, "grip", GRIP_PX)];
    const taken = vertex.feature && (!grip.feature || vertex.px <= grip.px) ? vertex : grip;
    return taken.feature ?? this.near(event, "after", NEAR_PX).feature;
  }

  private near(event: MapBrowserEvent, kind: "vertex" | "grip" | "after", within: number): { feature?: Feature; px: number } {
    let best: { feature?: Feature; px: number } = { px: within };
    for (const feature of this.source.getFeatures()) {
      const px = feature.get(kind) ? this.away(feature, event.pixel) : Infinity;
      if (px <= best.px) best = { feature, px };
    }
    return best;
  }

  /** How far a feature is from the pointer, px: by distance, which needs no picture to be read back. */
  private away(feature: Feature, [x = 0, y = 0]: readonly number[]): number {
    const { ol } = this.map;
    const [left, top] = ol.getPixelFromCoordinate((feature.getGeometry() as Point).getCoordinates()) ?? [];
    if (left === undefined || top === undefined) return Infinity;
    const grip = feature.get("grip") as Grip | undefined;
    const [right, down] = grip ? gripOffset(grip, ol.getView().getRotation()) : [0, 0];
    return Math.hypot(left + right - x, top + down - y);
  }
}

function placeAt(coordinate: readonly number[]): PlanPlace {
  const [lon = 0, lat = 0] = toLonLat([...coordinate]);
  return { lat_deg: lat, lon_deg: lon };
}

/** What a pointer over it looks like. */
function overWhat(feature: Feature | undefined): string {
  return feature ? ((feature.get("grip") as Grip | undefined)?.kind ?? "vertex") : "";
}
