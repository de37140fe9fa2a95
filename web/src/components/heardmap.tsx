// Detections on the map, each at the place that its vessel had then.

import { boundingExtent } from "ol/extent";
import { fromLonLat } from "ol/proj";
import { useEffect, useRef } from "preact/hooks";
import type { Detection } from "../api/types.gen";
import { createMap, type FleetMap } from "../map/map";
import { t } from "../words/words";

interface Needs {
  readonly detections: readonly Detection[];
  /** What was asked for: with another question all of its answer is brought into view. */
  readonly whole: string;
  /** Called with those of a place that is chosen. */
  pick(group: readonly Detection[]): void;
}

export function HeardMap({ detections, whole, pick }: Needs) {
  const [box, map, picks] = [useRef<HTMLDivElement>(null), useRef<FleetMap | undefined>(undefined), useRef(pick)];
  picks.current = pick;
  const fit = useRef(() => undefined as void);
  fit.current = () => {
    const places = detections.flatMap(({ lat_deg, lon_deg }) => (lat_deg === null || lon_deg === null ? [] : [fromLonLat([lon_deg, lat_deg])]));
    if (places.length) map.current?.ol.getView().fit(boundingExtent(places), { padding: [60, 60, 60, 60], maxZoom: 16, duration: 0 });
  };
  useEffect(() => {
    if (!box.current) return undefined;
    const made = createMap(box.current, { showAll: () => fit.current() });
    made.overlays.onTags((group) => picks.current(group));
    map.current = made;
    return () => made.dispose();
  }, []);
  useEffect(() => map.current?.overlays.detections(detections), [detections]);
  useEffect(() => fit.current(), [whole]);
  return (
    <div class="map-box">
      <div ref={box} class="map" tabIndex={0} role="application" aria-label={t("Map of detections. Arrow keys move it, plus and minus zoom; the table has the same.")} />
    </div>
  );
}
