// Where the person with this device is, on the map: asked of the browser, with consent, when somebody turns it on. It stays
// in this page and is not sent to the server.

import Feature from "ol/Feature";
import { Circle, Point } from "ol/geom";
import VectorLayer from "ol/layer/Vector";
import VectorSource from "ol/source/Vector";
import { fromLonLat } from "ol/proj";
import { Circle as Dot, Fill, Stroke, Style } from "ol/style";
import { setAttribute, setText } from "../ui/dom";
import { t } from "../words/words";
import { over } from "./layers";
import type { FleetMap } from "./map";
import { ownPlaceText, type OwnPlace } from "../state/ownplace";

/** Remembers for this window that somebody turned it on. */
const WANTED = "lutra-own-place";
/** The text is brought up to date so often, ms. */
const AGAIN_MS = 1_000;

/** A tool that shows and hides the place, and what is known of it; `vessel` gives the one it is compared with. */
export function createOwnPlace(map: Pick<FleetMap, "ol" | "palette" | "onRepaint" | "tools">, vessel: () => { name: string; lat_deg: number; lon_deg: number } | undefined): void {
  const button = map.tools.button("person", t("My position"), t("Shown on this page only; it is not sent to the server"));
  const told = map.tools.line("own-told");
  setAttribute(button, "aria-pressed", "false");
  const [dot, around] = [new Feature(new Point([])), new Feature(new Circle([0, 0], 0))];
  const layer = new VectorLayer({ source: new VectorSource({ features: [around, dot] }), zIndex: over("own"), style: () => [] });
  const paint = (): void => {
    const { ink, halo } = map.palette();
    // A filled ring within a ring: no vessel and no tag looks like it.
    dot.setStyle([new Style({ image: new Dot({ radius: 10, fill: new Fill({ color: halo }), stroke: new Stroke({ color: ink, width: 2 }) }) }), new Style({ image: new Dot({ radius: 5, fill: new Fill({ color: ink }) }) })]);
    around.setStyle(new Style({ stroke: new Stroke({ color: ink, width: 1.5, lineDash: [4, 4] }) }));
  };
  paint();
  map.ol.addLayer(layer);
  map.onRepaint(paint);

  let watch: number | undefined;
  let timer: number | undefined;
  let last: OwnPlace | undefined;
  const show = (): void => setText(told, watch === undefined ? "" : ownPlaceText(last, vessel(), Date.now()));
  const draw = (): void => {
    const centre = last ? fromLonLat([last.lon_deg, last.lat_deg]) : undefined;
    dot.getGeometry()?.setCoordinates(centre ?? []);
    // A metre on the ground is more on this projection, the farther from the equator.
    around.getGeometry()?.setCenterAndRadius(centre ?? [0, 0], last ? last.accuracy_m / Math.cos((last.lat_deg * Math.PI) / 180) : 0);
    show();
  };
  const end = (words = ""): void => {
    if (watch !== undefined) navigator.geolocation.clearWatch(watch);
    window.clearInterval(timer);
    [watch, last] = [undefined, undefined];
    sessionStorage.removeItem(WANTED);
    setAttribute(button, "aria-pressed", "false");
    draw();
    setText(told, words);
  };
  const begin = (): void => {
    sessionStorage.setItem(WANTED, "on");
    setAttribute(button, "aria-pressed", "true");
    watch = navigator.geolocation.watchPosition(
      ({ coords, timestamp }) => {
        last = { lat_deg: coords.latitude, lon_deg: coords.longitude, accuracy_m: coords.accuracy, atMs: timestamp };
        draw();
      },
      (error) => {
        // Without a satellite for a while the last place stays, with its age.
        if (error.code === error.PERMISSION_DENIED) end(window.isSecureContext ? t("This browser may not show your position: allow it in its settings for this site.") : t("Browsers give a position to encrypted pages only: open this server by https."));
        else show();
      },
      { enableHighAccuracy: true, maximumAge: 1_000 },
    );
    timer = window.setInterval(show, AGAIN_MS);
    show();
  };
  button.addEventListener("click", () => (watch === undefined ? begin() : end()));
  if (sessionStorage.getItem(WANTED) === "on") begin();
}
