// The map's colours, from the style sheet, so that one palette rules page and map.

export interface Palette {
  readonly ink: string;
  readonly halo: string;
  readonly grid: string;
  readonly danger: string;
  readonly series: readonly string[];
}

/** Reads the colours in force. */
export function readPalette(): Palette {
  const style = getComputedStyle(document.documentElement);
  const colour = (name: string): string => style.getPropertyValue(name).trim();
  return {
    ink: colour("--ink"),
    halo: colour("--map-halo"),
    grid: colour("--map-grid"),
    danger: colour("--bad"),
    series: [1, 2, 3, 4].map((number) => colour(`--series-${number}`)),
  };
}

/** A colour that stays with a system. */
export function seriesColour(palette: Palette, address: number): string {
  return palette.series[address % palette.series.length] ?? palette.ink;
}
