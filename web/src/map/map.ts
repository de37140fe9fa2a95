// The map: chart, tracks, vessels with heading and course, graticule, scale and cursor position. Needs no internet.

import OlMap from "ol/Map";
import View from "ol/View";
import Feature from "ol/Feature";
import { Circle, LineString, Point } from "ol/geom";
import Graticule from "ol/layer/Graticule";
import VectorLayer from "ol/layer/Vector";
import VectorImageLayer from "ol/layer/VectorImage";
import VectorSource from "ol/source/Vector";
import { defaults as defaultControls, MousePosition, ScaleLine } from "ol/control";
import { boundingExtent } from "ol/extent";
import { defaults as defaultInteractions, MouseWheelZoom } from "ol/interaction";
import { fromLonLat } from "ol/proj";
import { Fill, Stroke, Text } from "ol/style";
import type { Fix, System, TrackPoint } from "../api/types.gen";
import { latitude, longitude, position, systemName } from "../ui/format";
import { type ChartOnMap, createChart } from "./chart/chart";
import { make, setAttribute } from "../ui/dom";
import { CANVAS_FONT, type Palette, readPalette } from "./palette";
import { createOverlays, type Overlays } from "./overlays";
import { type Clicks, createClicks } from "./clicks";
import { createFollow } from "./follow";
import { CHART, over } from "./layers";
import { createOwnPlace } from "./ownplace";
import { createRings } from "./rings";
import { createTools, type MapTools } from "./tools";
import { placeAt, pointsUntil } from "../state/track";
import { aheadStyle, courseStyle, ringStyle, trackStyle, type VesselStyle, vesselStyle } from "./symbols";

/** The course vector shows so many seconds ahead. */
const AHEAD_S = 60;
/** Where the map is until something is known. */
const NOWHERE = fromLonLat([10.4, 63.44]);
const EARTH_M = 6_371_000;
/** No vessel here goes faster: how far it can have got since it was heard, m/s. */
const FASTEST_MPS = 3;
/** A wheel that rests so long is turned anew, ms. */
const WHEEL_MS = 400;
/** A circle larger than this says nothing any more, m. */
const FARTHEST_M = 50_000;
/** What lies under buttons and words at the edges is not in view, px: above, right, below, left. */
const EDGES = [70, 70, 60, 70];
const EDGES_NARROW = [50, 66, 70, 62];
/** A map that is narrower has less room between the edges, px. */
const NARROW = 560;
/** The newest points of a track that are drawn apart from the rest, at most. */
const TAIL_POINTS = 200;
/** Tracks are kept as a picture, this much larger than the map, which is what is shown while the map is led. */
const TRACK_RATIO = 1.2;

interface Drawn {
  readonly vessel: Feature<Point>;
  readonly course: Feature<LineString>;
  /** What changes seldom of the track, and the newest of it. */
  readonly track: Feature<LineString>;
  readonly tail: Feature<LineString>;
  /** What a replay has yet to come to. */
  readonly coming: Feature<LineString>;
  /** Where it can be by now, when it is old. */
  readonly ring: Feature<Circle>;
  /** How it is drawn, and for what. */
  style: VesselStyle | undefined;
  look: string;
  at: string;
  /** The track that is drawn, how much of it as what changes seldom, and up to when. */
  points: readonly TrackPoint[];
  settled: number;
  until: number | undefined;
}

export interface FleetMap {
  readonly overlays: Overlays;
  readonly tools: MapTools;
  readonly clicks: Clicks;
  readonly chart: Pick<ChartOnMap, "onChart">;
  /** For what a page draws by itself. */
  readonly ol: OlMap;
  /** The colours in force. */
  palette(): Palette;
  /** `then` is called when the colours have changed. */
  onRepaint(then: () => void): void;
  update(systems: readonly System[], selected: number | undefined, nowUs: number): void;
  /** The track; with `untilUs` what comes after it is drawn as yet to come. */
  track(address: number, points: readonly TrackPoint[], untilUs?: number): void;
  /** Brings all systems into view. */
  showAll(): void;
  dispose(): void;
}

