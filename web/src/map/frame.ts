// What frames a map: the graticule with its figures, scales, the place under the pointer, the arrow to the north, and the wheel.

import Graticule from "ol/layer/Graticule";
import { defaults as defaultControls, MousePosition, ScaleLine } from "ol/control";
import { Fill, Stroke, Text } from "ol/style";
import { make } from "../ui/dom";
import { latitude, longitude, position } from "../ui/format";
import { t } from "../words/words";
import { CHART } from "./layers";
import { CANVAS_FONT, type Palette } from "./palette";

/** A wheel that rests so long begins another turn, ms. */
const WHEEL_MS = 400;

/** The tools at the right edge cover so much: latitudes stand beside them. */
const BESIDE_TOOLS_PX = 58;
/** The words at the lower edge take two lines at most: longitudes stand above them (`.chart-credit`), and the scales above those. */
const ABOVE_WORDS_PX = 40;

export interface Wheel {
  isOwn(): boolean;
  dispose(): void;
}

/** `northUp` turns the map at once: a turn over several frames would be cut off by what else moves the map meanwhile. */
export function controls(northUp: () => void): ReturnType<typeof defaultControls> {
  return defaultControls({ attribution: false, rotateOptions: { tipLabel: t("North up"), autoHide: false, label: northArrow(), resetNorth: northUp } }).extend([
    new ScaleLine({ units: "metric", minWidth: 50 }),
    new ScaleLine({ units: "nautical", minWidth: 50, className: "ol-scale-nm" }),
    new MousePosition({
      projection: "EPSG:4326",
      placeholder: "WGS 84",
      coordinateFormat: ([lon, lat] = [0, 0]) => position({ lat_deg: lat ?? 0, lon_deg: lon ?? 0 }),
    }),
  ]);
}

/**
 * Tells a wheel that is turned over the map, which zooms it, from one that began beside it and scrolls the page: that one goes
 * on scrolling when the map comes under the pointer.
 */
export function wheelOn(root: HTMLElement): Wheel {
  let own = true;
  let lastMs = -Infinity;
  const turned = (event: WheelEvent): void => {
    if (event.timeStamp - lastMs > WHEEL_MS) own = event.target instanceof Node && root.contains(event.target);
    lastMs = event.timeStamp;
  };
  window.addEventListener("wheel", turned, { capture: true, passive: true });
  return { isOwn: () => own, dispose: () => window.removeEventListener("wheel", turned, { capture: true }) };
}

/** What the button shows that turns the map north up: it points north however the map is turned. */
function northArrow(): HTMLElement {
  return make("span", { class: "ol-compass arrow", "aria-hidden": "true" }, "▲\nN");
}

export function graticuleLayer({ ink, halo, grid }: Palette): Graticule {
  const text = new Text({ font: `12px ${CANVAS_FONT}`, fill: new Fill({ color: ink }), stroke: new Stroke({ color: halo, width: 3 }) });
  const along = text.clone();
  text.setTextBaseline("bottom");
  text.setOffsetY(-ABOVE_WORDS_PX);
  along.setTextAlign("end");
  along.setOffsetX(-BESIDE_TOOLS_PX);
  return new Graticule({
    strokeStyle: new Stroke({ color: grid, width: 1 }),
    showLabels: true,
    zIndex: CHART.graticule,
    wrapX: false,
    targetSize: 140,
    intervals: [10, 5, 2, 1, 30 / 60, 20 / 60, 10 / 60, 5 / 60, 2 / 60, 1 / 60, 30 / 3600, 12 / 3600, 6 / 3600, 3 / 3600, 1.2 / 3600, 0.6 / 3600],
    lonLabelStyle: text,
    latLabelStyle: along,
    lonLabelFormatter: longitude,
    latLabelFormatter: latitude,
  });
}
