// The plots of a vessel: fields of one message and unit share a plot; history from the server, the present live.

import { getJson, reason } from "../api/http";
import type { Buckets, Gap, Series, Update } from "../api/types.gen";
import { readPalette } from "../map/palette";
import { freshForS } from "../state/fleet";
import { make, setAttribute, setText } from "../ui/dom";
import { type Chart, createChart, type LineLook } from "./chart";
import { type Choice, createChooser } from "./chooser";
import { type Companion, ends, exports, isLive, likewise, Line, parsed, type Range, shownUnit, type Source, written } from "./model";

/** Most lines at once. */
const LINES = 16;
/** While the present is followed, the history is asked anew so often, ms. */
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
  draw(nowUs: number): void;
  cursor(us: number | null): void;
  add(source: Source): void;
  catalogue(series: readonly Series[], gaps: readonly Gap[]): void;
  /** Draws the same fields of these vessels beside the page's own, each vessel in a colour of its own. */
  beside(companions: readonly Companion[]): void;
}

interface Plot {
  readonly key: string;
  readonly lines: Line[];
  /** The same of other vessels, with the lines that they go with. */
  beside: { readonly line: Line; readonly like: Line; readonly companion: Companion }[];
  chart: Chart | undefined;
  csv: HTMLElement;
}

