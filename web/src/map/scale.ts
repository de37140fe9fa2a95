// Round distances: pure.

/** The least of 1, 2 or 5 times a power of ten that is not under `least_m`, m. */
export function ringStep_m(least_m: number): number {
  const power = 10 ** Math.floor(Math.log10(Math.max(1, least_m)));
  return power * ([1, 2, 5, 10].find((times) => times * power >= least_m) ?? 10);
}
