// A vessel as it was: what the history tells of a time, in the shapes in which the page shows the present. Pure.

import type { At, Entity, Fix, System, TrackPoint, Update } from "../api/types.gen";
import { seriesKey } from "../state/fleet";
import type { Labels, Values } from "../state/vitals";
import type { Playback } from "./clock";

/** A position older than this is shown as an old one, s. */
const FRESH_S = 10;
const MOVING_MPS = 0.05;
/** For so long of the watcher's time the next answer of the history may be under way while a replay plays, µs. */
const UNDER_WAY_US = 2_000_000;

/** The time to which ages count at `us`, µs, where the history has answered for `answeredUs`. A replay plays on while the next answer
 * comes, at 20 times the speed by many seconds: that makes no value old. An answer that stays out does. */
export function agesCountTo(us: number, answeredUs: number, play: Playback | null): number {
  if (play?.playing && us - answeredUs <= UNDER_WAY_US * play.speed) return answeredUs;
  return Math.max(us, answeredUs);
}

/** Values whose age is that at the time itself, not since they came ashore. */
export function valuesThen(at: At): Values {
  return new Map(at.values.map((update) => [seriesKey(update), { ...update, received_us: update.time_us }]));
}

/** What the entities were called then: the last label that was known, else the first. */
export function labelsThen(entities: readonly Entity[], us: number): Labels {
  const found = new Map<number, string>();
  const sorted = [...entities].sort((one, other) => one.from_us - other.from_us);
  for (const one of sorted) if (one.from_us <= us || !found.has(one.entity)) found.set(one.entity, one.label);
  return found;
}

/** What it called itself then; null where that is not recorded. */
export function nameThen(values: Values): string | null {
  const announce = [...values.values()].find((update) => update.abbrev === "Announce");
  const name = announce?.fields.find((field) => field.name === "sys_name")?.value;
  return typeof name === "string" && name ? name : null;
}

/** The vessel on the map at `us`: its place by the track, its heading and course by what it said last before `asOf`. */
export function systemThen(address: number, name: string | null, values: Values, place: TrackPoint | undefined, us: number, asOf = us): System {
  const state = [...values.values()].filter((update) => update.abbrev === "EstimatedState").reduce<Update | undefined>((last, one) => (!last || one.time_us > last.time_us ? one : last), undefined);
  const fix = state ? fixOf(state) : undefined;
  const where = place ?? (fix && { time_us: fix.time_us, lat_deg: fix.lat_deg, lon_deg: fix.lon_deg });
  const heard = place ? asOf : (fix?.time_us ?? asOf);
  const fresh = fix && asOf - fix.time_us < FRESH_S * 1e6;
  return {
    address,
    name,
    kind: null,
    liveness: asOf - heard < FRESH_S * 1e6 ? "live" : "stale",
    heard_us: heard,
    transports: [],
    fix: where
      ? { ...where, heading_rad: fresh ? fix.heading_rad : null, course_rad: fresh ? fix.course_rad : null, speed_mps: fresh ? fix.speed_mps : null }
      : null,
    entities: {},
  };
}

function fixOf(state: Update): Fix | undefined {
  const read = (name: string): number | null => {
    const value = state.fields.find((field) => field.name === name)?.value;
    return typeof value === "number" ? value : null;
  };
  const [lat, lon, north, east] = [read("true_lat_deg"), read("true_lon_deg"), read("vx"), read("vy")];
  if (lat === null || lon === null) return undefined;
  const speed = north === null || east === null ? null : Math.hypot(north, east);
  const course = north === null || east === null || speed === null || speed < MOVING_MPS ? null : Math.atan2(east, north);
  return { time_us: state.time_us, lat_deg: lat, lon_deg: lon, heading_rad: read("psi"), course_rad: course, speed_mps: speed };
}
