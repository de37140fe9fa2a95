// What a vessel's page lays over the map: the cursor that plots and tables share, and tags grouped by zoom.

import type OlMap from "ol/Map";
import Feature, { type FeatureLike } from "ol/Feature";
import { Point } from "ol/geom";
import VectorLayer from "ol/layer/Vector";
import Cluster from "ol/source/Cluster";
import VectorSource from "ol/source/Vector";
import { fromLonLat, toLonLat } from "ol/proj";
import type { Detection, TrackPoint } from "../api/types.gen";
import { tagName } from "../ui/format";
import type { Clicks } from "./clicks";
import { over } from "./layers";
import type { Palette } from "./palette";
import { cursorStyle, tagsStyle } from "./symbols";

/** Tags nearer to each other than this are one symbol, px. */
const TOGETHER_PX = 34;
/** The pointer is on the track within this, px. */
const NEAR_PX = 16;

export interface Overlays {
  /** Marks a place; null for none. */
  cursor(place: Pick<TrackPoint, "lat_deg" | "lon_deg"> | null): void;
  /** Tags, grouped by zoom; `told` gets those of a group that is clicked. */
  detections(all: readonly Detection[]): void;
  onTags(told: (group: readonly Detection[]) => void): void;
  /** `point` is asked what lies under the pointer: the track's points; `told` gets the nearest, or null off the track. */
  followPointer(points: () => readonly TrackPoint[], told: (point: TrackPoint | null) => void): void;
  /** `told` gets the nearest place of the followed track where that is clicked. */
  onTrack(told: (point: TrackPoint) => void): void;
  /** The next click gives a place, degrees north and east; null ends the wait. */
  pick(told: ((place: readonly [number, number]) => void) | null): void;
  repaint(): void;
}

export function createOverlays(map: OlMap, clicks: Clicks, palette: () => Palette): Overlays {
  const marker = new Feature(new Point([]));
  const tags = new VectorSource();
  const cluster = new Cluster({ distance: TOGETHER_PX, source: tags });
  const tagLayer = new VectorLayer({
    zIndex: over("tags"),
    source: cluster,
    style: (feature) => {
      const group = heard(feature);
      const tags = new Set(group.map(tagName));
      return tagsStyle(group.length, tags.size === 1 ? group[0]?.tag_id : undefined, palette());
    },
  });
  const cursorLayer = new VectorLayer({ zIndex: over("cursor"), source: new VectorSource({ features: [marker] }), style: () => cursorStyle(palette()) });
  map.addLayer(tagLayer);
  map.addLayer(cursorLayer);
  let picked: ((place: readonly [number, number]) => void) | null = null;
  let followed: () => readonly TrackPoint[] = () => [];
  let groupTold: (group: readonly Detection[]) => void = () => undefined;
  let trackTold: (point: TrackPoint) => void = () => undefined;
  clicks.claim("pick", ({ coordinate }) => {
    const [lon, lat] = toLonLat(coordinate);
    if (!picked || lon === undefined || lat === undefined) return false;
    picked([lat, lon]);
    return true;
  });
  clicks.claim("tags", ({ pixel }) => {
    const group = map.forEachFeatureAtPixel(pixel, heard, { hitTolerance: 6, layerFilter: (layer) => layer === tagLayer });
    if (group?.length) groupTold(group);
    return (group?.length ?? 0) > 0;
  });
  clicks.claim("track", ({ pixel }) => {
    const near = nearest(followed(), map, pixel as number[]);
    if (near) trackTold(near);
    return near !== undefined;
  });

  return {
    cursor(place) {
      marker.getGeometry()?.setCoordinates(place ? fromLonLat([place.lon_deg, place.lat_deg]) : []);
    },
    detections(all) {
      tags.clear(true);
      const placed = all.filter((one) => one.lat_deg !== null && one.lon_deg !== null);
      tags.addFeatures(placed.map((one) => {
        const feature = new Feature(new Point(fromLonLat([one.lon_deg ?? 0, one.lat_deg ?? 0])));
        feature.set("heard", one, true);
        return feature;
      }));
      cluster.refresh();
    },
    onTags: (told) => void (groupTold = told),
    onTrack: (told) => void (trackTold = told),
    followPointer(points, told) {
      followed = points;
      let on = false;
      map.on("pointermove", (event) => {
        if (event.dragging) return;
        const near = nearest(points(), map, event.pixel as number[]);
        if (near) told(near);
        else if (on) told(null);
        on = near !== undefined;
      });
      map.getViewport()?.addEventListener("pointerleave", () => {
        if (on) told(null);
        on = false;
      });
    },
    pick(told) {
      map.getTargetElement()?.toggleAttribute("data-picking", told !== null);
      picked = told;
    },
    repaint() {
      tagLayer.changed();
      cursorLayer.changed();
    },
  };
}

/** The tags of a group. */
function heard(group: FeatureLike): Detection[] {
  return ((group.get("features") ?? []) as Feature[]).map((one) => one.get("heard") as Detection);
}

/** The place between the points of a line that is nearest to a pixel, if it is near at all. */
function nearest(points: readonly TrackPoint[], map: OlMap, pixel: readonly number[]): TrackPoint | undefined {
  const [x = 0, y = 0] = map.getCoordinateFromPixel([...pixel]) ?? [];
  const limit = NEAR_PX * (map.getView().getResolution() ?? 1);
  let found: TrackPoint | undefined;
  let best = limit ** 2;
  for (let at = 1; at < points.length; at++) {
    const [one, other] = [points[at - 1], points[at]];
    if (!one || !other) continue;
    const [ax = 0, ay = 0] = fromLonLat([one.lon_deg, one.lat_deg]);
    const [bx = 0, by = 0] = fromLonLat([other.lon_deg, other.lat_deg]);
    const length = (bx - ax) ** 2 + (by - ay) ** 2;
    const along = length ? Math.max(0, Math.min(1, ((x - ax) * (bx - ax) + (y - ay) * (by - ay)) / length)) : 0;
    const away = (x - ax - along * (bx - ax)) ** 2 + (y - ay - along * (by - ay)) ** 2;
    if (away >= best) continue;
    best = away;
    found = {
      time_us: one.time_us + along * (other.time_us - one.time_us),
      lat_deg: one.lat_deg + along * (other.lat_deg - one.lat_deg),
      lon_deg: one.lon_deg + along * (other.lon_deg - one.lon_deg),
    };
  }
  return found;
}
