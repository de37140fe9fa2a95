// Contrast of two colours as WCAG 2.2 has it: pure.

/** Red, green and blue, 0..255. */
export type Rgb = readonly [number, number, number];

/** A colour as `#rrggbb`; undefined for anything else. */
export function hexRgb(text: string): Rgb | undefined {
  const [, red, green, blue] = /^#([0-9a-f]{2})([0-9a-f]{2})([0-9a-f]{2})$/i.exec(text.trim()) ?? [];
  if (red === undefined || green === undefined || blue === undefined) return undefined;
  return [parseInt(red, 16), parseInt(green, 16), parseInt(blue, 16)];
}

/** From 1 (the same) to 21 (black on white). */
export function contrast(one: Rgb, other: Rgb): number {
  const [light, dark] = [luminance(one), luminance(other)].toSorted((a, b) => b - a) as [number, number];
  return (light + 0.05) / (dark + 0.05);
}

/** Relative luminance, 0..1 (WCAG 2.2, definitions). */
function luminance(rgb: Rgb): number {
  const linear = rgb.map((eight) => {
    const part = eight / 255;
    return part <= 0.04045 ? part / 12.92 : ((part + 0.055) / 1.055) ** 2.4;
  }) as [number, number, number];
  return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2];
}

/** What the palettes promise: this ink on that ground, and how many times as light one is as the other, at least; in the sun more. */
export const PAIRS: readonly (readonly [ink: string, ground: string, least: number, leastInSun: number])[] = [
  ...["ink", "dim", "accent", "good", "warn", "bad"].flatMap((ink) => ["panel", "ground"].map((ground) => [ink, ground, 4.5, 7] as const)),
  ["ink", "chosen", 4.5, 7],
  ["accent", "chosen", 4.5, 7],
  ["good", "good-ground", 4.5, 7],
  ["warn", "warn-ground", 4.5, 7],
  ["bad", "bad-ground", 4.5, 7],
  ["ink", "good-ground", 4.5, 7],
  ["ink", "warn-ground", 4.5, 7],
  ["ink", "bad-ground", 4.5, 7],
  ["on-accent", "accent", 4.5, 7],
  ["on-stop", "stop", 4.5, 7],
  ...["emergency", "alarm", "warning", "caution"].map((name) => [`on-${name}`, name, 4.5, 7] as const),
  ["edge", "panel", 3, 4.5],
  ["edge", "ground", 3, 4.5],
  ...[1, 2, 3, 4].map((number) => [`series-${number}`, "panel", 3, 4.5] as const),
];
