// Vessels on the map: where each is and heads, the way it came, and where it can be by now when it is not heard.

import type OlMap from "ol/Map";
import Feature from "ol/Feature";
import { Circle, LineString, Point } from "ol/geom";
import VectorLayer from "ol/layer/Vector";
import VectorImageLayer from "ol/layer/VectorImage";
import { fromLonLat } from "ol/proj";
import VectorSource from "ol/source/Vector";
import type { Fix, System, TrackPoint } from "../api/types.gen";
import { placeAt, pointsUntil } from "../state/track";
import { systemName } from "../ui/format";
import { over } from "./layers";
import type { Palette } from "./palette";
import { aheadStyle, courseStyle, NAMES, ringStyle, trackStyle, type VesselStyle, vesselStyle } from "./symbols";

/** The course vector shows so many seconds ahead. */
const AHEAD_S = 60;
const EARTH_M = 6_371_000;
/** No vessel here goes faster: how far it can have got since it was heard, m/s. */
const FASTEST_MPS = 3;
/** A circle larger than this says nothing any more, m. */
const FARTHEST_M = 50_000;
/** The newest points of a track that are drawn apart from the rest, at most. */
const TAIL_POINTS = 200;
/** Tracks are kept as a picture, this much larger than the map, which is what is shown while the map is led. */
const TRACK_RATIO = 1.2;
/** What moves by less is not drawn again: a map with a chart takes as much work as all else on a page. The course vector's end
 * trembles with the speed over ground; it shows no more than about where a minute leads. */
const SEEN_PX = 1;
const AHEAD_SEEN_PX = 6;
const TURN_SEEN_RAD = 0.03;

interface Drawn {
  readonly vessel: Feature<Point>;
  readonly course: Feature<LineString>;
  /** What changes seldom of the track, and the newest of it. */
  readonly track: Feature<LineString>;
  readonly tail: Feature<LineString>;
  /** What a replay has yet to come to. */
  readonly coming: Feature<LineString>;
  /** Where it can be by now, when it is old, and how far that is as drawn, m. */
  readonly ring: Feature<Circle>;
  ring_m: number;
  /** How it is drawn, and for what. */
  style: VesselStyle | undefined;
  look: string;
  /** How it lies and where its course leads, as it is drawn. */
  heading_rad: number;
  ahead: readonly number[] | undefined;
  /** The track that is drawn, how much of it as what changes seldom, and up to when. */
  points: readonly TrackPoint[];
  settled: number;
  until: number | undefined;
}

export class VesselsOnMap {
  private readonly drawn = new Map<number, Drawn>();
  // Tracks are long and grow a little at a time: what is not their newest part is redrawn seldom.
  private readonly moving = new VectorSource();
  private readonly tails = new VectorSource();
  private readonly tracks = new VectorSource();
  private readonly projected = new WeakMap<readonly TrackPoint[], number[][]>();

  constructor(private readonly map: OlMap, private readonly palette: () => Palette) {
    map.addLayer(new VectorImageLayer({ source: this.tracks, zIndex: over("track"), imageRatio: TRACK_RATIO }));
    map.addLayer(new VectorLayer({ source: this.tails, zIndex: over("tail"), updateWhileAnimating: true, updateWhileInteracting: true }));
    map.addLayer(new VectorLayer({ source: this.moving, zIndex: over("vessel"), declutter: NAMES, updateWhileAnimating: true, updateWhileInteracting: true }));
  }

  update(systems: readonly System[], selected: number | undefined, nowUs: number): void {
    for (const system of systems) if (system.fix) this.place(this.of(system.address), system, system.fix, system.address === selected, nowUs);
  }

  /** The track; with `untilUs` what comes after it is drawn as yet to come. */
  track(address: number, points: readonly TrackPoint[], untilUs?: number): void {
    const one = this.of(address);
    const grew = points.length - one.settled;
    if (untilUs === undefined && one.until === undefined && points === one.points && grew >= 0 && grew < TAIL_POINTS) {
      const tail = grew ? points.slice(Math.max(0, one.settled - 1)).map(on) : [];
      if (!this.near(one.tail.getGeometry()?.getLastCoordinate(), tail.at(-1), SEEN_PX)) one.tail.getGeometry()?.setCoordinates(tail);
      return;
    }
    if (untilUs !== undefined && untilUs === one.until && points === one.points && points.length === one.settled) return;
    Object.assign(one, { points, settled: points.length, until: untilUs });
    one.tail.getGeometry()?.setCoordinates([]);
    const all = this.coordinates(points, untilUs !== undefined);
    const here = untilUs === undefined ? undefined : placeAt(points, untilUs);
    const split = untilUs === undefined ? points.length : pointsUntil(points, untilUs);
    const middle = here ? [on(here)] : [];
    one.track.getGeometry()?.setCoordinates([...all.slice(0, split), ...(split && untilUs !== undefined ? middle : [])]);
    one.coming.getGeometry()?.setCoordinates(split < points.length ? [...middle, ...all.slice(split)] : []);
  }

