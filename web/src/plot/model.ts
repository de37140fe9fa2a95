// What plots are made of: sources, the stretch of time, and lines joined from history and what is live. Pure.

import type { Buckets, Series, Update } from "../api/types.gen";
import { shownAs } from "../state/units";

/** A field of a message of an entity. */
export interface Source {
  readonly message: string;
  readonly entity: number;
  readonly field: string;
}

/** Another vessel whose fields are drawn beside the page's own. */
export interface Companion {
  readonly address: number;
  readonly name: string;
  readonly series: readonly Series[];
  /** What its entities are called. */
  readonly labels: ReadonlyMap<number, string>;
}

/** The stretch of time that the page looks at, µs since 1970 UTC; without an end it follows the present. */
export type Range = { readonly spanUs: number } | { readonly fromUs: number; readonly toUs: number };

export const SHORTEST_US = 1_000_000;
/** Live values that are kept until the history is asked again. */
const TAIL = 4_000;

export function isLive(range: Range): range is { readonly spanUs: number } {
  return "spanUs" in range;
}

/** Its ends, given the present. */
export function ends(range: Range, nowUs: number): { fromUs: number; toUs: number } {
  return isLive(range) ? { fromUs: nowUs - range.spanUs, toUs: nowUs } : range;
}

/** Moves by a part of its length; what reaches the present follows it again. */
export function panned(range: Range, part: number, nowUs: number): Range {
  const { fromUs, toUs } = ends(range, nowUs);
  const by = (toUs - fromUs) * part;
  return between(fromUs + by, toUs + by, nowUs);
}

/** Lengthens or shortens it about its middle, or, live, about its end. */
export function zoomed(range: Range, factor: number, nowUs: number): Range {
  if (isLive(range)) return { spanUs: Math.max(SHORTEST_US, range.spanUs * factor) };
  const middle = (range.fromUs + range.toUs) / 2;
  const half = Math.max(SHORTEST_US / 2, ((range.toUs - range.fromUs) * factor) / 2);
  return between(middle - half, middle + half, nowUs);
}

function between(fromUs: number, toUs: number, nowUs: number): Range {
  if (toUs > nowUs && fromUs < nowUs) return { spanUs: toUs - fromUs };
  return { fromUs: Math.round(Math.max(0, fromUs)), toUs: Math.round(toUs) };
}

/** How a source stands in an address: `EstimatedState.6.u`. */
export function written(source: Source): string {
  return `${source.message}.${source.entity}.${source.field}`;
}

export function parsed(text: string): Source | undefined {
  const [message, entity, field] = text.split(".");
  if (!message || !field || !/^\d{1,3}$/.test(entity ?? "")) return undefined;
  return { message, entity: Number(entity), field };
}

/** The same field of another vessel: of the part that is called the same, has the same number, or said it most often. */
export function likewise(source: Source, label: string, series: readonly Series[], labels: ReadonlyMap<number, string>): Source | undefined {
  const { message, field } = source;
  const said = series.filter((one) => one.message === message && one.fields.some(({ name }) => name === field));
  const often = [...said].sort((one, other) => other.count - one.count);
  const found = said.find((one) => label !== "" && labels.get(one.entity) === label) ?? said.find((one) => one.entity === source.entity) ?? often[0];
  return found && { message, entity: found.entity, field };
}

/** The unit that is shown, and by what to multiply. */
export function shownUnit(unit: string): { unit: string; factor: number } {
  // Fields of messages are components of speeds as often as speeds: they keep the unit that files and catalogue have.
  return unit === "m/s" ? { unit, factor: 1 } : shownAs(unit);
}

/** A table for uPlot: seconds, then greatest, least and mean values. */
export type Table = [number[], (number | null)[], (number | null)[], (number | null)[]];

/** A line: what the history answered, and live values that are newer. */
export class Line {
  private buckets: Buckets | undefined;
  private toUs = 0;
  private tail: { us: number; value: number }[] = [];

  constructor(
    readonly source: Source,
    /** Whose. */
    readonly vessel: number,
  ) {}

  /** What the history answered for the time before `toUs`. */
  recorded(buckets: Buckets, toUs: number): void {
    this.buckets = buckets;
    this.toUs = toUs;
    const last = buckets.start_us.at(-1);
    const known = last === undefined ? -Infinity : last + (buckets.count.at(-1) === 1 ? 0 : buckets.width_us);
    this.tail = this.tail.filter(({ us }) => us > known);
  }

  /** A live value. */
  add(update: Update): void {
    const value = update.fields.find((field) => field.name === this.source.field)?.value;
    if (typeof value !== "number" || update.time_us <= (this.tail.at(-1)?.us ?? -Infinity)) return;
    if (this.buckets && update.time_us <= (this.buckets.first_us.at(-1) ?? 0)) return;
    this.tail.push({ us: update.time_us, value });
    if (this.tail.length > TAIL) this.tail = this.tail.filter((_, index) => index % 2 === 0);
  }

  /** Up to when the history was asked. */
  get askedUs(): number {
    return this.toUs;
  }

  /** The points; where nothing was said for longer than `gapUs` the line is broken. */
  table(factor: number, gapUs: number): Table {
    const table: Table = [[], [], [], []];
    let before = Infinity;
    const put = (us: number, max: number, min: number, mean: number | null, apart: number): void => {
      if (us - before > Math.max(gapUs, apart)) push(table, (before + us) / 2, null, null, null);
      push(table, us, max * factor, min * factor, mean === null ? null : mean * factor);
      before = us;
    };
    const { buckets } = this;
    buckets?.start_us.forEach((start, at) => {
      const [first = start, max = 0, min = 0] = [buckets.first_us[at], buckets.max[at], buckets.min[at]];
      const us = buckets.count[at] === 1 ? first : Math.max(first, start + buckets.width_us / 2);
      put(us, max, min, buckets.mean[at] ?? null, 2.5 * buckets.width_us);
    });
    for (const { us, value } of this.tail) put(us, value, value, value, 2.5 * (buckets?.width_us ?? 0));
    return table;
  }
}

function push(table: Table, us: number, max: number | null, min: number | null, mean: number | null): void {
  table[0].push(us / 1e6);
  table[1].push(max);
  table[2].push(min);
  table[3].push(mean);
}

/** Where the exports of what is shown are: together they hold these fields of these entities and nothing else. */
export function exports(vessel: number, sources: readonly Source[], fromUs: number, toUs: number): { name: string; href: string }[] {
  const fields = new Map<string, { message: string; entity: number; fields: string[] }>();
  for (const { message, entity, field } of sources) {
    const key = `${message}.${entity}`;
    const one = fields.get(key) ?? { message, entity, fields: [] };
    one.fields.push(field);
    fields.set(key, one);
  }
  // Entities of which the same fields are shown go into one file.
  const files = new Map<string, { message: string; fields: string; entities: number[] }>();
  for (const { message, entity, fields: names } of fields.values()) {
    const list = names.sort().join(",");
    const file = files.get(`${message}/${list}`) ?? { message, fields: list, entities: [] };
    file.entities.push(entity);
    files.set(`${message}/${list}`, file);
  }
  return [...files.values()].map(({ message, fields: list, entities }) => {
    const query = new URLSearchParams({
      message,
      vessel: String(vessel),
      entity: entities.join(","),
      field: list,
      from: new Date(Math.floor(fromUs / 1_000)).toISOString(),
      to: new Date(Math.ceil(toUs / 1_000)).toISOString(),
      angles: "deg",
    });
    return { name: `${message} ${list.replaceAll(",", ", ")}`, href: `/api/v1/export.csv?${query}` };
  });
}
