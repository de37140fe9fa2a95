// What lies beneath all that moves: the chart and the graticule, in a map of their own that shares the view with the one above.
// A map draws all its layers whenever one changes; a chart is most of that work, and rests while vessels sail over it.

import OlMap from "ol/Map";
import type View from "ol/View";
import { make } from "../ui/dom";

/** Begins beneath whatever else `root` shows. */
export function createGround(root: HTMLElement, view: View): OlMap {
  const box = make("div", { class: "map-ground" });
  root.prepend(box);
  return new OlMap({ target: box, view, controls: [], interactions: [] });
}
