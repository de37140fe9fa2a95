// What frames a map: scales, the place under the pointer, the arrow to the north, and the wheel.

import { defaults as defaultControls, MousePosition, ScaleLine } from "ol/control";
import { make } from "../ui/dom";
import { position } from "../ui/format";
import { t } from "../words/words";

/** A wheel that rests so long begins another turn, ms. */
const WHEEL_MS = 400;

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
