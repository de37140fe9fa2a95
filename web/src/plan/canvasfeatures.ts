// What of a plan lies on the map, and how it is drawn: its way, the places one takes hold of, and what is between them.

import Feature from "ol/Feature";
import { Circle as CircleGeometry, LineString, Point, Polygon } from "ol/geom";
import { fromLonLat } from "ol/proj";
import { Circle, Fill, RegularShape, Stroke, Style, Text } from "ol/style";
import type { PlanDocument, PlanLeg, PlanPlace } from "../api/types.gen";
import { CANVAS_FONT, type Palette } from "../map/palette";
import { middle, type Vertex, vertices, wayOf } from "../state/plan";
import { rowsCorners } from "../state/rows";
import { type Grip, gripsOf } from "../state/wholes";
import { gripStyle } from "./grips";

/** Lines with more vertices than this have no handles between them, which would only hide it. */
const MOST_HANDLES = 150;

/** The way of all of a plan, in the map's coordinates. */
export function routeOf(plan: PlanDocument, legs: readonly PlanLeg[]): number[][] {
  const line = plan.maneuvers.flatMap((step) => wayOf(step, legs));
  const [first] = line;
  if (plan.repeat && first) line.push(first);
  return line.map(xy);
}

/** Circles that are kept to, and the area of the rows that are chosen. */
export function areasOf(plan: PlanDocument, selected: Vertex | undefined): Feature[] {
  const circles = plan.maneuvers.flatMap(({ task }) => {
    if (task.kind !== "station_keeping" && task.kind !== "loiter") return [];
    // A metre on the ground is more on this projection, the farther from the equator.
    return [new Feature<CircleGeometry | Polygon>(new CircleGeometry(xy(task.at), task.radius_m / Math.max(0.01, Math.cos((task.at.lat_deg * Math.PI) / 180))))];
  });
  const chosen = selected && plan.maneuvers[selected.step]?.task;
  if (chosen?.kind === "rows") circles.push(new Feature({ geometry: new Polygon([[...rowsCorners(chosen), chosen.at].map(xy)]), area: true }));
  return circles;
}

/** What one takes hold of: vertices, handles between them, and with `grips` those of the whole maneuver that is chosen. */
export function holdsOf(plan: PlanDocument, legs: readonly PlanLeg[], selected: Vertex | undefined, grips: boolean): Feature[] {
  const features: Feature[] = [];
  const all = vertices(plan);
  all.forEach(({ vertex: one, place }, index) => {
    const step = plan.maneuvers[one.step];
    const feature = new Feature({ geometry: new Point(xy(place)), vertex: one });
    feature.set("label", one.point === 0 ? `${one.step + 1} ${step?.id ?? ""}` : "", true);
    features.push(feature);
    const next = all[index + 1];
    if (!next || !step || all.length > MOST_HANDLES) return;
    const from = next.vertex.step === one.step ? place : (wayOf(step, legs).at(-1) ?? place);
    features.push(new Feature({ geometry: new Point(xy(middle(from, next.place))), after: one }));
  });
  if (selected && grips) for (const grip of gripsOf(plan, selected.step)) features.push(new Feature({ geometry: new Point(xy(grip.place)), grip }));
  return features;
}

/** What is drawn by: the colours, which vertex is chosen, the way itself, and how the map is turned. */
export interface Look {
  readonly palette: Palette;
  readonly selected: Vertex | undefined;
  readonly route: Feature;
  readonly rotation: number;
}

export function canvasStyle(feature: Feature, { palette, selected, route, rotation }: Look): Style[] {
  const { ink, halo, series } = palette;
  const colour = series[0] ?? ink;
  const grip = feature.get("grip") as Grip | undefined;
  if (grip) return [gripStyle(grip, palette, rotation)];
  if (feature.get("area")) return [new Style({ stroke: new Stroke({ color: colour, width: 1.5, lineDash: [2, 5] }), zIndex: 0 })];
  const vertex = feature.get("vertex") as Vertex | undefined;
  if (vertex) return vertexStyle(vertex, feature.get("label") as string, vertex.step === selected?.step && vertex.point === selected.point, palette);
  if (feature.get("after")) {
    const image = new Circle({ radius: 5, fill: new Fill({ color: halo }), stroke: new Stroke({ color: colour, width: 1.5 }) });
    return [new Style({ image, zIndex: 2 })];
  }
  const stroke = feature === route ? new Stroke({ color: colour, width: 3 }) : new Stroke({ color: colour, width: 2, lineDash: [6, 5] });
  return [new Style({ stroke: new Stroke({ color: halo, width: 6 }), zIndex: 0 }), new Style({ stroke, zIndex: 1 })];
}

function vertexStyle({ point }: Vertex, label: string, chosen: boolean, { ink, halo, series }: Palette): Style[] {
  const fill = new Fill({ color: chosen ? ink : halo });
  const text = new Text({
    text: label,
    font: `600 13px ${CANVAS_FONT}`,
    offsetY: -18,
    overflow: true,
    fill: new Fill({ color: ink }),
    stroke: new Stroke({ color: halo, width: 4 }),
  });
  const image = (stroke: Stroke): Circle | RegularShape =>
    point === 0 ? new Circle({ radius: chosen ? 10 : 8, fill, stroke }) : new RegularShape({ points: 4, angle: Math.PI / 4, radius: chosen ? 11 : 8, fill, stroke });
  return [
    new Style({ image: image(new Stroke({ color: halo, width: 6 })), zIndex: 3 }),
    new Style({ image: image(new Stroke({ color: chosen ? ink : (series[0] ?? ink), width: 3 })), text, zIndex: chosen ? 5 : 4 }),
  ];
}

export function xy(place: PlanPlace): number[] {
  return fromLonLat([place.lon_deg, place.lat_deg]);
}

/** A line without places yet. */
export function emptyLine(): Feature<LineString> {
  return new Feature(new LineString([]));
}