  /** All that is drawn of tracks, in the map's coordinates. */
  trackCoordinates(): number[][] {
    return [...this.drawn.values()].flatMap(({ track, tail, coming }) => [track, tail, coming].flatMap((part) => part.getGeometry()?.getCoordinates() ?? []));
  }

  /** Gives all the colours in force; vessels have them with the next update. */
  repaint(): void {
    for (const [address, one] of this.drawn) {
      this.colour(address, one);
      one.style = undefined;
    }
  }

  /** A replay asks for the same points in each picture: they are kept. */
  private coordinates(points: readonly TrackPoint[], replayed: boolean): number[][] {
    const known = replayed ? this.projected.get(points) : undefined;
    const all = known?.length === points.length ? known : points.map(on);
    if (replayed) this.projected.set(points, all);
    return all;
  }

  private of(address: number): Drawn {
    const known = this.drawn.get(address);
    if (known) return known;
    const line = (): Feature<LineString> => new Feature(new LineString([]));
    const made: Drawn = { track: line(), tail: line(), coming: line(), course: line(), ring: new Feature(new Circle([0, 0], 0)), ring_m: 0, vessel: new Feature(new Point([])), style: undefined, look: "", heading_rad: 0, ahead: undefined, points: [], settled: 0, until: undefined };
    for (const feature of [made.track, made.tail, made.coming, made.course, made.ring, made.vessel]) feature.set("address", address, true);
    this.colour(address, made);
    this.tracks.addFeatures([made.coming, made.track]);
    this.tails.addFeatures([made.ring, made.tail]);
    this.moving.addFeatures([made.course, made.vessel]);
    this.drawn.set(address, made);
    return made;
  }

  /** Gives lines the colours in force. */
  private colour(address: number, { track, tail, coming, course }: Drawn): void {
    const palette = this.palette();
    for (const line of [track, tail]) line.setStyle(trackStyle(address, palette));
    coming.setStyle(aheadStyle(address, palette));
    course.setStyle(courseStyle(address, palette));
  }

  /** Whether nobody can see that something that was drawn at one place is at another. */
  private near([x, y]: readonly number[] = [], [toX, toY]: readonly number[] = [], within_px: number): boolean {
    if (x === undefined || y === undefined || toX === undefined || toY === undefined) return x === toX && y === toY;
    return Math.hypot(toX - x, toY - y) < within_px * (this.map.getView().getResolution() ?? 0);
  }

  /** Draws a vessel where it is; what has not changed is left alone, so that the map rests while nothing moves. */
  private place(one: Drawn, system: System, fix: Fix, selected: boolean, nowUs: number): void {
    const old = system.liveness === "stale" || system.liveness === "lost";
    const radius = old ? Math.max(0, (nowUs - Math.min(system.heard_us, fix.time_us)) / 1e6) * FASTEST_MPS : 0;
    const ring = radius > 0 && radius < FARTHEST_M ? Math.ceil(radius) : 0;
    const look = [system.liveness, systemName(system), selected, fix.heading_rad === null, ring > 0].join("/");
    const centre = on(fix);
    const course = system.liveness === "live" ? ahead(fix) : [];
    const heading_rad = fix.heading_rad ?? 0;
    const turned = Math.abs(heading_rad - one.heading_rad) >= TURN_SEEN_RAD;
    const moved = !this.near(one.vessel.getGeometry()?.getCoordinates(), centre, SEEN_PX) || !this.near(one.ahead, course.at(-1), AHEAD_SEEN_PX);
    if (one.style && look === one.look && ring === one.ring_m && !turned && !moved) return;
    if (!one.style || look !== one.look) {
      const palette = this.palette();
      one.style = vesselStyle(system, palette, selected);
      one.vessel.setStyle(one.style.styles);
      one.ring.setStyle(ring > 0 ? ringStyle(system.address, palette) : []);
    }
    one.look = look;
    Object.assign(one, { heading_rad, ahead: course.at(-1), ring_m: ring });
    one.style.turn(heading_rad);
    one.vessel.getGeometry()?.setCoordinates(centre);
    one.course.getGeometry()?.setCoordinates(course);
    // A metre on the ground is more on this projection, the farther from the equator.
    one.ring.getGeometry()?.setCenterAndRadius(centre, ring / Math.cos((fix.lat_deg * Math.PI) / 180));
  }
}

function on({ lat_deg, lon_deg }: Pick<Fix, "lat_deg" | "lon_deg">): number[] {
  return fromLonLat([lon_deg, lat_deg]);
}

/** The line from a fix to where the course leads in [`AHEAD_S`]. On a sphere, which is near enough for a minute. */
function ahead(fix: Fix): number[][] {
  const { course_rad: course, speed_mps: speed } = fix;
  if (course === null || speed === null || speed < 0.05) return [];
  const far = ((speed * AHEAD_S) / EARTH_M) * (180 / Math.PI);
  const lat = fix.lat_deg + far * Math.cos(course);
  const lon = fix.lon_deg + (far * Math.sin(course)) / Math.cos((fix.lat_deg * Math.PI) / 180);
  return [on(fix), fromLonLat([lon, lat])];
}
