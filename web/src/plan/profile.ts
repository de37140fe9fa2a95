// The charted depth along the plan: a plot with the limits, which the keyboard can walk along, and a table of the same.

import uPlot from "uplot";
import { postJson, reason } from "../api/http";
import type { ChartCorridor, ChartProfilePoint, PlanPlace } from "../api/types.gen";
import { CANVAS_FONT, readPalette } from "../map/palette";
import { depthText, type DepthLimits } from "../state/chart";
import type { LeastDepth } from "../state/planverdict";
import { make, setText } from "../ui/dom";
import { t } from "../words/words";
import { lengthText } from "./steps";

const HEIGHT_PX = 190;
/** After the last change it is asked for this much later, ms. */
const SETTLE_MS = 400;
const PATIENCE_MS = 10_000;
/** The server takes no more points. */
const MOST_POINTS = 500;
/** Rows of the table; of what lies between, the shallowest is told. */
const ROWS = 40;

export interface Profile {
  /** The way to look at, and half the width that the server looks at beside it, m. */
  update(way: readonly PlanPlace[]): void;
  limits(limits: DepthLimits | undefined): void;
  repaint(): void;
}

/** Into `root`; `mark` is told how far along the way the cursor is, as a place, and `least` the least depth as soon as it is known. */
export function createProfile(root: HTMLElement, halfWidth_m: number, mark: (place: PlanPlace | null) => void, least: (depth: LeastDepth | undefined) => void): Profile {
  return new DepthProfile(root, halfWidth_m, mark, least);
}

class DepthProfile implements Profile {
  private readonly said = make("p", { class: "dim", role: "status" });
  private readonly box = make("div", { class: "canvas", tabindex: "0", role: "application", "aria-label": t("Depth along the plan. Left and right move the cursor, with Shift by more; the table below tells the same.") });
  private readonly table = make("div", { class: "wide", tabindex: "0", role: "region", "aria-label": t("Depth along the plan as a table") });
  private by: DepthLimits | undefined;
  private way: readonly PlanPlace[] = [];
  private points: readonly ChartProfilePoint[] = [];
  private length_m = 0;
  private plot: uPlot | undefined;
  private settle: number | undefined;
  /** Of several questions the last one counts. */
  private asked = 0;
  private before = "";

  constructor(private readonly root: HTMLElement, private readonly halfWidth_m: number, private readonly mark: (place: PlanPlace | null) => void, private readonly least: (depth: LeastDepth | undefined) => void) {
    root.replaceChildren(make("h2", { id: "profile-title" }, t("Depth along the plan")), this.said, this.box, make("details", {}, make("summary", {}, t("As a table")), this.table));
    root.hidden = true;
    this.box.addEventListener("keydown", (event) => this.key(event));
    new ResizeObserver(() => this.box.clientWidth && this.plot?.setSize({ width: this.box.clientWidth, height: HEIGHT_PX })).observe(this.box);
  }

  update(next: readonly PlanPlace[]): void {
    const spread = next.filter((_, at) => at % Math.ceil(next.length / MOST_POINTS) === 0 || at === next.length - 1);
    const text = JSON.stringify(spread);
    if (text === this.before) return;
    this.before = text;
    this.way = spread;
    this.again();
  }

  limits(next: DepthLimits | undefined): void {
    if (next?.autonomous_m === this.by?.autonomous_m && next?.navigable_m === this.by?.navigable_m) return;
    this.by = next;
    this.again();
  }

  repaint(): void {
    this.draw();
  }

  private again(): void {
    window.clearTimeout(this.settle);
    this.asked++;
    this.least(undefined);
    this.root.hidden = !this.by || this.way.length < 2;
    if (!this.root.hidden) this.settle = window.setTimeout(() => void this.ask(), SETTLE_MS);
  }

