// One plot: lines of one unit over the shared stretch of time, with the cursor that all plots and the map share.

import uPlot from "uplot";
import type { Gap } from "../api/types.gen";
import { CANVAS_FONT, readPalette } from "../map/palette";
import { make, setAttribute, setText } from "../ui/dom";
import { age, utc } from "../ui/format";
import { t } from "../words/words";
import type { Table } from "./model";
import { thinned } from "./thin";

const HEIGHT_PX = 190;
/** Drags shorter than this are clicks, px. */
const CLICK_PX = 8;
/** A second click comes within this, ms. */
const DOUBLE_MS = 250;
/** The cursor tells of a point within this; farther from any it tells of none, px. */
const NEAR_PX = 24;
const DASHES: readonly (readonly number[])[] = [[], [8, 4], [2, 3], [10, 3, 2, 3]];

export interface ChartLine {
  readonly label: string;
  readonly table: Table;
  /** So long after the last of it the line is still fresh, s; undefined where the end of the time is not the present. */
  readonly freshS?: number | undefined;
}

/** How a line is drawn; lines that another brings along go with it. */
export interface LineLook {
  readonly label: string;
  /** Numbers of the colour and of the dashes. */
  readonly colour: number;
  readonly dashes: number;
  readonly removable: boolean;
}

export interface ChartHandlers {
  /** The pointer or the keys are at this time; null when they have left. */
  cursor(us: number | null): void;
  /** This time is chosen. */
  pick(us: number): void;
  zoom(fromUs: number, toUs: number): void;
  /** Parts of the length by which to move, and the factor by which to lengthen. */
  pan(part: number): void;
  scale(factor: number): void;
  remove(index: number): void;
}

export interface Chart {
  readonly root: HTMLElement;
  update(lines: readonly ChartLine[], fromUs: number, toUs: number, gaps: readonly Gap[]): void;
  cursor(us: number | null): void;
  dispose(): void;
}

/** A plot of lines in `unit`. `looks` are its lines; a change of them takes a new plot. */
export function createChart(title: string, unit: string, looks: readonly LineLook[], handlers: ChartHandlers, ...buttons: readonly HTMLElement[]): Chart {
  return new PlotChart(title, unit, looks, handlers, buttons);
}

/** How a line is drawn, in the colours in force. */
interface Pen {
  readonly stroke: string;
  readonly dash: readonly number[];
}

class PlotChart implements Chart {
  readonly root: HTMLElement;
  private readonly palette = readPalette();
  private readonly box: HTMLElement;
  private readonly summary = make("p", { class: "hidden" });
  /** Where the value of each line is told. */
  private readonly values: readonly HTMLElement[];
  private readonly plot: uPlot;
  private readonly resized: ResizeObserver;
  /** While the page moves the cursor, nobody is told of it. */
  private silent = false;
  private gaps: readonly Gap[] = [];
  private fresh: readonly (number | undefined)[] = [];
  private data: uPlot.AlignedData = [[]];

  constructor(title: string, private readonly unit: string, private readonly looks: readonly LineLook[], private readonly handlers: ChartHandlers, buttons: readonly HTMLElement[]) {
    const legend = make("ul", { class: "legend" });
    this.values = looks.map((look, index) => this.entry(legend, look, index));
    this.box = make("div", { class: "canvas", tabindex: "0", role: "application", "aria-label": t("{title}. Left and right move the cursor, with Shift by more, Enter goes there; plus and minus zoom, Page Up and Page Down move in time.", { title }) });
    this.root = make("section", { class: "plot", "aria-label": title }, make("div", { class: "plot-head" }, make("h3", {}, title), legend, ...buttons), this.box, this.summary);
    this.plot = new uPlot(this.options(), this.data, this.box);
    this.listen();
    this.resized = new ResizeObserver(() => this.box.clientWidth && this.plot.setSize({ width: this.box.clientWidth, height: HEIGHT_PX }));
    this.resized.observe(this.box);
  }

  update(given: readonly ChartLine[], fromUs: number, toUs: number, declared: readonly Gap[]): void {
    const { plot } = this;
    this.gaps = declared;
    this.fresh = given.map(({ freshS }) => freshS);
    const lines = given.map(({ label, table }) => ({ label, table: thinned(table, fromUs / 1e6, toUs / 1e6, plot.bbox.width) }));
    const tables = lines.map(({ table }) => table as uPlot.AlignedData);
    const joined = tables.length === 1 ? tables[0] : tables.length ? uPlot.join(tables) : undefined;
    this.data = joined ?? [[]];
    this.silent = true;
    plot.batch(() => {
      plot.setData(this.data, false);
      plot.setScale("x", { min: fromUs / 1e6, max: toUs / 1e6 });
    });
    this.moved(plot);
    this.silent = false;
    setText(this.summary, lines.map((line) => described(line, this.unit)).join(" "));
  }

  cursor(us: number | null): void {
    this.silent = true;
    this.plot.setCursor(us === null ? { left: -10, top: -10 } : { left: this.plot.valToPos(us / 1e6, "x"), top: HEIGHT_PX / 3 });
    this.silent = false;
  }

