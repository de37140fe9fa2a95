// The map's colours, from the style sheet, so that one palette rules page and map.

/** Of what is written on a canvas: the page's own font, as `--font` in tokens.css. */
export const CANVAS_FONT = '"Atkinson Hyperlegible Next", system-ui, sans-serif';

export interface Palette {
  readonly ink: string;
  readonly halo: string;
  readonly grid: string;
  readonly danger: string;
  readonly series: readonly string[];
  /** Systems that have the first colours, in this order; others have those of their addresses. */
  readonly first: readonly number[];
}

/** Colours that series have, after which dashes tell them apart. */
export const SERIES = 4;

/** Reads the colours in force: the browser reckons styles for it. */
export function readPalette(first: readonly number[] = []): Palette {
  const style = getComputedStyle(document.documentElement);
  const colour = (name: string): string => style.getPropertyValue(name).trim();
  return {
    ink: colour("--ink"),
    halo: colour("--map-halo"),
    grid: colour("--map-grid"),
    danger: colour("--bad"),
    series: Array.from({ length: SERIES }, (_, at) => colour(`--series-${at + 1}`)),
    first,
  };
}

/** A colour that stays with a system. */
export function seriesColour(palette: Palette, address: number): string {
  const place = palette.first.indexOf(address);
  return palette.series[(place < 0 ? address : place) % palette.series.length] ?? palette.ink;
}
