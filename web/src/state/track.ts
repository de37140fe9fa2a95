// Where a vessel has been: recorded points first, live ones after them.

import type { Fix, TrackPoint } from "../api/types.gen";

/** Points kept of a vessel; the oldest half is thinned out when there are more. */
const POINTS = 20_000;
/** Points closer together than this are one, degrees (about 0.3 m). */
const NEAR_DEG = 3e-6;

export class Track {
  private points: TrackPoint[] = [];

  /** Puts what was recorded before what was seen live. */
  recorded(points: readonly TrackPoint[]): void {
    const last = points.at(-1)?.time_us ?? -Infinity;
    this.points = [...points, ...this.points.filter((point) => point.time_us > last)];
  }

  /** Adds a live position; false when it says nothing new. */
  add(fix: Fix): boolean {
    const last = this.points.at(-1);
    if (last) {
      const near =
        Math.abs(fix.lat_deg - last.lat_deg) < NEAR_DEG && Math.abs(fix.lon_deg - last.lon_deg) < NEAR_DEG;
      if (near || fix.time_us <= last.time_us) return false;
    }
    this.points.push({ time_us: fix.time_us, lat_deg: fix.lat_deg, lon_deg: fix.lon_deg });
    if (this.points.length > POINTS) {
      const half = POINTS / 2;
      this.points = this.points.filter((_, index) => index >= half || index % 2 === 0);
    }
    return true;
  }

  all(): readonly TrackPoint[] {
    return this.points;
  }
}

/** Before a track and after it there is no place, but for this, µs. */
const APART_US = 5_000_000;

/** A time of which nothing was recorded, µs since 1970 UTC. */
export type Silence = { readonly from_us: number; readonly to_us: number };

/**
 * Where the vessel was at this time, between the points of its track; undefined where that is not known, as within one of
 * `silences`.
 */
export function placeAt(points: readonly TrackPoint[], us: number, silences: readonly Silence[] = []): TrackPoint | undefined {
  const low = pointsUntil(points, us);
  const [before, after] = [points[low - 1], points[low]];
  if (!before || !after) {
    const end = before ?? after;
    return end && Math.abs(end.time_us - us) < APART_US ? end : undefined;
  }
  // What was missed may have come since, with its places.
  const missed = ({ from_us, to_us }: Silence): boolean => us > from_us + APART_US && us < to_us - APART_US && before.time_us <= from_us + APART_US && after.time_us >= to_us - APART_US;
  if (silences.some(missed)) return undefined;
  // A simplified track has few points where the vessel went straight, so that what lies between two is known.
  const along = (us - before.time_us) / Math.max(1, after.time_us - before.time_us);
  return {
    time_us: us,
    lat_deg: before.lat_deg + along * (after.lat_deg - before.lat_deg),
    lon_deg: before.lon_deg + along * (after.lon_deg - before.lon_deg),
  };
}

/** How many points of a track are not after this time. */
export function pointsUntil(points: readonly TrackPoint[], us: number): number {
  let [low, high] = [0, points.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if ((points[middle]?.time_us ?? Infinity) <= us) low = middle + 1;
    else high = middle;
  }
  return low;
}
