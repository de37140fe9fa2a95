// Range rings around the vessel that is chosen: round distances that fit what is shown.

import Feature from "ol/Feature";
import type OlMap from "ol/Map";
import { Circle, Point } from "ol/geom";
import VectorLayer from "ol/layer/Vector";
import VectorSource from "ol/source/Vector";
import { fromLonLat } from "ol/proj";
import { Fill, Stroke, Style, Text } from "ol/style";
import { setAttribute } from "../ui/dom";
import { t } from "../words/words";
import { over } from "./layers";
import { CANVAS_FONT, type Palette } from "./palette";
import { ringStep_m } from "./scale";
import type { MapTools } from "./tools";

/** From one ring to the next at least, px. */
const APART_PX = 90;
const RINGS = 4;
/** Remembers in this browser whether somebody wants them. */
const KEPT = "lutra-range-rings";

export interface Rings {
  /** The vessel is here; undefined for none. */
  update(place: { readonly lat_deg: number; readonly lon_deg: number } | undefined): void;
  repaint(): void;
}

export function createRings(map: OlMap, tools: MapTools, palette: () => Palette): Rings {
  const button = tools.button("rings", t("Range rings"), t("Around the vessel that is chosen"));
  const source = new VectorSource();
  const layer = new VectorLayer({ source, zIndex: over("rings") });
  map.addLayer(layer);
  let on = localStorage.getItem(KEPT) === "on";
  let here: Parameters<Rings["update"]>[0];
  let drawn = "";
  const style = (text: string): Style[] => {
    const { ink, halo } = palette();
    const label = new Text({ text, font: `600 12px ${CANVAS_FONT}`, offsetY: -9, fill: new Fill({ color: ink }), stroke: new Stroke({ color: halo, width: 4 }) });
    return text ? [new Style({ text: label })] : [new Style({ stroke: new Stroke({ color: halo, width: 3 }) }), new Style({ stroke: new Stroke({ color: ink, width: 1, lineDash: [2, 4] }) })];
  };
  const draw = (): void => {
    const perMetre = here ? 1 / Math.cos((here.lat_deg * Math.PI) / 180) : 1;
    const step = ringStep_m(((map.getView().getResolution() ?? 1) * APART_PX) / perMetre);
    const state = on && here ? `${here.lat_deg}/${here.lon_deg}/${step}` : "";
    if (state === drawn) return;
    drawn = state;
    source.clear(true);
    if (!state || !here) return;
    const centre = fromLonLat([here.lon_deg, here.lat_deg]);
    const [x = 0, y = 0] = centre;
    for (let ring = 1; ring <= RINGS; ring++) {
      // A metre on the ground is more on this projection, the farther from the equator.
      const radius = ring * step * perMetre;
      const circle = new Feature(new Circle(centre, radius));
      const label = new Feature(new Point([x, y + radius]));
      circle.setStyle(style(""));
      label.setStyle(style(ring * step < 1_000 ? `${ring * step} m` : `${(ring * step) / 1_000} km`));
      source.addFeatures([circle, label]);
    }
  };
  const show = (whether: boolean): void => {
    on = whether;
    setAttribute(button, "aria-pressed", String(on));
    draw();
  };
  show(on);
  button.addEventListener("click", () => {
    localStorage.setItem(KEPT, on ? "off" : "on");
    show(!on);
  });
  map.getView().on("change:resolution", draw);
  return {
    update(place) {
      here = place;
      draw();
    },
    repaint() {
      drawn = "";
      draw();
    },
  };
}
