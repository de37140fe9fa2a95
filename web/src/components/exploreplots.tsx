// The plots of the explorer: tags by time, detections by time, effort. Drawn from counts that the server made.

import type { DetectionsSummary } from "../api/types.gen";
import { abacusNumbers, barNumbers, lengthText } from "../state/explore";
import { tagSeries } from "../state/tags";
import { utc } from "../ui/format";
import { count, t } from "../words/words";
import { PlotFile } from "./plotfile";

interface Part {
  readonly found: DetectionsSummary;
}

const [WIDTH, LEFT, RIGHT, ROW, BARS] = [1_200, 150, 12, 22, 150] as const;

function spanOf({ from_us, to_us }: DetectionsSummary): { readonly x: (us: number) => number; readonly from: number; readonly to: number } {
  const [from, to] = [from_us ?? 0, to_us ?? 1];
  return { from, to, x: (us) => LEFT + (Math.max(0, us - from) / Math.max(1, to - from)) * (WIDTH - LEFT - RIGHT) };
}

/** Begin and end below a plot. */
function TimeAxis({ found, y }: Part & { readonly y: number }) {
  const { from, to } = spanOf(found);
  return (
    <g class="axis">
      <line x1={LEFT} x2={WIDTH - RIGHT} y1={y} y2={y} />
      <text x={LEFT} y={y + 18}>{utc(from)}</text>
      <text x={WIDTH - RIGHT} y={y + 18} class="end">{utc(to)}</text>
    </g>
  );
}

export function Abacus({ found }: Part) {
  const { from, x } = spanOf(found);
  const { tags, tags_all, step_us } = found;
  const height = tags.length * ROW + 30;
  const wide = Math.max(2, x(from + step_us) - LEFT);
  return (
    <PlotFile title={t("Tags by time")} file="tags-by-time" numbers={() => abacusNumbers(found)}>
      <svg class="explore-plot" viewBox={`0 0 ${WIDTH} ${height}`} role="img" aria-label={t("Each tag's detections by time: {n} tags, {length} a mark. The numbers are in the CSV.", { n: tags.length, length: lengthText(step_us) })}>
        {tags.map(({ tag, tag_id, animal, marks }, row) => (
          <g key={tag}>
            <text x={LEFT - 8} y={row * ROW + 15} class="end">{animal || tag}</text>
            <line class="grid" x1={LEFT} x2={WIDTH - RIGHT} y1={row * ROW + ROW - 1} y2={row * ROW + ROW - 1} />
            <path class={`series-${tagSeries(tag_id)}`} d={marks.filter(([, count, unconfirmed]) => count > unconfirmed).map(([at]) => `M${x(from + at * step_us).toFixed(1)} ${row * ROW + 3}h${wide.toFixed(1)}v${ROW - 7}h-${wide.toFixed(1)}z`).join("")} />
            <path class="doubted" d={marks.filter(([, count, unconfirmed]) => count === unconfirmed).map(([at]) => `M${x(from + at * step_us).toFixed(1)} ${row * ROW + 4}h${Math.max(4, wide).toFixed(1)}v${ROW - 9}h-${Math.max(4, wide).toFixed(1)}z`).join("")} />
          </g>
        ))}
        <TimeAxis found={found} y={tags.length * ROW + 4} />
      </svg>
      {tags_all > tags.length && <p class="dim">{t("The {shown} tags that were heard most, of {all}.", { shown: tags.length, all: tags_all })}</p>}
      {tags.some(({ unconfirmed }) => unconfirmed > 0) && <p class="dim">{t("Hollow marks: nothing confirms these detections.")}</p>}
    </PlotFile>
  );
}

/** Bars of a number for each stretch of time. */
function BarPlot({ found, title, file, value, unit }: Part & { readonly title: string; readonly file: string; readonly value: (bar: DetectionsSummary["bars"][number]) => number; readonly unit: string }) {
  const { x } = spanOf(found);
  const most = found.bars.reduce((all, bar) => Math.max(all, value(bar)), 0) || 1;
  const y = (of: number): number => BARS - (of / most) * (BARS - 12);
  const mostText = `${count(Number(most.toPrecision(3)))} ${unit}`.trim();
  return (
    <PlotFile title={title} file={file} numbers={() => barNumbers(found)}>
      <svg class="explore-plot" viewBox={`0 0 ${WIDTH} ${BARS + 28}`} role="img" aria-label={t("{title}: at most {most}. The numbers are in the CSV.", { title, most: mostText })}>
        <text x={LEFT - 8} y={18} class="end">{mostText}</text>
        <text x={LEFT - 8} y={BARS} class="end">0</text>
        <path class="series-0" d={found.bars.filter((bar) => value(bar) > 0).map((bar) => { const [left, right] = [x(bar.from_us), x(bar.from_us + found.bar_us)]; return `M${left.toFixed(1)} ${BARS}V${y(value(bar)).toFixed(1)}H${Math.max(left + 1, Math.min(WIDTH - RIGHT, right) - 1).toFixed(1)}V${BARS}z`; }).join("")} />
        <TimeAxis found={found} y={BARS} />
      </svg>
    </PlotFile>
  );
}

export function Bars({ found }: Part) {
  const length = lengthText(found.bar_us);
  const title = found.bar_us === 3_600_000_000 ? t("Detections per hour") : t("Detections per {length}", { length });
  return <BarPlot found={found} title={title} file="detections-by-time" value={({ detections }) => detections} unit="" />;
}

/** Hours listened; said plainly where nobody told. */
export function Effort({ found, area }: Part & { readonly area: boolean }) {
  if (found.bars.some(({ listened_s }) => listened_s !== null)) return <BarPlot found={found} title={t("Hours listened, all receivers together")} file="effort" value={({ listened_s }) => (listened_s ?? 0) / 3_600} unit="h" />;
  return <section class="plot-file" aria-label={t("Effort")}><h2>{t("Effort")}</h2><p>{area ? t("How long was listened within an area is not known. Remove the area to see the hours.") : t("These vessels did not report when they listened.")}</p></section>;
}
