// The log book and the tags that were heard, for the stretch of time that the page looks at.

import type { Detection, LogBookEntry } from "../api/types.gen";
import type { Part } from "../state/newest";
import { make, setAttribute } from "./dom";
import { type EventHandlers, type EventTable, eventTable, type Kind } from "./eventtable";
import { position, tagName, utc } from "./format";

export interface TagTable extends EventTable<Detection> {
  /** Shows these only, until somebody wants all again. */
  only(some: readonly Detection[]): void;
}

/** Asks the history for a part of the events of a stretch. */
type Ask<T> = (query: string, signal: AbortSignal) => Promise<Part<T>>;

const SEVERITY: readonly string[] = ["info", "warning", "error", "critical", "debug"];
const SHAPE: readonly string[] = ["●", "▲", "◆", "✕", "·"];
/** So many at first. */
const ENTRIES = 2_000;
const TAGS = 5_000;

/** The log book in `root`. */
export function createLogBook(root: HTMLElement, ask: Ask<LogBookEntry>, entity: (number: number) => string, handlers: EventHandlers): EventTable<LogBookEntry> {
  const least = make("select", {}, ...["everything", "information and worse", "warnings and worse", "errors and worse"].map((text, index) => make("option", { value: String(index - 1) }, text)));
  least.value = "0";
  const severity = ({ kind }: LogBookEntry): string => SEVERITY[kind] ?? String(kind);
  const kind: Kind<LogBookEntry> = {
    label: "Log book",
    names: ["Time, UTC", "Severity", "From", "Text"],
    columns: ["time [UTC]", "severity", "entity", "from", "text"],
    page: ENTRIES,
    ask,
    key: (one) => `${one.time_us}/${one.entity}/${entity(one.entity)}/${one.kind}/${one.context}/${one.text}`,
    cells: (one) => [utc(one.time_us), `${SHAPE[one.kind] ?? "?"} ${severity(one)}`, one.context || entity(one.entity), one.text],
    record: (one) => [exact(one.time_us), severity(one), entity(one.entity), one.context, one.text],
    marks: (one) => (SEVERITY[one.kind] ? { "data-severity": severity(one) } : {}),
    wanted: (one) => (one.kind === 4 ? -1 : one.kind) >= Number(least.value),
    chosen: () => false,
    note: (shown, all, cut) => `${cut} ${shown ? "" : all ? `Nothing so serious ${cut ? "among them" : "in this time"}.` : "The log book has no entry in this time."}`.trim(),
    changed: () => undefined,
  };
  const table = eventTable(root, kind, handlers, make("label", { class: "inline" }, "Show ", least));
  least.addEventListener("change", table.draw);
  return table;
}

/** Tags heard in `root`; `changed` is told of all that are in hand. */
export function createDetections(root: HTMLElement, ask: Ask<Detection>, handlers: EventHandlers, changed: (known: Part<Detection>) => void): TagTable {
  const whole = make("button", { type: "button", hidden: "" }, "Show all tags");
  let chosen: ReadonlySet<string> | undefined;
  const key = (one: Detection): string => `${one.time_us}/${one.entity}/${one.tag_id}/${one.heard_us}`;
  const kind: Kind<Detection> = {
    label: "Tags heard",
    names: ["Time, UTC", "Tag", "Data", "SNR, dB", "kHz", "Receiver", "Place of the vessel"],
    columns: ["reported [UTC]", "heard [UTC]", "tag", "data", "snr [dB]", "frequency [kHz]", "receiver", "lat [°]", "lon [°]"],
    page: TAGS,
    ask,
    key,
    cells: (one) => [
      utc(one.heard_us),
      tagName(one),
      String(one.data),
      String(one.snr_db),
      String(one.frequency_khz),
      String(one.serial_no),
      one.lat_deg === null || one.lon_deg === null ? "not known" : position({ lat_deg: one.lat_deg, lon_deg: one.lon_deg }),
    ],
    record: (one) => [exact(one.time_us), exact(one.heard_us), tagName(one), one.data, one.snr_db, one.frequency_khz, one.serial_no, one.lat_deg, one.lon_deg],
    marks: () => ({}),
    tag: (one) => String(one.tag_id % 4),
    wanted: (one) => !chosen || chosen.has(key(one)),
    chosen: () => chosen !== undefined,
    note: (shown, all, cut) => `${chosen ? `${shown} of ${all} tags: those at the place on the map. ${cut}` : cut || (all ? "" : "No tag was heard in this time.")}`.trim(),
    changed,
  };
  const table = eventTable(root, kind, handlers, whole);
  const draw = (): void => {
    setAttribute(whole, "hidden", chosen ? null : "");
    table.draw();
  };
  whole.addEventListener("click", () => {
    chosen = undefined;
    draw();
  });
  return {
    ...table,
    only(some) {
      chosen = new Set(some.map(key));
      draw();
    },
  };
}

/** A time to the microsecond, as the server's exports write it. */
function exact(us: number): string {
  return `${new Date(us / 1_000).toISOString().slice(0, 20)}${String(us % 1e6).padStart(6, "0")}Z`;
}
