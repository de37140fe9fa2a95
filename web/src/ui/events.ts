// The log book and the tags that were heard, for the stretch of time that the page looks at.

import type { Detection, LogBookEntry } from "../api/types.gen";
import { make, setAttribute, setText } from "./dom";
import { position, utc } from "./format";

export interface EventTable<T> {
  /** `more`: whether there are more than these. */
  update(all: readonly T[], more: boolean): void;
  /** In place of the table: what went wrong. */
  failed(text: string): void;
}

const SEVERITY: readonly string[] = ["info", "warning", "error", "critical", "debug"];
const SHAPE: readonly string[] = ["●", "▲", "◆", "✕", "·"];

/** The log book in `root`; `at` is told the time of the entry that is pointed to. */
export function createLogBook(root: HTMLElement, entity: (number: number) => string, at: (us: number | null) => void): EventTable<LogBookEntry> {
  const least = make("select", {}, ...["everything", "information and worse", "warnings and worse", "errors and worse"].map((text, index) => make("option", { value: String(index - 1) }, text)));
  least.value = "0";
  const table = eventTable(root, "Log book", ["Time, UTC", "Severity", "From", "Text"], at, make("label", { class: "inline" }, "Show ", least));
  let last: readonly LogBookEntry[] = [];
  let more = false;
  const draw = (): void => {
    const shown = last.filter(({ kind }) => (kind === 4 ? -1 : kind) >= Number(least.value));
    table.fill(
      [...shown].reverse().map((entry) => ({
        us: entry.time_us,
        cells: [utc(entry.time_us), `${SHAPE[entry.kind] ?? "?"} ${SEVERITY[entry.kind] ?? entry.kind}`, entry.context || entity(entry.entity), entry.text],
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
  };
}

/** Tags heard in `root`. */
export function createDetections(root: HTMLElement, at: (us: number | null) => void): EventTable<Detection> {
  const table = eventTable(root, "Tags heard", ["Time, UTC", "Tag", "Data", "SNR, dB", "kHz", "Receiver", "Place of the vessel"], at);
  return {
    update(all, more) {
      table.fill(
        [...all].reverse().map((one) => ({
          us: one.time_us,
          cells: [
            utc(one.heard_us),
            `${one.protocol_name ?? one.protocol}-${one.tag_id}`,
            String(one.data),
            String(one.snr_db),
            String(one.frequency_khz),
            String(one.serial_no),
            one.lat_deg === null || one.lon_deg === null ? "not known" : position({ lat_deg: one.lat_deg, lon_deg: one.lon_deg }),
          ],
          severity: "",
        })),
        more ? `The first ${all.length} of this time; choose a shorter one for the rest.` : all.length ? "" : "No tag was heard in this time.",
      );
    },
    failed: table.failed,
  };
}

interface Shown {
  readonly us: number;
  readonly cells: readonly string[];
  readonly severity: string;
}

function eventTable(root: HTMLElement, label: string, names: readonly string[], at: (us: number | null) => void, ...extra: readonly HTMLElement[]) {
  const note = make("p", { class: "dim", role: "status" });
  const head = make("tr");
  for (const name of names) head.append(make("th", { scope: "col" }, name));
  const body = make("tbody");
  const box = make("div", { class: "wide scroll", tabindex: "0", role: "region", "aria-label": label }, make("table", { class: "compact" }, make("thead", {}, head), body));
  root.append(make("div", { class: "row" }, ...extra, note), box);
  const point = (event: Event): void => {
    const row = event.target instanceof Element ? event.target.closest("tr[data-us]") : null;
    at(row ? Number(row.getAttribute("data-us")) : null);
  };
  body.addEventListener("pointerover", point);
  body.addEventListener("focusin", point);
  box.addEventListener("pointerleave", () => at(null));
  body.addEventListener("focusout", () => at(null));
  let drawn = "";
  return {
    fill(rows: readonly Shown[], text: string): void {
      setText(note, text);
      setAttribute(box, "hidden", rows.length ? null : "");
      const now = rows.map(({ cells }) => cells.join("\t")).join("\n");
      if (now === drawn) return;
      drawn = now;
      body.replaceChildren(
        ...rows.map(({ us, cells, severity }) => {
          const row = make("tr", { "data-us": String(us), ...(severity ? { "data-severity": severity } : {}) });
          cells.forEach((text, index) => row.append(make("td", index === 0 ? { class: "num" } : {}, index === 0 ? make("button", { type: "button", class: "plain" }, text) : text)));
          return row;
        }),
      );
    },
    failed(text: string): void {
      setText(note, text);
    },
  };
}
