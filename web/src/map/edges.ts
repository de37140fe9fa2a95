// What lies under buttons and words at the edges of a map is not in view. Pure.

/** A map that is narrower has less room between the edges, px. */
const NARROW = 560;
/** How far the tools reach in from the right, and half a vessel's name, px. */
export const TOOLS_PX = 53;
export const HALF_NAME_PX = 36;

/** Room that is kept free of what is brought into view, px: above, right, below, left. Names stand below their vessels. */
export function edges(width_px: number): number[] {
  const right = TOOLS_PX + HALF_NAME_PX;
  return width_px < NARROW ? [50, right, 92, 62] : [70, right, 80, 70];
}
