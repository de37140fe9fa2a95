// The log book and the tags that were heard, for the stretch of time that the page looks at.

import type { Detection, LogBookEntry } from "../api/types.gen";
import { csv, save } from "./csv";
import { make, setAttribute, setText } from "./dom";
import { position, tagName, utc } from "./format";

export interface EventTable<T> {
  /** `more`: whether there are more than these. */
  update(all: readonly T[], more: boolean): void;
  /** In place of the table: what went wrong. */
  failed(text: string): void;
  /** Marks the last row at or before a time; null for none. */
  cursor(us: number | null): void;
}

export interface TagTable extends EventTable<Detection> {
  /** Shows these only, until somebody wants all again. */
  only(some: readonly Detection[]): void;
}

export interface EventHandlers {
  /** The time of the row that is pointed to; null for none. */
  at(us: number | null): void;
  /** The time of the row that is chosen. */
  pick(us: number): void;
  /** Whose tables these are, for the names of files; undefined where nothing may be taken away. */
  readonly file: (() => string) | undefined;
}

const SEVERITY: readonly string[] = ["info", "warning", "error", "critical", "debug"];
const SHAPE: readonly string[] = ["●", "▲", "◆", "✕", "·"];

/** The log book in `root`. */
export function createLogBook(root: HTMLElement, entity: (number: number) => string, handlers: EventHandlers): EventTable<LogBookEntry> {
  const least = make("select", {}, ...["everything", "information and worse", "warnings and worse", "errors and worse"].map((text, index) => make("option", { value: String(index - 1) }, text)));
  least.value = "0";
  const head = ["time [UTC]", "severity", "entity", "from", "text"];
  const table = eventTable(root, "Log book", ["Time, UTC", "Severity", "From", "Text"], head, handlers, make("label", { class: "inline" }, "Show ", least));
  let last: readonly LogBookEntry[] = [];
  let more = false;
  const draw = (): void => {
    const shown = last.filter(({ kind }) => (kind === 4 ? -1 : kind) >= Number(least.value));
    table.fill(
      [...shown].reverse().map((entry) => ({
        us: entry.time_us,
        cells: [utc(entry.time_us), `${SHAPE[entry.kind] ?? "?"} ${SEVERITY[entry.kind] ?? entry.kind}`, entry.context || entity(entry.entity), entry.text],
        record: [exact(entry.time_us), SEVERITY[entry.kind] ?? entry.kind, entity(entry.entity), entry.context, entry.text],
        severity: SEVERITY[entry.kind] ?? "",
      })),
      more ? `The first ${last.length} of this time; choose a shorter one for the rest.` : shown.length ? "" : last.length ? "Nothing so serious in this time." : "The log book has no entry in this time.",
    );
  };
  least.addEventListener("change", draw);
  return {
    update(all, rest) {
      [last, more] = [all, rest];
      draw();
    },
    failed: table.failed,
    cursor: table.cursor,
  };
}

/** Tags heard in `root`. */
export function createDetections(root: HTMLElement, handlers: EventHandlers): TagTable {
  const whole = make("button", { type: "button", hidden: "" }, "Show all tags");
  const head = ["reported [UTC]", "heard [UTC]", "tag", "data", "snr [dB]", "frequency [kHz]", "receiver", "lat [°]", "lon [°]"];
  const table = eventTable(root, "Tags heard", ["Time, UTC", "Tag", "Data", "SNR, dB", "kHz", "Receiver", "Place of the vessel"], head, handlers, whole);
  let last: readonly Detection[] = [];
  let more = false;
  let chosen: ReadonlySet<string> | undefined;
  const draw = (): void => {
    const shown = chosen ? last.filter((one) => chosen?.has(known(one))) : last;
    setAttribute(whole, "hidden", chosen ? null : "");
    const cut = more ? `The first ${last.length} of this time; choose a shorter one for the rest.` : "";
    table.fill(
      [...shown].reverse().map((one) => ({
        us: one.time_us,
        cells: [
          utc(one.heard_us),
          tagName(one),
          String(one.data),
          String(one.snr_db),
          String(one.frequency_khz),
          String(one.serial_no),
          one.lat_deg === null || one.lon_deg === null ? "not known" : position({ lat_deg: one.lat_deg, lon_deg: one.lon_deg }),
        ],
        record: [exact(one.time_us), exact(one.heard_us), tagName(one), one.data, one.snr_db, one.frequency_khz, one.serial_no, one.lat_deg, one.lon_deg],
        severity: "",
        tag: one.tag_id,
      })),
      chosen ? `${shown.length} of ${last.length} tags: those at the place on the map. ${cut}` : cut || (last.length ? "" : "No tag was heard in this time."),
    );
  };
  whole.addEventListener("click", () => {
    chosen = undefined;
    draw();
  });
  return {
    update(all, rest) {
      [last, more] = [all, rest];
      draw();
    },
    only(some) {
      chosen = new Set(some.map(known));
      draw();
    },
    failed: table.failed,
    cursor: table.cursor,
  };
}