  private async ask(): Promise<void> {
    const number = this.asked;
    try {
      const answer = await postJson<ChartCorridor>("/api/v1/chart/corridor", PATIENCE_MS, { points: this.way.map((place) => [place.lat_deg, place.lon_deg]), half_width_m: this.halfWidth_m });
      if (number === this.asked) this.take(answer);
    } catch (error) {
      if (number !== this.asked) return;
      this.points = [];
      this.draw();
      this.table.replaceChildren();
      setText(this.said, t("The depths are not known: {reason}", { reason: reason(error) }));
    }
  }

  private take(answer: ChartCorridor): void {
    [this.points, this.length_m] = [answer.profile, answer.length_m];
    // A plan that stays at one place has nothing along it; its depth is in the verdict.
    this.root.hidden = answer.length_m < 1;
    this.draw();
    this.fillTable();
    setText(this.said, this.summary());
    const worst = this.points.length ? shallowest(this.points) : undefined;
    const place = worst && this.placeOf(worst);
    this.least(worst && place ? { depth_m: worst.depth_m, place } : undefined);
  }

  private draw(): void {
    const { points, by, box } = this;
    this.plot?.destroy();
    this.plot = undefined;
    box.replaceChildren();
    if (!points.length || !by) return;
    const along = points.map((point) => point.along_m);
    const depths = points.map((point) => point.depth_m);
    const flat = (value: number): number[] => along.map(() => value);
    this.plot = new uPlot(this.options(by, depths), [along, depths, flat(by.autonomous_m), flat(by.navigable_m)], box);
  }

  private options({ autonomous_m: safe }: DepthLimits, depths: readonly (number | null)[]): uPlot.Options {
    const palette = readPalette();
    const known = depths.filter((one): one is number => one !== null);
    const deepest = Math.max(safe * 2, ...known);
    const highest = Math.min(-1, ...known);
    const axis: uPlot.Axis = { stroke: palette.ink, grid: { stroke: palette.grid, width: 1 }, ticks: { stroke: palette.grid, width: 1 }, font: `13px ${CANVAS_FONT}` };
    return {
      width: this.box.clientWidth || 400,
      height: HEIGHT_PX,
      legend: { show: false },
      scales: { x: { time: false }, y: { dir: -1, range: [highest, deepest * 1.05] } },
      axes: [
        { ...axis, values: (_, splits) => splits.map((metres) => lengthText(metres)) },
        { ...axis, size: 56, values: (_, splits) => splits.map((metres) => `${metres} m`.replace("-", "−")) },
      ],
      series: [
        {},
        { label: t("charted depth"), stroke: palette.series[0] ?? palette.ink, width: 2, points: { show: false }, spanGaps: false },
        { label: t("safety depth"), stroke: palette.ink, width: 1.5, dash: [8, 4], points: { show: false } },
        { label: "navigable", stroke: palette.danger, width: 2, dash: [3, 3], points: { show: false } },
      ],
      cursor: { drag: { x: false, y: false, setScale: false }, points: { size: 8 }, bind: { dblclick: () => null } },
      hooks: { setCursor: [(self) => this.moved(self)], drawClear: [(self) => closed(self, this.points, palette.danger)] },
    };
  }

  private moved(self: uPlot): void {
    const at = (self.cursor.left ?? -1) < 0 ? null : (self.cursor.idx ?? null);
    const point = at === null ? undefined : this.points[at];
    setText(this.said, point ? t("At {along}: {words}", { along: lengthText(point.along_m), words: words(point) }) : this.summary());
    this.mark(point ? this.placeOf(point) : null);
  }

  private placeOf(point: ChartProfilePoint): PlanPlace | null {
    return placeAlong(this.way, this.length_m ? point.along_m / this.length_m : 0);
  }

  private summary(): string {
    const { points, length_m, by } = this;
    if (!points.length) return "";
    const worst = shallowest(points);
    return t("Least depth on track: {words} at {along} of {length}. Limits: {navigable} m under an operator's hand (dotted), {autonomous} m by itself (dashed).", { words: words(worst), along: lengthText(worst.along_m), length: lengthText(length_m), navigable: by?.navigable_m ?? "?", autonomous: by?.autonomous_m ?? "?" });
  }

