// The plots of the explorer: tags by time, detections by time, effort. Drawn from counts that the server made, as wide as the page.

import type { ComponentChildren } from "preact";
import { useEffect, useRef, useState } from "preact/hooks";
import type { DetectionsSummary, SummaryTag } from "../api/types.gen";
import { abacusNumbers, barNumbers, barsBegin, barsTitle, brushed, countedFrom, lengthText, ticks } from "../state/explore";
import { tagSeries } from "../state/tags";
import { utc } from "../ui/format";
import { count, t } from "../words/words";
import { PlotFile } from "./plotfile";

interface Part {
  readonly found: DetectionsSummary;
}

/** A plot over which a stretch of time is drawn to be looked at; µs. */
interface Drawn {
  choose(from: number, to: number): void;
}

/** Heights and margins of plots, px; on a narrow page there is less room for names. */
const [RIGHT, ROW, BARS, AXIS, LEFT, LEFT_NARROW, NARROW] = [12, 22, 150, 40, 150, 92, 640] as const;
/** Room for a letter of a name, and for a mark of the time, px. */
const [LETTER, TICK] = [7, 84] as const;

/** Where on a plot a time is. */
interface Frame {
  readonly width: number;
  readonly left: number;
  readonly from: number;
  readonly to: number;
  x(us: number): number;
  us(x: number): number;
}

function frameOf({ from_us, to_us }: DetectionsSummary, width: number): Frame {
  const [from, to, left] = [from_us ?? 0, to_us ?? 1, width < NARROW ? LEFT_NARROW : LEFT];
  const right = width - RIGHT;
  const long = Math.max(1, to - from);
  return {
    width, left, from, to,
    x: (us) => Math.min(right, left + (Math.max(0, us - from) / long) * (right - left)),
    us: (x) => from + (Math.max(0, Math.min(right, x) - left) / (right - left)) * long,
  };
}

/** Marks of the time below a plot, and between which days it lies. */
function TimeAxis({ frame: { width, left, from, to, x }, y }: { readonly frame: Frame; readonly y: number }) {
  const most = Math.max(2, Math.floor((width - left - RIGHT) / TICK));
  const [first, last] = [utc(from).slice(0, 10), utc(to).slice(0, 10)];
  return (
    <g class="axis">
      <line x1={left} x2={width - RIGHT} y1={y} y2={y} />
      {ticks(from, to, most).map(({ us, text }) => {
        // A mark near an edge stands within it.
        const at = x(us);
        const side = at > width - RIGHT - TICK / 2 ? "end" : at < left + TICK / 2 ? "" : "middle";
        return <g key={us}><line x1={at} x2={at} y1={y} y2={y + 5} /><text x={at} y={y + 18} class={side}>{text}</text></g>;
      })}
      <text x={left} y={y + 34} class="dim">{first} UTC</text>
      {first !== last && <text x={width - RIGHT} y={y + 34} class="end dim">{last} UTC</text>}
    </g>
  );
}

/** A hand must move so far before it draws, px. */
const DRAWS_PX = 5;

/** What is drawn over a plot: where it began, px, and from when to when, µs: while the server still reads, the axis moves under the hand. */
interface Brush {
  readonly x: number;
  readonly one: number;
  readonly other: number;
}

/** A plot over which a stretch of time is drawn, by mouse, pen or finger, in whole steps from `begin`; Escape ends that without a choice.
 * By keyboard the fields of the page are the way. */
function Brushed({ frame, high, begin, step, label, choose, children }: Drawn & { readonly frame: Frame; readonly high: number; readonly begin: number; readonly step: number; readonly label: string; readonly children: ComponentChildren }) {
  const [drawn, draw] = useState<Brush | undefined>(undefined);
  const pointer = useRef<number | undefined>(undefined);
  const at = ({ currentTarget, clientX }: PointerEvent): number => {
    const box = (currentTarget as SVGSVGElement).getBoundingClientRect();
    return ((clientX - box.left) * frame.width) / box.width;
  };
  const end = (): void => {
    pointer.current = undefined;
    draw(undefined);
  };
  useEffect(() => {
    if (!drawn) return undefined;
    const escape = (event: KeyboardEvent): void => {
      if (event.key !== "Escape") return;
      event.preventDefault();
      end();
    };
    window.addEventListener("keydown", escape, true);
    return () => window.removeEventListener("keydown", escape, true);
  }, [drawn !== undefined]);
  const down = (event: PointerEvent): void => {
    if (event.button !== 0 || !event.isPrimary || at(event) < frame.left) return;
    (event.currentTarget as SVGSVGElement).setPointerCapture(event.pointerId);
    pointer.current = event.pointerId;
    const us = frame.us(at(event));
    draw({ x: at(event), one: us, other: us });
  };
  const move = (event: PointerEvent): void => {
    if (drawn && pointer.current === event.pointerId) draw({ ...drawn, other: frame.us(at(event)) });
  };
  const up = (event: PointerEvent): void => {
    if (!drawn || pointer.current !== event.pointerId) return;
    end();
    if (Math.abs(drawn.x - at(event)) < DRAWS_PX) return;
    const { from, to } = brushed(drawn.one, frame.us(at(event)), begin, step);
    choose(from, to);
  };
  const [left, right] = drawn ? [frame.x(Math.min(drawn.one, drawn.other)), frame.x(Math.max(drawn.one, drawn.other))] : [0, 0];
  return (
    <svg class="explore-plot brushed" viewBox={`0 0 ${frame.width} ${high + AXIS}`} role="img" aria-label={label} onPointerDown={down} onPointerMove={move} onPointerUp={up} onPointerCancel={end}>
      {children}
      {drawn && <rect class="brush" x={left} y={0} width={Math.max(0, right - left)} height={high} />}
    </svg>
  );
}

