// The plots of a vessel: fields of one message and unit share a plot; history from the server, the present live.

import { getJson, reason } from "../api/http";
import type { Buckets, Gap, Series, Update } from "../api/types.gen";
import { SERIES } from "../map/palette";
import { freshForS } from "../state/fleet";
import { quantity } from "../state/quantities";
import { make, setAttribute, setText } from "../ui/dom";
import { type Chart, createChart, type LineLook } from "./chart";
import { createChooser } from "./chooser";
import { drawExports } from "./exportlinks";
import { Fields } from "./fields";
import { type Companion, ends, isLive, likewise, Line, parsed, type Range, shownUnit, type Source, written } from "./model";
import { t } from "../words/words";

/** Most lines at once. */
const LINES = 16;
/** While the present is followed, the history is asked again so often, ms. */
const AGAIN_MS = 15_000;
/** A question waits so long for the next change of the time, ms. */
const SETTLE_MS = 150;
/** A line is broken where nothing was said for so many usual intervals. */
const GAP_PERIODS = 5;

export interface PlotHandlers {
  cursor(us: number | null): void;
  pick(us: number): void;
  zoom(fromUs: number, toUs: number): void;
  pan(part: number): void;
  scale(factor: number): void;
  /** Lines were added or removed. */
  changed(sources: readonly Source[]): void;
}

export interface PlotPanel {
  /** The time changed: the history is asked. */
  range(range: Range): void;
  live(values: readonly Update[]): void;
  /** As time goes on: draws as soon as that shows, and no sooner. */
  goOn(nowUs: number): void;
  cursor(us: number | null): void;
  add(source: Source): void;
  catalogue(series: readonly Series[], gaps: readonly Gap[]): void;
  /** Draws the same fields of these vessels beside the page's own, each vessel in a colour of its own. */
  beside(companions: readonly Companion[]): void;
}

/** Lines that go on are drawn again at least so often, µs: what has grown old is hatched in time. */
const SLOWEST_US = 1_000_000;

interface Plot {
  readonly key: string;
  readonly lines: Line[];
  /** The same of other vessels, with the lines that they go with. */
  beside: { readonly line: Line; readonly like: Line; readonly companion: Companion }[];
  chart: Chart | undefined;
  csv: HTMLElement;
}

export class Plots implements PlotPanel {
  private stretch: Range = { spanUs: 900_000_000 };
  private nowUs = 0;
  /** For which time it was drawn last, µs; never for what is asked for now. */
  private drawnUs = -Infinity;
  private gaps: readonly Gap[] = [];
  private plots: Plot[] = [];
  private companions: readonly Companion[] = [];
  private asked: AbortController | undefined;
  private timer: number | undefined;
  /** Sources of the page's address, until it is known what was recorded. */
  private waiting: Source[];
  private readonly fields: Fields;
  private readonly problem = make("p", { class: "note bad", role: "alert", hidden: "" });
  private readonly empty = make("p", { class: "empty dim" }, t("No field is plotted. Add one here, or by its button among the values."));
  private readonly list = make("div", { class: "plots" });
  /** How wide that is, px: asked while something is drawn the browser would lay out the page for it. */
  private wide = 0;

  constructor(
    root: HTMLElement,
    private readonly vessel: number,
    private readonly researcher: boolean,
    first: string,
    private readonly entity: (number: number) => string,
    private readonly handlers: PlotHandlers,
  ) {
    this.fields = new Fields(entity);
    const repaint = (): void => this.plots.forEach((plot) => this.rebuild(plot));
    new MutationObserver(repaint).observe(document.documentElement, { attributeFilter: ["data-palette"] });
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", repaint);
    new ResizeObserver(([list]) => void (this.wide = list?.contentRect.width ?? 0)).observe(this.list);
    root.append(createChooser(() => this.fields.choices(), (source) => this.add(source)), this.problem, this.empty, this.list);
    this.waiting = first.split(",").map(parsed).filter((source) => source !== undefined);
  }