  dispose(): void {
    this.resized.disconnect();
    this.plot.destroy();
    this.root.remove();
  }

  private pen({ colour, dashes }: LineLook): Pen {
    const { series, ink } = this.palette;
    return { stroke: series[colour % series.length] ?? ink, dash: DASHES[dashes % DASHES.length] ?? [] };
  }

  /** Puts a line into the legend; answers where its value is told. */
  private entry(legend: HTMLElement, look: LineLook, index: number): HTMLElement {
    const { stroke, dash } = this.pen(look);
    const value = make("span", { class: "num" });
    const swatch = make("i", { class: "swatch" });
    swatch.style.borderTopColor = stroke;
    swatch.style.borderTopStyle = dash.length ? "dashed" : "solid";
    const item = make("li", {}, swatch, make("span", {}, look.label), value);
    if (look.removable) {
      const remove = make("button", { type: "button", class: "small", "aria-label": t("Remove {label}", { label: look.label }) }, "✕");
      remove.addEventListener("click", () => this.handlers.remove(index));
      item.append(remove);
    }
    legend.append(item);
    return value;
  }

  private options(): uPlot.Options {
    const { palette } = this;
    const axis: uPlot.Axis = { stroke: palette.ink, grid: { stroke: palette.grid, width: 1 }, ticks: { stroke: palette.grid, width: 1 }, font: `13px ${CANVAS_FONT}` };
    return {
      width: 600,
      height: HEIGHT_PX,
      legend: { show: false },
      tzDate: (seconds) => uPlot.tzDate(new Date(seconds * 1e3), "Etc/UTC"),
      scales: { x: { time: true, auto: false } },
      axes: [{ ...axis, values: times, space: 90 }, { ...axis, size: 64, values: (_, splits) => splits.map(figure) }],
      series: [{}, ...this.looks.flatMap((look) => this.series(look))],
      bands: this.looks.map((look, index) => ({ series: [3 * index + 1, 3 * index + 2], fill: faint(this.pen(look).stroke) })),
      cursor: { hover: { prox: NEAR_PX, skip: [undefined] }, drag: { x: true, y: false, setScale: false }, points: { size: 7 }, bind: { dblclick: () => null } },
      hooks: {
        setCursor: [(self) => this.moved(self)],
        setSelect: [(self) => this.selected(self)],
        drawClear: [(self) => shade(self, this.gaps, palette.grid, palette.ink)],
      },
    };
  }

  /** Of each line greatest, least and mean. */
  private series(look: LineLook): uPlot.Series[] {
    const { label } = look;
    const { stroke, dash } = this.pen(look);
    const band = { stroke: "transparent", points: { show: false } };
    return [
      { ...band, label: t("{label} greatest", { label }) },
      { ...band, label: t("{label} least", { label }) },
      { label, stroke, width: 1.75, dash: [...dash], points: { size: 4, fill: stroke } },
    ];
  }

  private selected(self: uPlot): void {
    const { left, width } = self.select;
    if (width < CLICK_PX) return;
    self.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
    this.handlers.zoom(self.posToVal(left, "x") * 1e6, self.posToVal(left + width, "x") * 1e6);
  }

  private moved(self: uPlot): void {
    const left = self.cursor.left ?? -1;
    this.looks.forEach((_, index) => this.tell(self, left, index));
    if (!this.silent) this.handlers.cursor(left < 0 ? null : self.posToVal(left, "x") * 1e6);
  }

  /** Tells a line's value under the cursor; without one, its last. */
  private tell(self: uPlot, left: number, index: number): void {
    const { data, unit } = this;
    const node = this.values[index];
    if (!node) return;
    const at = left < 0 ? lastKnown(data, 3 * index + 3) : (self.cursor.idxs?.[3 * index + 3] ?? null);
    const mean = value(data, 3 * index + 3, at);
    const [max, min] = [value(data, 3 * index + 1, at), value(data, 3 * index + 2, at)];
    const spread = max !== null && min !== null && max - min > 1e-9 ? ` (${t("{least} to {most}", { least: figure(min), most: figure(max) })})` : "";
    const limit = left < 0 ? this.fresh[index] : undefined;
    const ageS = (self.scales["x"]?.max ?? 0) - (data[0]?.[at ?? 0] ?? 0);
    const old = limit !== undefined && mean !== null && ageS > limit;
    setText(node, mean === null ? "—" : `${figure(mean)}${unit ? ` ${unit}` : ""}${old ? ` (${t("old: {age}", { age: age(ageS) })})` : spread}`);
    setAttribute(node, "data-old", old ? "" : null);
  }

  private listen(): void {
    const { box, plot, handlers } = this;
    box.addEventListener("keydown", (event) => this.key(event));
    let down = 0;
    let picking: number | undefined;
    plot.over.addEventListener("pointerdown", (event) => (down = event.clientX));
    plot.over.addEventListener("click", (event) => {
      const left = event.clientX - plot.over.getBoundingClientRect().left;
      window.clearTimeout(picking);
      // The first half of a double click does not count as a click.
      if (Math.abs(event.clientX - down) < CLICK_PX && event.detail < 2) picking = window.setTimeout(() => handlers.pick(plot.posToVal(left, "x") * 1e6), DOUBLE_MS);
    });
    box.addEventListener("dblclick", () => {
      window.clearTimeout(picking);
      handlers.scale(2);
    });
    box.addEventListener("wheel", (event) => this.wheel(event), { passive: false });
  }

