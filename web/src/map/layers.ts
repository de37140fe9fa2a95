// What lies over what on the map, from below. The chart, its symbols and the graticule are beneath all of it,
// in a map of their own (`ground.ts`).

const FROM_BELOW = ["nogo", "route", "track", "tail", "rings", "tags", "cursor", "own", "planLines", "planLegs", "planPlaces", "planMarks", "refused", "measure", "vessel"] as const;

export type Layer = (typeof FROM_BELOW)[number];

export const CHART = { base: -20, symbols: -10, graticule: -5 } as const;

/** The `zIndex` of a layer. */
export function over(layer: Layer): number {
  return 1 + FROM_BELOW.indexOf(layer);
}