  private fillTable(): void {
    const { points } = this;
    const each = Math.max(1, Math.ceil(points.length / ROWS));
    const rows: HTMLElement[] = [];
    for (let at = 0; at < points.length; at += each) {
      const worst = shallowest(points.slice(at, at + each));
      rows.push(make("tr", {}, make("td", { class: "num" }, lengthText(worst.along_m)), make("td", { class: "num" }, words(worst)), make("td", {}, judged(worst, this.by))));
    }
    const head = make("tr", {}, ...[t("Along"), t("Charted"), t("For a vessel by itself")].map((text) => make("th", { scope: "col" }, text)));
    this.table.replaceChildren(make("table", { class: "compact" }, make("thead", {}, head), make("tbody", {}, ...rows)));
  }

  private key(event: KeyboardEvent): void {
    const { plot } = this;
    if (!plot || !["ArrowLeft", "ArrowRight", "Home", "End", "Escape"].includes(event.key)) return;
    const wide = plot.over.clientWidth;
    const left = plot.cursor.left ?? -1;
    const step = (event.shiftKey ? 0.1 : 0.01) * wide;
    const to = { ArrowLeft: Math.max(0, left - step), ArrowRight: Math.min(wide, left + step), Home: 0, End: wide, Escape: -10 }[event.key] ?? -10;
    plot.setCursor({ left: to, top: to < 0 ? -10 : HEIGHT_PX / 2 });
    event.preventDefault();
    event.stopPropagation();
  }
}

/** The shallowest; what is no water of known depth is shallower than all. */
function shallowest(points: readonly ChartProfilePoint[]): ChartProfilePoint {
  return points.reduce((worst, one) => ((one.depth_m ?? -Infinity) < (worst.depth_m ?? -Infinity) ? one : worst));
}

function words(point: ChartProfilePoint): string {
  return point.depth_m === null ? point.kind.replaceAll("-", " ") : depthText(point.depth_m);
}

function judged(point: ChartProfilePoint, limits: DepthLimits | undefined): string {
  if (!limits) return "";
  if (point.depth_m === null) return t("closed");
  if (point.depth_m >= limits.autonomous_m) return t("deep enough");
  return point.depth_m >= limits.navigable_m ? t("only under an operator's hand") : t("too shallow");
}

/** Where no water of known depth is charted: filled from top to bottom. */
function closed(plot: uPlot, points: readonly ChartProfilePoint[], colour: string): void {
  const { ctx, bbox } = plot;
  ctx.save();
  ctx.fillStyle = colour;
  ctx.globalAlpha = 0.35;
  points.forEach((point, at) => {
    if (point.depth_m !== null) return;
    const [from, to] = [points[at - 1]?.along_m ?? point.along_m, points[at + 1]?.along_m ?? point.along_m];
    const left = plot.valToPos((from + point.along_m) / 2, "x", true);
    const right = plot.valToPos((to + point.along_m) / 2, "x", true);
    ctx.fillRect(left, bbox.top, Math.max(1, right - left), bbox.height);
  });
  ctx.restore();
}

/** The place at a part of a line's length. */
function placeAlong(way: readonly PlanPlace[], part: number): PlanPlace | null {
  const lengths = way.slice(1).map((place, at) => {
    const before = way[at] ?? place;
    return Math.hypot(place.lat_deg - before.lat_deg, (place.lon_deg - before.lon_deg) * Math.cos((place.lat_deg * Math.PI) / 180));
  });
  let left = part * lengths.reduce((sum, one) => sum + one, 0);
  for (const [at, length] of lengths.entries()) {
    const [from, to] = [way[at], way[at + 1]];
    if (from && to && (left <= length || at === lengths.length - 1)) {
      const share = length > 0 ? Math.min(1, left / length) : 0;
      return { lat_deg: from.lat_deg + (to.lat_deg - from.lat_deg) * share, lon_deg: from.lon_deg + (to.lon_deg - from.lon_deg) * share };
    }
    left -= length;
  }
  return way[0] ?? null;
}
