// Round distances and angles: pure.

/** The least of 1, 2 or 5 times a power of ten that is not under `least_m`, m. */
export function ringStep_m(least_m: number): number {
  const power = 10 ** Math.floor(Math.log10(Math.max(1, least_m)));
  return power * ([1, 2, 5, 10].find((times) => times * power >= least_m) ?? 10);
}

/** Round angles from ten degrees to a hundredth of a minute, degrees. */
const ANGLES_DEG = [10, 5, 2, 1, 30 / 60, 20 / 60, 10 / 60, 5 / 60, 2 / 60, 1 / 60, 30 / 3600, 12 / 3600, 6 / 3600, 3 / 3600, 1.2 / 3600, 0.6 / 3600];
const EQUATOR_M_PER_DEG = 111_319.49;

/** The least round angle that is `least_px` wide on the map, degrees, at a resolution, metres of the projection a pixel; undefined
 * where none is. Away from the equator it is higher than wide. */
export function graticuleStep_deg(resolution: number, least_px: number): number | undefined {
  return ANGLES_DEG.findLast((angle) => (angle * EQUATOR_M_PER_DEG) / resolution >= least_px);
}