  range(next: Range): void {
    this.stretch = next;
    this.drawnUs = -Infinity;
    this.ask();
  }

  live(values: readonly Update[]): void {
    for (const update of values) {
      for (const field of update.fields) {
        if (typeof field.value === "number" && update.system === this.vessel) this.fields.hear(update, field.name, field.unit);
      }
      for (const line of this.plots.flatMap(drawn)) if (line.vessel === update.system && line.source.message === update.abbrev && line.source.entity === update.entity) line.add(update);
    }
  }

  goOn(nowUs: number): void {
    const { fromUs, toUs } = ends(this.stretch, nowUs);
    const pixelUs = (toUs - fromUs) / Math.max(100, this.wide);
    // A clock that is set may lead back.
    if (Math.abs(nowUs - this.drawnUs) >= Math.min(SLOWEST_US, pixelUs)) this.draw(nowUs);
  }

  private draw(nowUs: number): void {
    [this.nowUs, this.drawnUs] = [nowUs, nowUs];
    const { fromUs, toUs } = ends(this.stretch, nowUs);
    for (const plot of this.plots) {
      if (!plot.chart) continue;
      this.drawLines(plot, plot.chart, fromUs, toUs);
      if (this.researcher) drawExports(plot.csv, { vessel: this.vessel, lines: plot.lines, beside: plot.beside }, this.companions, fromUs, toUs);
    }
  }

  cursor(us: number | null): void {
    for (const { chart } of this.plots) chart?.cursor(us);
  }

  add(source: Source): void {
    const all = this.sources();
    if (all.some((one) => written(one) === written(source))) return;
    if (all.length >= LINES) {
      this.complain(t("{n} fields plotted (the maximum). Remove one first.", { n: LINES }));
      return;
    }
    const key = `${source.message}/${this.fields.unit(source)}`;
    let plot = this.plots.find((one) => one.key === key);
    if (!plot) {
      plot = { key, lines: [], beside: [], chart: undefined, csv: make("span") };
      this.plots.push(plot);
    }
    plot.lines.push(new Line(source, this.vessel));
    this.rebuild(plot);
    this.changed();
  }

  catalogue(series: readonly Series[], gaps: readonly Gap[]): void {
    this.fields.recorded(series);
    this.gaps = gaps;
    this.drawnUs = -Infinity;
    for (const source of this.waiting) this.add(source);
    this.waiting = [];
  }

  beside(companions: readonly Companion[]): void {
    this.companions = companions;
    this.plots.forEach((plot) => this.rebuild(plot));
    this.ask();
  }

  private sources(): Source[] {
    return this.plots.flatMap(({ lines }) => lines.map(({ source }) => source));
  }

  /** Says what went wrong; empty for nothing. */
  private complain(text: string): void {
    setAttribute(this.problem, "hidden", text ? null : "");
    setText(this.problem, text);
  }

  private ask(): void {
    window.clearTimeout(this.timer);
    this.timer = window.setTimeout(() => void this.fetchAll(), SETTLE_MS);
  }

  private async fetchAll(): Promise<void> {
    this.asked?.abort();
    const mine = new AbortController();
    this.asked = mine;
    const { fromUs, toUs } = ends(this.stretch, this.nowUs || Date.now() * 1_000);
    const pixels = Math.max(100, Math.min(2_000, Math.round(this.list.clientWidth || 800)));
    let told = "";
    await Promise.all(
      this.plots.flatMap(drawn).map(async (line) => {
        const { message, entity, field } = line.source;
        const query = new URLSearchParams({ message, entity: String(entity), field, from_us: String(Math.round(fromUs)), to_us: String(Math.round(toUs) + 1), pixels: String(pixels) });
        try {
          line.recorded(await getJson<Buckets>(`/api/v1/vessels/${line.vessel}/buckets?${query}`, mine.signal), toUs);
        } catch (error) {
          if (!mine.signal.aborted) told = `${message} ${field}: ${reason(error)}`;
        }
      }),
    );
    if (mine.signal.aborted) return;
    this.complain(told);
    this.draw(this.nowUs);
    window.clearTimeout(this.timer);
    if (isLive(this.stretch)) this.timer = window.setTimeout(() => void this.fetchAll(), AGAIN_MS);
  }