function known(one: Detection): string {
  return `${one.time_us}/${one.entity}/${one.tag_id}/${one.heard_us}`;
}

function exact(us: number): string {
  return new Date(us / 1_000).toISOString();
}

interface Shown {
  readonly us: number;
  readonly cells: readonly string[];
  /** The same for a file. */
  readonly record: readonly (string | number | null)[];
  readonly severity: string;
  readonly tag?: number;
}

function eventTable(root: HTMLElement, label: string, names: readonly string[], columns: readonly string[], { at, pick, file }: EventHandlers, ...extra: readonly HTMLElement[]) {
  const note = make("p", { class: "dim", role: "status" });
  const take = make("button", { type: "button", hidden: "", "aria-label": `Download CSV of ${label.toLowerCase()} as shown` }, "CSV");
  const head = make("tr");
  for (const name of names) head.append(make("th", { scope: "col" }, name));
  const body = make("tbody");
  const box = make("div", { class: "wide scroll", tabindex: "0", role: "region", "aria-label": label }, make("table", { class: "compact" }, make("thead", {}, head), body));
  root.append(make("div", { class: "row" }, ...extra, take, note), box);
  const rowOf = (event: Event): HTMLElement | null => (event.target instanceof Element ? event.target.closest<HTMLElement>("tr[data-us]") : null);
  const point = (event: Event): void => {
    const row = rowOf(event);
    at(row ? Number(row.dataset["us"]) : null);
  };
  body.addEventListener("pointerover", point);
  body.addEventListener("focusin", point);
  box.addEventListener("pointerleave", () => at(null));
  body.addEventListener("focusout", () => at(null));
  body.addEventListener("click", (event) => {
    const row = rowOf(event);
    if (row) pick(Number(row.dataset["us"]));
  });
  let drawn = "";
  let shown: readonly Shown[] = [];
  let cursorUs: number | null = null;
  const mark = (): void => {
    // The newest comes first.
    const index = cursorUs === null ? -1 : shown.findIndex(({ us }) => us <= (cursorUs ?? 0));
    [...body.children].forEach((row, number) => setAttribute(row, "aria-current", number === index ? "time" : null));
  };
  take.addEventListener("click", () => {
    save(`${file?.() ?? "lutra"} ${label.toLowerCase()}.csv`.replaceAll(" ", "_"), csv(columns, shown.map(({ record }) => record)));
  });
  return {
    fill(rows: readonly Shown[], text: string): void {
      setText(note, text);
      setAttribute(box, "hidden", rows.length ? null : "");
      setAttribute(take, "hidden", file && rows.length ? null : "");
      shown = rows;
      const now = rows.map(({ cells }) => cells.join("\t")).join("\n");
      if (now !== drawn) {
        drawn = now;
        body.replaceChildren(
          ...rows.map(({ us, cells, severity, tag }) => {
            const row = make("tr", { "data-us": String(us), ...(severity ? { "data-severity": severity } : {}) });
            cells.forEach((text, index) => row.append(make("td", { ...(index === 0 ? { class: "num" } : {}), ...(index === 1 && tag !== undefined ? { "data-tag": String(tag % 4) } : {}) }, index === 0 ? make("button", { type: "button", class: "plain" }, text) : text)));
            return row;
          }),
        );
      }
      mark();
    },
    failed(text: string): void {
      setText(note, text);
    },
    cursor(us: number | null): void {
      if (us === cursorUs) return;
      cursorUs = us;
      mark();
    },
  };
}
