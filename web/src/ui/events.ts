// The log book and the tags that were heard, for the stretch of time that the page looks at.

import type { Detection, LiveFrame, LogBookEntry, Update } from "../api/types.gen";
import { flagReason } from "../state/flags";
import { detectionCompleted, type Part, type Stretch } from "../state/newest";
import { NOTE, NOTE_BY } from "../state/noteentries";
import { tagSeries } from "../state/tags";
import { t } from "../words/words";
import { make, setAttribute } from "./dom";
import { type EventHandlers, type EventTable, eventTable, type Kind } from "./eventtable";
import { position, receiverName, tagName, utc } from "./format";

export interface LogTable extends EventTable<LogBookEntry> {
  /** Takes a vessel's entries of a frame. */
  frame(frame: Pick<LiveFrame, "events">, vessel: number, stretch: Stretch): void;
}

export interface TagTable extends EventTable<Detection> {
  /** Takes a vessel's detections of a frame, and asks for what a frame could not bring. */
  frame(frame: Pick<LiveFrame, "now_us" | "snapshot" | "detections" | "events_missed" | "recording">, vessel: number, stretch: Stretch): void;
  /** Shows these only, until somebody wants all again. */
  only(some: readonly Detection[]): void;
}

/** Asks the history for a part of the events of a stretch. */
type Ask<T> = (query: string, signal: AbortSignal) => Promise<Part<T>>;

const SEVERITY: readonly string[] = ["info", "warning", "error", "critical", "debug"];
/** The same as people read it; files keep the words of the protocol. */
const SEVERITY_WORDS: Readonly<Record<string, string>> = { info: t("info"), warning: t("warning"), error: t("error"), critical: t("critical"), debug: t("debug"), note: t("note") };
const SHAPE: readonly string[] = ["●", "▲", "◆", "✕", "·"];
/** So many at first. */
const ENTRIES = 2_000;
const TAGS = 5_000;

/** A place that rests on a position so old is said to, s. */
const OLD_S = 2;
/** The log book in `root`, with the notes that people wrote; `write` gives the way to a new note, where somebody may write one. */
export function createLogBook(root: HTMLElement, ask: Ask<LogBookEntry>, entity: (number: number) => string, handlers: EventHandlers, write?: () => string): LogTable {
  const least = make("select", {}, ...[t("everything"), t("information and worse"), t("warnings and worse"), t("errors and worse")].map((text, index) => make("option", { value: String(index - 1) }, text)));
  least.value = "0";
  const severity = ({ kind }: LogBookEntry): string => (kind === NOTE ? "note" : (SEVERITY[kind] ?? String(kind)));
  const source = (one: LogBookEntry): string => (one.kind === NOTE ? t("note by {by}", { by: one.context.slice(NOTE_BY.length) }) : one.context || entity(one.entity));
  const kind: Kind<LogBookEntry> = {
    label: t("Log book"),
    fileLabel: "log book",
    names: [t("Time, UTC"), t("Severity"), t("From"), t("Text")],
    file: {
      columns: ["time [UTC]", "severity", "entity", "from", "text"],
      record: (one) => [exact(one.time_us), severity(one), entity(one.entity), one.context, one.text],
    },
    page: ENTRIES,
    ask,
    key: (one) => `${one.time_us}/${one.entity}/${entity(one.entity)}/${one.kind}/${one.context}/${one.text}`,
    merged: (before) => before,
    cells: (one) => [utc(one.time_us), `${one.kind === NOTE ? "✎" : (SHAPE[one.kind] ?? "?")} ${SEVERITY_WORDS[severity(one)] ?? severity(one)}`, source(one), one.text],
    marks: (one) => (SEVERITY[one.kind] ? { "data-severity": severity(one) } : {}),
    // What people wrote is for people, however little of the rest they want.
    wanted: (one) => one.kind === NOTE || (one.kind === 4 ? -1 : one.kind) >= Number(least.value),
    note: (shown, all, cut) => `${cut} ${shown ? "" : all ? cut ? t("No entry of this severity among them.") : t("No entry of this severity in this time.") : t("The log book has no entry in this time.")}`.trim(),
    changed: () => undefined,
  };
  const table = eventTable(root, kind, handlers, make("label", { class: "inline" }, `${t("Show")} `, least), ...(write ? [noteLink(write)] : []));
  least.addEventListener("change", table.draw);
  return {
    ...table,
    frame({ events }, vessel, stretch) {
      const mine = events.filter((one) => one.system === vessel && one.abbrev === "LogBookEntry").map(written);
      if (mine.length) table.live(mine, stretch);
    },
  };
}