  /** Alone, a vessel's lines have a colour each; of several, each vessel has one. */
  private looks({ lines, beside }: Plot): LineLook[] {
    const { companions } = this;
    const label = (source: Source): string => `${this.entity(source.entity)} ${shownField(source)}`.trim();
    if (!companions.length) return lines.map(({ source }, index) => ({ label: label(source), colour: index, dashes: Math.floor(index / SERIES), removable: true }));
    return [
      ...lines.map(({ source }, index) => ({ label: label(source), colour: 0, dashes: index, removable: true })),
      ...beside.map(({ line, like, companion }) => ({ label: `${companion.name} ${companion.labels.get(line.source.entity) ?? line.source.entity} ${shownField(line.source)}`, colour: companions.indexOf(companion) + 1, dashes: lines.indexOf(like), removable: false })),
    ];
  }

  /** The lines of other vessels that go with those of `plot`; lines that are there already keep their values. */
  private besides(plot: Plot): Plot["beside"] {
    const before = new Map(plot.beside.map(({ line }) => [`${line.vessel} ${written(line.source)}`, line]));
    return plot.lines.flatMap((like) =>
      this.companions.flatMap((companion) => {
        const source = likewise(like.source, this.entity(like.source.entity), companion.series, companion.labels);
        const line = source && (before.get(`${companion.address} ${written(source)}`) ?? new Line(source, companion.address));
        return line ? [{ line, like, companion }] : [];
      }),
    );
  }

  /** Makes the chart of `plot` again: its lines, or the colours, are others. */
  private rebuild(plot: Plot): void {
    plot.beside = this.besides(plot);
    this.drawnUs = -Infinity;
    plot.chart?.dispose();
    plot.chart = undefined;
    const source = plot.lines[0]?.source;
    if (!source) return;
    const { unit } = shownUnit(this.fields.unit(source));
    plot.csv = make("span", { class: "buttons" });
    plot.chart = createChart(`${source.message}${unit ? `, ${unit}` : ""}`, unit, this.looks(plot), {
      ...this.handlers,
      cursor: (us) => {
        for (const { chart } of this.plots) if (chart !== plot.chart) chart?.cursor(us);
        this.handlers.cursor(us);
      },
      remove: (index) => {
        plot.lines.splice(index, 1);
        this.rebuild(plot);
        this.plots = this.plots.filter(({ lines }) => lines.length);
        this.changed();
      },
    }, plot.csv);
    const next = this.plots[this.plots.indexOf(plot) + 1]?.chart?.root ?? null;
    this.list.insertBefore(plot.chart.root, next);
  }

  private changed(): void {
    setAttribute(this.empty, "hidden", this.plots.length ? "" : null);
    this.handlers.changed(this.sources());
    this.ask();
  }

  private drawLines(plot: Plot, chart: Chart, fromUs: number, toUs: number): void {
    const told = this.looks(plot);
    const like = [...plot.lines, ...plot.beside.map(({ like }) => like)].map(({ source }) => source);
    const lines = drawn(plot).map((line, index) => {
      const source = like[index] ?? line.source;
      const period = this.fields.periodUs(source);
      return {
        label: told[index]?.label ?? "",
        table: line.table(shownUnit(this.fields.unit(source)).factor, GAP_PERIODS * period),
        freshS: isLive(this.stretch) ? freshForS({ period_s: period / 1e6 }) : undefined,
      };
    });
    chart.update(lines, fromUs, toUs, this.gaps);
  }
}

/** All lines of a plot: the vessel's own, then those beside. */
function drawn({ lines, beside }: Plot): Line[] {
  return [...lines, ...beside.map(({ line }) => line)];
}

function shownField({ message, field }: Source): string {
  return quantity(message, field) || field;
}