export function createPlots(root: HTMLElement, vessel: number, researcher: boolean, first: string, entity: (number: number) => string, handlers: PlotHandlers): PlotPanel {
  let range: Range = { spanUs: 900_000_000 };
  let nowUs = 0;
  let series = new Map<string, Series>();
  let gaps: readonly Gap[] = [];
  const heard = new Map<string, { unit: string; period_s: number | null }>();
  let plots: Plot[] = [];
  let companions: readonly Companion[] = [];
  let asked: AbortController | undefined;
  let timer: number | undefined;
  const problem = make("p", { class: "note bad", role: "alert", hidden: "" });
  const empty = make("p", { class: "empty dim" }, "No field is plotted. Add one here, or by its button among the values.");
  const list = make("div", { class: "plots" });

  const unitOf = (source: Source): string =>
    series.get(`${source.message}.${source.entity}`)?.fields.find((field) => field.name === source.field)?.unit ?? heard.get(written(source))?.unit ?? "";
  const periodUs = (source: Source): number =>
    (heard.get(written(source))?.period_s ?? series.get(`${source.message}.${source.entity}`)?.period_s ?? 10) * 1e6;
  const drawn = ({ lines, beside }: Plot): Line[] => [...lines, ...beside.map(({ line }) => line)];
  const all = (): Source[] => plots.flatMap(({ lines }) => lines.map(({ source }) => source));
  const choices = (): Choice[] => {
    const found = new Map<string, Choice>();
    const put = (source: Source, unit: string): void => {
      found.set(written(source), { source, label: `${source.message} ${entity(source.entity)} ${source.field}`, unit: shownUnit(unit).unit });
    };
    for (const [key, { unit }] of heard) {
      const source = parsed(key);
      if (source) put(source, unit);
    }
    for (const one of series.values()) {
      for (const field of one.fields) {
        if (!["text", "raw", "nested"].includes(field.kind)) put({ message: one.message, entity: one.entity, field: field.name }, field.unit);
      }
    }
    return [...found.values()].sort((one, other) => one.label.localeCompare(other.label));
  };

  const ask = (): void => {
    window.clearTimeout(timer);
    timer = window.setTimeout(() => void fetchAll(), SETTLE_MS);
  };
  const fetchAll = async (): Promise<void> => {
    asked?.abort();
    const mine = new AbortController();
    asked = mine;
    const { fromUs, toUs } = ends(range, nowUs || Date.now() * 1_000);
    const pixels = Math.max(100, Math.min(2_000, Math.round(list.clientWidth || 800)));
    let told = "";
    await Promise.all(
      plots.flatMap(drawn).map(async (line) => {
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
    setAttribute(problem, "hidden", told ? null : "");
    setText(problem, told);
    draw(nowUs);
    window.clearTimeout(timer);
    if (isLive(range)) timer = window.setTimeout(() => void fetchAll(), AGAIN_MS);
  };

  const label = (source: Source): string => `${entity(source.entity)} ${source.field}`.trim();
  /** Alone, a vessel's lines have a colour each; of several, each vessel has one. */
  const looks = ({ lines, beside }: Plot): LineLook[] => {
    const colours = readPalette().series.length;
    if (!companions.length) return lines.map(({ source }, index) => ({ label: label(source), colour: index, dashes: Math.floor(index / colours), removable: true }));
    return [
      ...lines.map(({ source }, index) => ({ label: label(source), colour: 0, dashes: index, removable: true })),
      ...beside.map(({ line, like, companion }) => ({ label: `${companion.name} ${companion.labels.get(line.source.entity) ?? line.source.entity} ${line.source.field}`, colour: companions.indexOf(companion) + 1, dashes: lines.indexOf(like), removable: false })),
    ];
  };
  const rebuild = (plot: Plot): void => {
    const before = new Map(plot.beside.map(({ line }) => [`${line.vessel} ${written(line.source)}`, line]));
    plot.beside = plot.lines.flatMap((like) =>
      companions.flatMap((companion) => {
        const source = likewise(like.source, entity(like.source.entity), companion.series, companion.labels);
        const line = source && (before.get(`${companion.address} ${written(source)}`) ?? new Line(source, companion.address));
        return line ? [{ line, like, companion }] : [];
      }),
    );
    plot.chart?.dispose();
    plot.chart = undefined;
    if (!plot.lines.length) return;
    const source = plot.lines[0]?.source;
    if (!source) return;
    const { unit } = shownUnit(unitOf(source));
    plot.csv = make("span", { class: "buttons" });
    plot.chart = createChart(`${source.message}${unit ? `, ${unit}` : ""}`, unit, looks(plot), {
      ...handlers,
      cursor(us) {
        for (const { chart } of plots) if (chart !== plot.chart) chart?.cursor(us);
        handlers.cursor(us);
      },
      remove(index) {
        plot.lines.splice(index, 1);
        rebuild(plot);
        plots = plots.filter(({ lines }) => lines.length);
        changed();
      },
    }, plot.csv);
    const next = plots[plots.indexOf(plot) + 1]?.chart?.root ?? null;
    list.insertBefore(plot.chart.root, next);
  };
  const changed = (): void => {
    setAttribute(empty, "hidden", plots.length ? "" : null);
    handlers.changed(all());
    ask();
  };
  const add = (source: Source): void => {
    if (all().some((one) => written(one) === written(source))) return;
    if (all().length >= LINES) {
      setAttribute(problem, "hidden", null);
      setText(problem, `${LINES} fields are plotted, which is the most. Remove one first.`);
      return;
    }
    const key = `${source.message}/${unitOf(source)}`;
    let plot = plots.find((one) => one.key === key);
    if (!plot) {
      plot = { key, lines: [], beside: [], chart: undefined, csv: make("span") };
      plots.push(plot);
    }
    plot.lines.push(new Line(source, vessel));
    rebuild(plot);
    changed();
  };

  const draw = (now: number): void => {
    nowUs = now;
    const { fromUs, toUs } = ends(range, nowUs);
    for (const plot of plots) {
      const { chart, lines, beside, csv } = plot;
      if (!chart) continue;
      const told = looks(plot);
      const like = [...lines, ...beside.map(({ like }) => like)].map(({ source }) => source);
      chart.update(
        drawn(plot).map((line, index) => {
          const source = like[index] ?? line.source;
          const period = periodUs(source);
          return {
            label: told[index]?.label ?? "",
            table: line.table(shownUnit(unitOf(source)).factor, GAP_PERIODS * period),
            freshS: isLive(range) ? freshForS({ period_s: period / 1e6 }) : undefined,
          };
        }),
        fromUs,
        toUs,
        gaps,
      );
      if (!researcher) continue;
      const links = exports(vessel, lines.map(({ source }) => source), fromUs, toUs);
      for (const companion of companions) {
        const theirs = beside.filter((one) => one.companion === companion).map(({ line }) => line.source);
        links.push(...exports(companion.address, theirs, fromUs, toUs).map(({ name, href }) => ({ name: `${companion.name} ${name}`, href })));
      }
      while (csv.children.length > links.length) csv.lastElementChild?.remove();
      links.forEach(({ name, href }, index) => {
        const link = csv.children[index] ?? csv.appendChild(make("a", { class: "button", download: "" }));
        const text = links.length > 1 ? `CSV ${index + 1}` : "CSV";
        setText(link, text);
        setAttribute(link, "href", href);
        // What is read aloud begins with what is seen.
        setAttribute(link, "aria-label", `${links.length > 1 ? `${text}: ` : ""}Download CSV of ${name} as shown`);
      });
    }
  };

  const repaint = (): void => plots.forEach(rebuild);
  new MutationObserver(repaint).observe(document.documentElement, { attributeFilter: ["data-palette"] });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", repaint);
  root.append(createChooser(choices, add), problem, empty, list);
  let waiting = first.split(",").map(parsed).filter((source) => source !== undefined);

  return {
    range(next) {
      range = next;
      ask();
    },
    live(values) {
      for (const update of values) {
        for (const field of update.fields) {
          if (typeof field.value !== "number") continue;
          if (update.system === vessel) heard.set(written({ message: update.abbrev, entity: update.entity, field: field.name }), { unit: field.unit, period_s: update.period_s });
        }
        for (const line of plots.flatMap(drawn)) if (line.vessel === update.system && line.source.message === update.abbrev && line.source.entity === update.entity) line.add(update);
      }
    },
    draw,
    cursor(us) {
      for (const { chart } of plots) chart?.cursor(us);
    },
    add,
    catalogue(known, declared) {
      series = new Map(known.map((one) => [`${one.message}.${one.entity}`, one]));
      gaps = declared;
      for (const source of waiting) add(source);
      waiting = [];
    },
    beside(others) {
      companions = others;
      plots.forEach(rebuild);
      ask();
    },
  };
}