export interface MapNeeds {
  /** Called with the address of a vessel that is clicked. */
  readonly select?: (address: number) => void;
  /** Where it is one vessel's map. */
  readonly vessel?: number;
  /** Those with the first colours. */
  readonly first?: readonly number[];
  /** What brings all into view, where that is not vessels and their tracks. */
  readonly showAll?: () => void;
}

/** Draws into `root`. */
export function createMap(root: HTMLElement, { select, vessel, first = [], showAll: shows }: MapNeeds = {}): FleetMap {
  let palette = readPalette(first);
  const drawn = new Map<number, Drawn>();
  // Tracks are long and grow a little at a time: what is not their newest part is drawn anew seldom.
  const [moving, tails, tracks] = [new VectorSource(), new VectorSource(), new VectorSource()];
  let graticule = graticuleLayer(palette.ink, palette.halo, palette.grid);
  const wheel = wheelOn(root);
  const map = new OlMap({
    target: root,
    interactions: defaultInteractions({ mouseWheelZoom: false }).extend([new MouseWheelZoom({ condition: wheel.isOwn })]),
    layers: [
      graticule,
      new VectorImageLayer({ source: tracks, zIndex: over("track"), imageRatio: TRACK_RATIO }),
      new VectorLayer({ source: tails, zIndex: over("tail"), updateWhileAnimating: true, updateWhileInteracting: true }),
      new VectorLayer({ source: moving, zIndex: over("vessel"), updateWhileAnimating: true, updateWhileInteracting: true }),
    ],
    controls: defaultControls({ attribution: false, rotateOptions: { tipLabel: "North up", autoHide: false, label: northArrow() } }).extend([
      new ScaleLine({ units: "metric", minWidth: 50 }),
      new ScaleLine({ units: "nautical", minWidth: 50, className: "ol-scale-nm" }),
      new MousePosition({
        projection: "EPSG:4326",
        placeholder: "WGS 84",
        coordinateFormat: ([lon, lat] = [0, 0]) => position({ lat_deg: lat ?? 0, lon_deg: lon ?? 0 }),
      }),
    ]),
    view: new View({ center: NOWHERE, zoom: 12, maxZoom: 22, minZoom: 2 }),
  });
  const box = root.parentElement ?? root;
  const [tools, clicks] = [createTools(box), createClicks(map)];
  if (select) {
    clicks.claim("vessel", ({ pixel }) => {
      const hit = map.forEachFeatureAtPixel(pixel, (feature) => feature.get("address") as number | undefined, { hitTolerance: 8 });
      if (hit !== undefined) select(hit);
      return hit !== undefined;
    });
  }
  const overlays = createOverlays(map, clicks, () => palette);
  const chart = createChart(map, box, { tools, clicks }, (place) => overlays.cursor(place), vessel);
  chart.onChart(({ bounds }) => {
    // Nobody has led the map anywhere yet: the chart is a better place than none.
    if (!bounds || String(map.getView().getCenter()) !== String(NOWHERE)) return;
    const corners = [[bounds.west_deg, bounds.south_deg], [bounds.east_deg, bounds.north_deg]].map((corner) => fromLonLat(corner));
    map.getView().fit(boundingExtent(corners), { padding: [20, 20, 20, 20], duration: 0 });
  });
  const repainted: (() => void)[] = [];
  tools.button("all", "Show all").addEventListener("click", () => (shows ?? showAll)());
  // Where no vessel is chosen there is none to go with.
  const around = select || vessel !== undefined ? [createFollow(map, tools), createRings(map, tools, () => palette)] as const : undefined;
  const [follow, rings] = around ?? [];
  let last: { systems: readonly System[]; selected: number | undefined; nowUs: number } = { systems: [], selected: undefined, nowUs: 0 };
  let seen = false;
  const projected = new WeakMap<readonly TrackPoint[], number[][]>();

  const features = (address: number): Drawn => {
    const known = drawn.get(address);
    if (known) return known;
    const made: Drawn = {
      track: new Feature(new LineString([])),
      tail: new Feature(new LineString([])),
      coming: new Feature(new LineString([])),
      course: new Feature(new LineString([])),
      ring: new Feature(new Circle([0, 0], 0)),
      vessel: new Feature(new Point([])),
      style: undefined,
      look: "",
      at: "",
      points: [],
      settled: 0,
      until: undefined,
    };
    for (const feature of [made.track, made.tail, made.coming, made.course, made.ring, made.vessel]) feature.set("address", address, true);
    colour(address, made);
    tracks.addFeatures([made.coming, made.track]);
    tails.addFeatures([made.ring, made.tail]);
    moving.addFeatures([made.course, made.vessel]);
    drawn.set(address, made);
    return made;
  };
  /** Gives lines the colours in force. */
  const colour = (address: number, { track, tail, coming, course }: Drawn): void => {
    for (const line of [track, tail]) line.setStyle(trackStyle(address, palette));
    coming.setStyle(aheadStyle(address, palette));
    course.setStyle(courseStyle(address, palette));
  };

  const update = (systems: readonly System[], selected: number | undefined, nowUs: number): void => {
    last = { systems, selected, nowUs };
    setAttribute(root, "data-old", systems.filter(({ fix, liveness }) => fix && (liveness === "stale" || liveness === "lost")).map(({ address }) => address).join(" ") || null);
    for (const system of systems) if (system.fix) place(features(system.address), system, system.fix, system.address === selected, nowUs);
    const chosen = systems.find(({ address }) => address === selected)?.fix ?? undefined;
    follow?.update(chosen);
    rings?.update(chosen);
    if (!seen && systems.some((system) => system.fix)) {
      seen = true;
      showAll();
    }
  };

  // The person's own place is compared with the vessel that the page is about, or that is chosen.
  const compared = (): { name: string; lat_deg: number; lon_deg: number } | undefined => {
    const system = last.systems.find(({ address }) => address === last.selected);
    return system?.fix ? { name: systemName(system), lat_deg: system.fix.lat_deg, lon_deg: system.fix.lon_deg } : undefined;
  };
  createOwnPlace({ ol: map, tools, palette: () => palette, onRepaint: (then) => void repainted.push(then) }, compared);

  /** Draws a vessel where it is; what has not changed is left alone, so that the map rests while nothing moves. */
  const place = (one: Drawn, system: System, fix: Fix, selected: boolean, nowUs: number): void => {
    const old = system.liveness === "stale" || system.liveness === "lost";
    const radius = old ? Math.max(0, (nowUs - Math.min(system.heard_us, fix.time_us)) / 1e6) * FASTEST_MPS : 0;
    const ring = radius > 0 && radius < FARTHEST_M ? Math.ceil(radius) : 0;
    const look = [system.liveness, systemName(system), selected, fix.heading_rad === null, ring > 0].join("/");
    const at = [look, fix.lat_deg, fix.lon_deg, fix.heading_rad, fix.course_rad, fix.speed_mps, ring].join("/");
    if (one.style && at === one.at) return;
    if (!one.style || look !== one.look) {
      one.style = vesselStyle(system, palette, selected);
      one.vessel.setStyle(one.style.styles);
      one.ring.setStyle(ring > 0 ? ringStyle(system.address, palette) : []);
    }
    one.look = look;
    one.at = at;
    one.style.turn(fix.heading_rad ?? 0);
    const centre = fromLonLat([fix.lon_deg, fix.lat_deg]);
    one.vessel.getGeometry()?.setCoordinates(centre);
    one.course.getGeometry()?.setCoordinates(system.liveness === "live" ? ahead(fix) : []);
    // A metre on the ground is more on this projection, the farther from the equator.
    one.ring.getGeometry()?.setCenterAndRadius(centre, ring / Math.cos((fix.lat_deg * Math.PI) / 180));
  };

  const showAll = (): void => {
    const places = last.systems.flatMap((system) => (system.fix ? [fromLonLat([system.fix.lon_deg, system.fix.lat_deg])] : []));
    for (const { track, tail, coming } of drawn.values()) for (const part of [track, tail, coming]) places.push(...(part.getGeometry()?.getCoordinates() ?? []));
    if (places.length) map.getView().fit(boundingExtent(places), { padding: root.clientWidth < NARROW ? EDGES_NARROW : EDGES, maxZoom: 16, duration: 0 });
  };

  const repaint = (): void => {
    palette = readPalette(first);
    map.removeLayer(graticule);
    graticule = graticuleLayer(palette.ink, palette.halo, palette.grid);
    map.getLayers().insertAt(0, graticule);
    for (const [address, one] of drawn) {
      colour(address, one);
      one.style = undefined;
    }
    update(last.systems, last.selected, last.nowUs);
    overlays.repaint();
    rings?.repaint();
    chart.repaint();
    for (const then of repainted) then();
  };
  const dark = matchMedia("(prefers-color-scheme: dark)");
  dark.addEventListener("change", repaint);
  const chosen = new MutationObserver(repaint);
  chosen.observe(document.documentElement, { attributeFilter: ["data-palette"] });

  return {
    overlays,
    tools,
    clicks,
    chart,
    ol: map,
    palette: () => palette,
    onRepaint: (then) => void repainted.push(then),
    update,
    track(address, points, untilUs) {
      const one = features(address);
      const on = (point: TrackPoint): number[] => fromLonLat([point.lon_deg, point.lat_deg]);
      const grew = points.length - one.settled;
      if (untilUs === undefined && one.until === undefined && points === one.points && grew >= 0 && grew < TAIL_POINTS) {
        one.tail.getGeometry()?.setCoordinates(grew ? points.slice(Math.max(0, one.settled - 1)).map(on) : []);
        return;
      }
      if (untilUs !== undefined && untilUs === one.until && points === one.points && points.length === one.settled) return;
      Object.assign(one, { points, settled: points.length, until: untilUs });
      one.tail.getGeometry()?.setCoordinates([]);
      // A replay asks for the same points in each picture.
      const known = untilUs === undefined ? undefined : projected.get(points);
      const all = known?.length === points.length ? known : points.map(on);
      if (untilUs !== undefined) projected.set(points, all);
      const here = untilUs === undefined ? undefined : placeAt(points, untilUs);
      const split = untilUs === undefined ? points.length : pointsUntil(points, untilUs);
      const middle = here ? [on(here)] : [];
      one.track.getGeometry()?.setCoordinates([...all.slice(0, split), ...(split && untilUs !== undefined ? middle : [])]);
      one.coming.getGeometry()?.setCoordinates(split < points.length ? [...middle, ...all.slice(split)] : []);
    },
    showAll,
    dispose() {
      chart.dispose();
      wheel.dispose();
      dark.removeEventListener("change", repaint);
      chosen.disconnect();
      map.setTarget(undefined);
    },
  };
}

