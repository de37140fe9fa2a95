// The charted depth along the plan: a plot with the limits, which the keyboard can walk along, and a table of the same.

import uPlot from "uplot";
import { postJson, reason } from "../api/http";
import type { ChartCorridor, ChartProfilePoint, PlanPlace } from "../api/types.gen";
import { CANVAS_FONT, readPalette } from "../map/palette";
import { depthText, type DepthLimits } from "../state/chart";
import type { LeastDepth } from "../state/planverdict";
import { make, setText } from "../ui/dom";
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
  const title = make("h2", { id: "profile-title" }, "Depth along the plan");
  const told = make("p", { class: "dim", role: "status" });
  const box = make("div", { class: "canvas", tabindex: "0", role: "application", "aria-label": "Depth along the plan. Left and right move the cursor, with Shift by more; the table below tells the same." });
  const table = make("div", { class: "wide", tabindex: "0", role: "region", "aria-label": "Depth along the plan as a table" });
  const twin = make("details", {}, make("summary", {}, "As a table"), table);
  root.replaceChildren(title, told, box, twin);
  root.hidden = true;
  let limits: DepthLimits | undefined;
  let way: readonly PlanPlace[] = [];
  let points: readonly ChartProfilePoint[] = [];
  let length_m = 0;
  let plot: uPlot | undefined;

  const draw = (): void => {
    plot?.destroy();
    plot = undefined;
    box.replaceChildren();
    if (!points.length || !limits) return;
    const { autonomous_m: safe, navigable_m: least } = limits;
    const palette = readPalette();
    const along = points.map((point) => point.along_m);
    const depths = points.map((point) => (point.depth_m === null ? null : point.depth_m));
    const known = depths.filter((one): one is number => one !== null);
    const deepest = Math.max(safe * 2, ...known);
    const highest = Math.min(-1, ...known);
    const axis: uPlot.Axis = { stroke: palette.ink, grid: { stroke: palette.grid, width: 1 }, ticks: { stroke: palette.grid, width: 1 }, font: `13px ${CANVAS_FONT}` };
    const flat = (value: number): number[] => along.map(() => value);
    plot = new uPlot(
      {
        width: box.clientWidth || 400,
        height: HEIGHT_PX,
        legend: { show: false },
        scales: { x: { time: false }, y: { dir: -1, range: [highest, deepest * 1.05] } },
        axes: [
          { ...axis, values: (_, splits) => splits.map((metres) => lengthText(metres)) },
          { ...axis, size: 56, values: (_, splits) => splits.map((metres) => `${metres} m`.replace("-", "−")) },
        ],
        series: [
          {},
          { label: "charted depth", stroke: palette.series[0] ?? palette.ink, width: 2, points: { show: false }, spanGaps: false },
          { label: "safety depth", stroke: palette.ink, width: 1.5, dash: [8, 4], points: { show: false } },
          { label: "navigable", stroke: palette.danger, width: 2, dash: [3, 3], points: { show: false } },
        ],
        cursor: { drag: { x: false, y: false, setScale: false }, points: { size: 8 }, bind: { dblclick: () => null } },
        hooks: { setCursor: [(self) => moved(self)], drawClear: [(self) => closed(self, points, palette.danger)] },
      },
      [along, depths, flat(safe), flat(least)],
      box,
    );
  };
  const moved = (self: uPlot): void => {
    const at = (self.cursor.left ?? -1) < 0 ? null : (self.cursor.idx ?? null);
    const point = at === null ? undefined : points[at];
    setText(told, point ? `At ${lengthText(point.along_m)}: ${words(point)}` : summary());
    mark(point ? placeAlong(way, length_m ? point.along_m / length_m : 0) : null);
  };
  const summary = (): string => {
    if (!points.length) return "";
    const worst = shallowest(points);
    return `Least depth on track: ${words(worst)} at ${lengthText(worst.along_m)} of ${lengthText(length_m)}. Limits: ${limits?.navigable_m} m under an operator's hand (dotted), ${limits?.autonomous_m} m by itself (dashed).`;
  };
  const fillTable = (): void => {
    const each = Math.max(1, Math.ceil(points.length / ROWS));
    const rows: HTMLElement[] = [];
    for (let at = 0; at < points.length; at += each) {
      const part = points.slice(at, at + each);
      const worst = shallowest(part);
      rows.push(make("tr", {}, make("td", { class: "num" }, lengthText(worst.along_m)), make("td", { class: "num" }, words(worst)), make("td", {}, judged(worst, limits))));
    }
    const head = make("tr", {}, ...["Along", "Charted", "For a vessel by itself"].map((text) => make("th", { scope: "col" }, text)));
    table.replaceChildren(make("table", { class: "compact" }, make("thead", {}, head), make("tbody", {}, ...rows)));
  };
  box.addEventListener("keydown", (event) => {
    if (!plot || !["ArrowLeft", "ArrowRight", "Home", "End", "Escape"].includes(event.key)) return;
    const wide = plot.over.clientWidth;
    const left = plot.cursor.left ?? -1;
    const step = (event.shiftKey ? 0.1 : 0.01) * wide;
    const to = { ArrowLeft: Math.max(0, left - step), ArrowRight: Math.min(wide, left + step), Home: 0, End: wide, Escape: -10 }[event.key] ?? -10;
    plot.setCursor({ left: to, top: to < 0 ? -10 : HEIGHT_PX / 2 });
    event.preventDefault();
    event.stopPropagation();
  });
  new ResizeObserver(() => box.clientWidth && plot?.setSize({ width: box.clientWidth, height: HEIGHT_PX })).observe(box);

  let settle: number | undefined;
  let asked = 0;
  const ask = async (): Promise<void> => {
    const number = asked;
    try {
      const answer = await postJson<ChartCorridor>("/api/v1/chart/corridor", PATIENCE_MS, { points: way.map((place) => [place.lat_deg, place.lon_deg]), half_width_m: halfWidth_m });
      if (number !== asked) return;
      points = answer.profile;
      length_m = answer.length_m;
      draw();
      fillTable();
      setText(told, summary());
      const worst = points.length ? shallowest(points) : undefined;
      const place = worst && placeAlong(way, length_m ? worst.along_m / length_m : 0);
      least(worst && place ? { depth_m: worst.depth_m, place } : undefined);
    } catch (error) {
      if (number !== asked) return;
      points = [];
      draw();
      table.replaceChildren();
      setText(told, `The depths are not known: ${reason(error)}`);
    }
  };

  const again = (): void => {
    window.clearTimeout(settle);
    asked++;
    least(undefined);
    root.hidden = !limits || way.length < 2;
    if (!root.hidden) settle = window.setTimeout(() => void ask(), SETTLE_MS);
  };
  let before = "";
  return {
    update(next) {
      const spread = next.filter((_, at) => at % Math.ceil(next.length / MOST_POINTS) === 0 || at === next.length - 1);
      const text = JSON.stringify(spread);
      if (text === before) return;
      before = text;
      way = spread;
      again();
    },
    limits(next) {
      if (next?.autonomous_m === limits?.autonomous_m && next?.navigable_m === limits?.navigable_m) return;
      limits = next;
      again();
    },
    repaint: draw,
  };
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
  if (point.depth_m === null) return "closed";
  if (point.depth_m >= limits.autonomous_m) return "deep enough";
  return point.depth_m >= limits.navigable_m ? "only under an operator's hand" : "too shallow";
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