/** Leads to the form with what is known at the moment it is pressed. */
function noteLink(write: () => string): HTMLElement {
  const link = make("a", { class: "button", href: write() }, t("Write a note"));
  for (const event of ["pointerdown", "focus", "click"]) link.addEventListener(event, () => setAttribute(link, "href", write()));
  return link;
}

/** An entry of the log book, as it comes by itself. */
function written({ entity, time_us, fields }: Update): LogBookEntry {
  const of = new Map(fields.map((field) => [field.name, field]));
  const [at, kind] = [of.get("htime")?.value, of.get("type")];
  return {
    entity,
    time_us,
    written_us: typeof at === "number" ? Math.round(at * 1e6) : null,
    kind: Number(kind?.value),
    kind_name: kind?.meaning ?? null,
    context: String(of.get("context")?.value ?? ""),
    text: String(of.get("text")?.value ?? ""),
  };
}

export interface TagNeeds {
  /** Whether the legend shows it. */
  shows(one: Detection): boolean;
  /** Told of all that are in hand. */
  changed(known: Part<Detection>): void;
}

/** Tags heard in `root`; `file` is the address of the file of a stretch. */
export function createDetections(root: HTMLElement, ask: Ask<Detection>, file: (stretch: Stretch) => string, handlers: EventHandlers, { shows, changed }: TagNeeds): TagTable {
  const whole = make("button", { type: "button", hidden: "" }, t("Show all tags"));
  let chosen: ReadonlySet<string> | undefined;
  const key = (one: Detection): string => one.id;
  const kind: Kind<Detection> = {
    label: t("Tags heard"),
    fileLabel: "tags heard",
    names: [t("Heard (UTC)"), t("Tag"), t("Sensor (count)"), t("SNR (dB)"), "kHz", t("Receiver"), t("Place of the vessel"), t("Check")],
    file,
    page: TAGS,
    ask,
    key,
    merged: detectionCompleted,
    cells: (one) => [
      one.heard_us === null ? t("{time}, time of arrival: the receiver's clock is not set or was lost", { time: utc(one.time_us) }) : utc(one.heard_us),
      tagName(one),
      String(one.data ?? ""),
      String(one.snr_db ?? ""),
      String(one.frequency_khz ?? ""),
      receiverName(one),
      placeOf(one),
      one.flags?.map((flag) => flagReason(flag)).join(" ") ?? t("not known"),
    ],
    marks: () => ({}),
    tag: (one) => String(tagSeries(one.tag_id)),
    wanted: (one) => (!chosen || chosen.has(key(one))) && shows(one),
    note(shown, all, cut) {
      if (chosen) return `${t("{shown} of {all} detections: those at the chosen place on the map.", { shown, all })} ${cut}`.trim();
      if (!all) return `${cut} ${t("No tag was heard in this time.")}`.trim();
      return `${shown < all ? t("{shown} of {all} detections; the legend on the map hides the others.", { shown, all }) : ""} ${cut}`.trim();
    },
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
  /** When the server spoke last, by its clock. */
  let spokeUs: number | undefined;
  /** Whether the history lacked something then. */
  let behind = false;
  return {
    ...table,
    frame({ now_us, snapshot, detections, events_missed, recording }, vessel, stretch) {
      const mine = detections.filter((one) => one.system === vessel);
      if (mine.length) table.live(mine, stretch);
      if (spokeUs !== undefined && (snapshot || events_missed)) table.missed(spokeUs, stretch);
      if (behind && recording === null) table.missed(0, stretch);
      [spokeUs, behind] = [now_us, recording !== null];
    },
    only(some) {
      chosen = new Set(some.map(key));
      draw();
    },
  };
}

/** Where the vessel was, and how old that was where it was old. */
function placeOf({ lat_deg, lon_deg, pose_age_s }: Detection): string {
  if (lat_deg === null || lon_deg === null) return t("not known");
  const old = pose_age_s !== null && pose_age_s >= OLD_S ? `, ${t("{seconds} s from a measured one", { seconds: pose_age_s.toFixed(0) })}` : "";
  return `${position({ lat_deg, lon_deg })}${old}`;
}

/** A time to the microsecond, as the server's exports write it. */
function exact(us: number): string {
  return `${new Date(us / 1_000).toISOString().slice(0, 20)}${String(us % 1e6).padStart(6, "0")}Z`;
}
