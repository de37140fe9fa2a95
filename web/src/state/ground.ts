// Metres on the ground around a place, as the server and the vessels count them: a flat frame by the two radii of curvature of
// WGS 84. Pure.

import type { PlanPlace } from "../api/types.gen";

const AXIS_M = 6_378_137;
const ECCENTRICITY_SQUARED = 0.006_694_379_990_14;
const RAD = Math.PI / 180;

/** Metres to the north and to the east. */
export type Metres = readonly [number, number];

export interface Ground {
  metres(place: PlanPlace): Metres;
  place(point: Metres): PlanPlace;
}

export function groundAt(origin: PlanPlace): Ground {
  const sin = Math.sin(origin.lat_deg * RAD);
  const w2 = 1 - ECCENTRICITY_SQUARED * sin * sin;
  const across = AXIS_M / Math.sqrt(w2);
  const north = ((across * (1 - ECCENTRICITY_SQUARED)) / w2) * RAD;
  const east = Math.max(1e-3, across * Math.cos(origin.lat_deg * RAD)) * RAD;
  return {
    metres: ({ lat_deg, lon_deg }) => [(lat_deg - origin.lat_deg) * north, wrapped(lon_deg - origin.lon_deg) * east],
    place: ([n, e]) => ({ lat_deg: origin.lat_deg + n / north, lon_deg: wrapped(origin.lon_deg + e / east) }),
  };
}

/** So many metres along a bearing and to the right of it, as metres to the north and to the east. */
export function turned(along: number, right: number, bearing_deg: number): Metres {
  const [sin, cos] = [Math.sin(bearing_deg * RAD), Math.cos(bearing_deg * RAD)];
  return [along * cos - right * sin, along * sin + right * cos];
}

/** Metres to the north and to the east, as metres along a bearing and to the right of it. */
export function turnedBack([north, east]: Metres, bearing_deg: number): Metres {
  return turned(north, east, -bearing_deg);
}

/** The direction to a point, ° from north, 0 to 360. */
export function bearingTo([north, east]: Metres): number {
  return within360(Math.atan2(east, north) / RAD);
}

/** A bearing from 0 to 360, without the noise of the last digits. */
export function within360(bearing_deg: number): number {
  return (Math.round((((bearing_deg % 360) + 360) % 360) * 1e6) / 1e6) % 360;
}

function wrapped(lon_deg: number): number {
  return ((((lon_deg + 180) % 360) + 360) % 360) - 180;
}
