// Measuring on the map: distance and bearing between places that are clicked or, by keys, brought to the middle.

import Feature from "ol/Feature";
import { LineString } from "ol/geom";
import VectorLayer from "ol/layer/Vector";
import VectorSource from "ol/source/Vector";
import { fromLonLat, toLonLat } from "ol/proj";
import { Circle, Fill, Stroke, Style } from "ol/style";
import { MultiPoint } from "ol/geom";
import { legTo } from "../state/control";
import { setAttribute, setText } from "../ui/dom";
import { bearing, distance } from "../ui/format";
import { t } from "../words/words";
import { over } from "./layers";
import type { FleetMap } from "./map";

type Place = readonly [number, number];

/** A tool that begins and ends measuring, and what was measured. */
export function createMeasure(map: FleetMap): void {
  const target = map.ol.getTargetElement();
  const button = map.tools.button("measure", t("Measure"), t("Distance and bearing between places"));
  const told = map.tools.line("measured");
  const line = new Feature(new LineString([]));
  const style = (): Style[] => {
    const { ink, halo } = map.palette();
    const dots = (radius: number, colour: string): Style =>
      new Style({ geometry: (feature) => new MultiPoint((feature.getGeometry() as LineString).getCoordinates()), image: new Circle({ radius, fill: new Fill({ color: colour }) }) });
    return [new Style({ stroke: new Stroke({ color: halo, width: 6 }) }), new Style({ stroke: new Stroke({ color: ink, width: 2.5, lineDash: [10, 6] }) }), dots(6, halo), dots(4, ink)];
  };
  const layer = new VectorLayer({ source: new VectorSource({ features: [line] }), style, zIndex: over("measure") });
  map.ol.addLayer(layer);
  map.onRepaint(() => layer.changed());

  let on = false;
  let places: Place[] = [];
  const show = (): void => {
    line.getGeometry()?.setCoordinates(places.map(([lat, lon]) => fromLonLat([lon, lat])));
    setText(told, on ? text(places) : "");
  };
  setAttribute(button, "aria-pressed", "false");
  const measure = (begin: boolean): void => {
    on = begin;
    places = [];
    target?.toggleAttribute("data-measuring", on);
    setAttribute(button, "aria-pressed", String(on));
    show();
  };
  const add = (coordinate: number[] | undefined): void => {
    const [lon, lat] = toLonLat(coordinate ?? []);
    if (!on || lat === undefined || lon === undefined) return;
    places = [...places, [lat, lon]];
    show();
  };
  button.addEventListener("click", () => {
    measure(!on);
    if (on) target?.focus();
  });
  map.clicks.claim("measure", (event) => {
    add(event.coordinate as number[]);
    return on;
  });
  target?.addEventListener("keydown", (event) => {
    if (!on) return;
    if (event.key === "Enter") add(map.ol.getView().getCenter());
    else if (event.key === "Backspace") {
      places = places.slice(0, -1);
      show();
    } else if (event.key === "Escape") {
      measure(false);
      button.focus();
    } else return;
    event.preventDefault();
  });
}

/** What to do next, or what was measured. */
function text(places: readonly Place[]): string {
  if (places.length < 2) return places.length ? t("Click the next place, or Enter for the middle of the map.") : t("Click a place, or Enter for the middle of the map; Escape ends.");
  let sum = 0;
  let last = 0;
  for (let at = 1; at < places.length; at++) {
    const [from, to] = [places[at - 1], places[at]];
    if (!from || !to) continue;
    const leg = legTo({ lat_deg: from[0], lon_deg: from[1] }, to);
    sum += leg.distance_m;
    last = leg.bearing_rad;
  }
  return places.length === 2 ? `${distance(sum)}, ${bearing(last)}` : t("{sum} by {n} legs, the last {last}", { sum: distance(sum), n: places.length - 1, last: bearing(last) });
}