/** A tag's marks: filled where something confirms them, hollow where nothing does. */
function TagRow({ of: { tag, tag_id, animal, name: called, marks }, row, step_us, frame: { width, left, from, x } }: { readonly of: SummaryTag; readonly row: number; readonly step_us: number; readonly frame: Frame }) {
  const wide = Math.max(2, x(from + step_us) - left);
  const [name, letters] = [animal || called || tag, Math.floor((left - 12) / LETTER)];
  const box = (at: number, top: number, least: number, less: number): string => `M${x(from + at * step_us).toFixed(1)} ${row * ROW + top}h${Math.max(least, wide).toFixed(1)}v${ROW - less}h-${Math.max(least, wide).toFixed(1)}z`;
  return (
    <g>
      <text x={left - 8} y={row * ROW + 15} class="end"><title>{[...new Set([animal, called, tag])].filter(Boolean).join(", ")}</title>{name.length > letters ? `${name.slice(0, letters - 1)}…` : name}</text>
      <line class="grid" x1={left} x2={width - RIGHT} y1={row * ROW + ROW - 1} y2={row * ROW + ROW - 1} />
      <path class={`series-${tagSeries(tag_id)}`} d={marks.filter(([, all, unconfirmed]) => all > unconfirmed).map(([at]) => box(at, 3, 2, 7)).join("")} />
      <path class="doubted" d={marks.filter(([, all, unconfirmed]) => all === unconfirmed).map(([at]) => box(at, 4, 4, 9)).join("")} />
    </g>
  );
}

export function Abacus({ found, choose }: Part & Drawn) {
  const { tags, tags_all, step_us } = found;
  const draw = (width: number) => {
    const frame = frameOf(found, width);
    return (
      <Brushed frame={frame} high={tags.length * ROW} begin={frame.from} step={step_us} choose={choose} label={t("Each tag's detections by time: {n} tags, {length} a mark. The numbers are in the CSV.", { n: tags.length, length: lengthText(step_us) })}>
        {tags.map((tag, row) => <TagRow key={`${tag.tag}/${tag.name}/${tag.animal}`} of={tag} row={row} step_us={step_us} frame={frame} />)}
        <TimeAxis frame={frame} y={tags.length * ROW + 4} />
      </Brushed>
    );
  };
  return (
    <PlotFile title={t("Tags by time")} file="tags-by-time" numbers={() => abacusNumbers(found)} draw={draw}>
      {tags_all > tags.length && <p class="dim">{countedFrom(found) === undefined ? t("The {shown} tags that were heard most, of {all}.", { shown: tags.length, all: count(tags_all) }) : t("The {shown} tags that were heard most, of at least {all}.", { shown: tags.length, all: count(tags_all) })}</p>}
      {tags.some(({ unconfirmed }) => unconfirmed > 0) && <p class="dim">{t("Hollow marks: nothing confirms these detections.")}</p>}
      <p class="dim no-print">{t("Drag over a plot to look at a shorter time; From and To do the same. Escape or Back undoes it.")} {t("From and To are times of report, by the vessel's clock; the plots show when tags were heard, by the receiver's.")}</p>
    </PlotFile>
  );
}

/** Bars of a number for each stretch of time. */
function BarPlot({ found, title, file, value, unit, choose }: Part & Drawn & { readonly title: string; readonly file: string; readonly value: (bar: DetectionsSummary["bars"][number]) => number; readonly unit: string }) {
  const most = found.bars.reduce((all, bar) => Math.max(all, value(bar)), 0) || 1;
  const y = (of: number): number => BARS - (of / most) * (BARS - 12);
  const mostText = `${count(Number(most.toPrecision(3)))} ${unit}`.trim();
  const draw = (width: number) => {
    const frame = frameOf(found, width);
    const bars = found.bars.filter((bar) => value(bar) > 0).map((bar) => {
      const [left, right] = [frame.x(bar.from_us), frame.x(bar.from_us + found.bar_us)];
      return `M${left.toFixed(1)} ${BARS}V${y(value(bar)).toFixed(1)}H${Math.max(left + 1, right - 1).toFixed(1)}V${BARS}z`;
    });
    return (
      <Brushed frame={frame} high={BARS} begin={barsBegin(found)} step={found.bar_us} choose={choose} label={t("{title}: at most {most}. The numbers are in the CSV.", { title, most: mostText })}>
        <text x={frame.left - 8} y={18} class="end">{mostText}</text>
        <text x={frame.left - 8} y={BARS} class="end">0</text>
        <path class="series-0" d={bars.join("")} />
        <TimeAxis frame={frame} y={BARS} />
      </Brushed>
    );
  };
  return <PlotFile title={title} file={file} numbers={() => barNumbers(found)} draw={draw} />;
}

export function Bars({ found, choose }: Part & Drawn) {
  return <BarPlot found={found} choose={choose} title={barsTitle(found.bar_us)} file="detections-by-time" value={({ detections }) => detections} unit="" />;
}

/** Hours listened; said plainly where nobody told. */
export function Effort({ found, area, choose }: Part & Drawn & { readonly area: boolean }) {
  if (found.bars.some(({ listened_s }) => listened_s !== null)) return <BarPlot found={found} choose={choose} title={t("Hours listened, all receivers together")} file="effort" value={({ listened_s }) => (listened_s ?? 0) / 3_600} unit="h" />;
  return <section class="plot-file" aria-label={t("Effort")}><h2>{t("Effort")}</h2><p>{area ? t("How long was listened within an area is not known. Remove the area to see the hours.") : t("These vessels did not report when they listened.")}</p></section>;
}