/**
 * Tells a wheel that is turned over the map, which zooms it, from one that began beside it and scrolls the page: that one goes
 * on scrolling when the map comes under the pointer.
 */
function wheelOn(root: HTMLElement): { isOwn(): boolean; dispose(): void } {
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

function graticuleLayer(ink: string, halo: string, grid: string): Graticule {
  const text = new Text({ font: `12px ${CANVAS_FONT}`, fill: new Fill({ color: ink }), stroke: new Stroke({ color: halo, width: 3 }) });
  const along = text.clone();
  text.setTextBaseline("bottom");
  along.setTextAlign("end");
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

/** The line from a fix to where the course leads in [`AHEAD_S`]. On a sphere, which is near enough for a minute. */
function ahead(fix: Fix): number[][] {
  const { course_rad: course, speed_mps: speed } = fix;
  if (course === null || speed === null || speed < 0.05) return [];
  const far = ((speed * AHEAD_S) / EARTH_M) * (180 / Math.PI);
  const lat = fix.lat_deg + far * Math.cos(course);
  const lon = fix.lon_deg + (far * Math.sin(course)) / Math.cos((fix.lat_deg * Math.PI) / 180);
  return [fromLonLat([fix.lon_deg, fix.lat_deg]), fromLonLat([lon, lat])];
}