  private key(event: KeyboardEvent): void {
    const { plot, handlers } = this;
    const wide = plot.over.clientWidth;
    const step = event.shiftKey ? wide / 10 : Math.max(1, wide / 200);
    const left = plot.cursor.left ?? -1;
    const from = left < 0 ? wide : left;
    const go = (to: number): void => plot.setCursor({ left: Math.max(0, Math.min(wide, to)), top: HEIGHT_PX / 2 });
    const acts: Record<string, () => void> = {
      ArrowLeft: () => go(from - step),
      ArrowRight: () => go(from + step),
      Enter: () => left >= 0 && handlers.pick(plot.posToVal(left, "x") * 1e6),
      Escape: () => plot.setCursor({ left: -10, top: -10 }),
      PageUp: () => handlers.pan(-0.5),
      PageDown: () => handlers.pan(0.5),
      "+": () => handlers.scale(0.5),
      "-": () => handlers.scale(2),
    };
    const act = acts[event.key];
    if (!act) return;
    event.preventDefault();
    act();
  }

  /** An ordinary wheel scrolls the page; sideways it moves in time, with Ctrl it zooms. */
  private wheel(event: WheelEvent): void {
    const { plot, handlers } = this;
    if (event.ctrlKey) handlers.scale(event.deltaY > 0 ? 1.25 : 0.8);
    else if (Math.abs(event.deltaX) > Math.abs(event.deltaY)) handlers.pan(event.deltaX / Math.max(300, plot.over.clientWidth));
    else return;
    event.preventDefault();
  }
}

/** Stretches from which something is missing, as the vessel declared. */
function shade(plot: uPlot, gaps: readonly Gap[], fill: string, ink: string): void {
  const { ctx, bbox } = plot;
  ctx.save();
  ctx.beginPath();
  ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
  ctx.clip();
  for (const gap of gaps) {
    const left = plot.valToPos(gap.from_us / 1e6, "x", true);
    const width = Math.max(2, plot.valToPos(gap.to_us / 1e6, "x", true) - left);
    if (left > bbox.left + bbox.width || left + width < bbox.left) continue;
    ctx.fillStyle = fill;
    ctx.fillRect(left, bbox.top, width, bbox.height);
    if (width < 70) continue;
    ctx.fillStyle = ink;
    ctx.font = `${12 * devicePixelRatio}px ${CANVAS_FONT}`;
    ctx.fillText(gap.kind.replaceAll("_", " "), Math.max(left, bbox.left) + 6, bbox.top + 16 * devicePixelRatio);
  }
  ctx.restore();
}

function times(_: uPlot, splits: number[], __: number, ___: number, increment: number): string[] {
  let day = "";
  return splits.map((seconds) => {
    const text = new Date(seconds * 1e3).toISOString();
    const clock = increment >= 60 ? text.slice(11, 16) : increment >= 1 ? text.slice(11, 19) : text.slice(14, 23);
    const date = text.slice(0, 10);
    const changed = date !== day;
    day = date;
    if (increment >= 86_400) return date;
    return changed ? `${clock}\n${date}` : clock;
  });
}

function value(data: uPlot.AlignedData, column: number, at: number | null): number | null {
  return at === null ? null : (data[column]?.[at] ?? null);
}

function lastKnown(data: uPlot.AlignedData, column: number): number | null {
  const values = data[column] ?? [];
  for (let at = values.length - 1; at >= 0; at--) if (typeof values[at] === "number") return at;
  return null;
}

function described({ label, table: [times, maxima, minima, means] }: ChartLine, unit: string): string {
  let [count, least, most, last] = [0, Infinity, -Infinity, 0];
  means.forEach((mean, at) => {
    if (mean === null) return;
    count += 1;
    least = Math.min(least, minima[at] ?? mean);
    most = Math.max(most, maxima[at] ?? mean);
    last = mean;
  });
  if (!count) return t("{label}: nothing in this time.", { label });
  return t("{label}: {count} points, least {least}, greatest {most}, last {last} {unit} at {at}.", { label, count, least: figure(least), most: figure(most), last: figure(last), unit, at: utc((times.at(-1) ?? 0) * 1e6) });
}

/** A number as plots show it: enough of it to tell neighbours apart. */
function figure(value: number): string {
  const size = Math.abs(value);
  const text = size !== 0 && (size < 1e-3 || size >= 1e7) ? value.toExponential(2) : String(Number(value.toFixed(size >= 1_000 ? 1 : size >= 1 ? 3 : 4)));
  return text.replace("-", "−");
}

function faint(colour: string): string {
  return /^#[0-9a-f]{6}$/i.test(colour) ? `${colour}40` : colour;
}
