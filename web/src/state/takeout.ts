// What somebody takes away from the history: the question in the address of a file. Pure.

import type { RecordedDay } from "../api/types.gen";
import { t } from "../words/words";

/** Ways to take data away, from the most wanted. */
export const KINDS = [
  ["positions", t("Positions, one a second"), t("Where each vessel was, its heading and speed over ground: true_lat_deg and true_lon_deg. CSV or Parquet.")],
  ["detections", t("Detections"), t("Each tag that was heard: time by the receiver's own clock in milliseconds, tag, receiver, place of the vessel. CSV.")],
  ["log", t("Everything, as a log"), t("All packets byte for byte as they came: IMC LSF, for Neptus and other readers of logs.")],
  ["messages", t("Messages of one kind"), t("Any IMC message with all its fields. CSV or Parquet.")],
] as const;

export type Kind = (typeof KINDS)[number][0];

export interface Wanted {
  readonly kind: Kind;
  /** Abbreviation of the message, where messages are wanted. */
  readonly message: string;
  /** Address; empty for all. */
  readonly vessel: string;
  /** As typed or picked, UTC; empty for an open end. */
  readonly from: string;
  readonly to: string;
  readonly angles: "deg" | "rad";
  /** Seconds from row to row; empty for every row. */
  readonly every_s: string;
  /** The form of a file of rows. */
  readonly form: "csv" | "parquet";
  readonly gzip: boolean;
}

/** What stands in the position file. */
const POSITION_FIELDS = "true_lat_deg,true_lon_deg,psi,vx,vy,alt";

/** The last moment that the server knows, µs since 1970. */
const LAST_US = 9_007_199_254_740_991;

/** A time as it is typed or picked, which is UTC here, µs since 1970; NaN for what is none. Seconds may be left out. */
export function pickedUs(text: string): number {
  const [, day, time, fraction = ""] = /^(\d{4}-\d\d-\d\d)[T ](\d\d:\d\d(?::\d\d(?:\.(\d{1,6}))?)?)Z?$/i.exec(text.trim()) ?? [];
  // Browsers read milliseconds at most; what is finer is added.
  const ms = Date.parse(`${day}T${time?.replace(/\..*/, "")}Z`);
  // There is no 30 February, which some browsers take for 2 March.
  return day && Number.isFinite(ms) && new Date(ms).toISOString().startsWith(day) ? ms * 1_000 + Number(fraction.padEnd(6, "0")) : NaN;
}

/** As a time stands in a field. */
export function picked(us: number): string {
  return new Date(us / 1_000).toISOString().slice(0, 19).replace("T", " ");
}

/** Whether a text is a time, or a day, as fields take it. */
export function isTime(text: string, kind: "day" | "time" = "time"): boolean {
  return Number.isFinite(pickedUs(kind === "day" ? `${text.trim()} 00:00` : text));
}

/** What is said of a field of a time that is none; empty where it is one, or empty. */
export function timeWrong(text: string, kind: "day" | "time" = "time"): string {
  if (!text || isTime(text, kind)) return "";
  return kind === "day" ? t("Not a valid day. Write it like 2026-06-01.") : t("Not a valid time. Write it like 2026-06-01 12:00, in UTC.");
}

/** What is wrong with a span, of which either end may be open, and at which end. */
export function spanWrong(from: string, to: string): { readonly field: "from" | "to"; readonly text: string } | undefined {
  for (const [field, text] of [["from", timeWrong(from)], ["to", timeWrong(to)]] as const) if (text) return { field, text };
  return from && to && pickedUs(to) <= pickedUs(from) ? { field: "to", text: t("The end is not after the beginning.") } : undefined;
}

/** For the address of a file; with a fraction of a second where one was typed. */
function instant(text: string): string {
  const us = pickedUs(text);
  if (!Number.isFinite(us)) return text;
  const rest = ((us % 1e6) + 1e6) % 1e6;
  return `${picked(us - rest).replace(" ", "T")}${rest ? `.${String(rest).padStart(6, "0")}` : ""}Z`;
}

/** The questions of a file in the form of CSV, without its way. */
function csvQuery(wanted: Wanted): URLSearchParams {
  const query = new URLSearchParams({ message: wanted.kind === "positions" ? "EstimatedState" : wanted.message.trim() });
  if (wanted.kind === "positions") query.set("field", POSITION_FIELDS);
  const every = wanted.kind === "positions" ? wanted.every_s || "1" : wanted.every_s;
  if (every) query.set("every_s", every);
  query.set("angles", wanted.angles);
  return query;
}

/** Whether a file has rows that are there in several forms. */
export function hasRows(kind: Kind): boolean {
  return kind === "positions" || kind === "messages";
}

/** Whether the file can be packed by gzip: Parquet is packed within. */
export function canPack({ kind, form }: Pick<Wanted, "kind" | "form">): boolean {
  return !hasRows(kind) || form === "csv";
}

function spanned(query: URLSearchParams, { from, to, vessel, gzip }: Wanted): URLSearchParams {
  if (from) query.set("from", instant(from));
  if (to) query.set("to", instant(to));
  if (vessel) query.set("vessel", vessel);
  if (gzip) query.set("gzip", "true");
  return query;
}

/** The address of the file. */
export function fileOf(wanted: Wanted): string {
  if (wanted.kind === "detections") {
    const query = new URLSearchParams({ from_us: String(wanted.from ? pickedUs(wanted.from) : 0), to_us: String(wanted.to ? pickedUs(wanted.to) : LAST_US) });
    if (wanted.vessel) query.set("vessel", wanted.vessel);
    if (wanted.gzip) query.set("gzip", "true");
    return `/api/v1/detections.csv?${query}`;
  }
  if (wanted.kind === "log") return `/api/v1/export.lsf?${spanned(new URLSearchParams(), wanted)}`;
  return `/api/v1/export.${wanted.form}?${spanned(csvQuery(wanted), { ...wanted, gzip: wanted.gzip && canPack(wanted) })}`;
}

/** Where its size is asked for; empty where the list of days tells it. */
export function sizeOf(wanted: Wanted): string {
  if (!hasRows(wanted.kind)) return "";
  return `/api/v1/export/size?${spanned(csvQuery(wanted), { ...wanted, gzip: false })}`;
}

/** Most bytes that a log of this has: of the days with packets of this time. */
export function logBytes(days: readonly RecordedDay[], { vessel, from, to }: Wanted): number {
  const [fromUs, toUs] = [from ? pickedUs(from) : -Infinity, to ? pickedUs(to) : Infinity];
  const within = days.filter((day) => (!vessel || String(day.system) === vessel) && day.last_us >= fromUs && day.first_us < toUs);
  return within.reduce((sum, { bytes }) => sum + bytes, 0);
}

/** What is wrong, and at which field: before anything is asked. */
export function wrongOf({ kind, message, from, to, every_s }: Wanted): { readonly field: string; readonly text: string } | undefined {
  if (kind === "messages" && !message.trim()) return { field: "message", text: t("Name a message, like EstimatedState.") };
  const span = spanWrong(from, to);
  if (span) return span;
  if (every_s && !(Number(every_s) >= 0.001 && Number(every_s) <= 86_400)) return { field: "every_s", text: t("From 0.001 to 86400 seconds.") };
  return undefined;
}

/** The field that the server's words are about, and the words. */
export function fieldOf(words: string): { readonly field: string; readonly text: string } {
  const [, field = "", text = words] = /^(message|vessel|from|to|every_s): (.*)$/s.exec(words) ?? [];
  return { field, text };
}

/** Bytes as people say them. */
export function bytesText(bytes: number): string {
  const units = ["B", "kB", "MB", "GB", "TB"];
  const at = Math.min(units.length - 1, Math.max(0, Math.floor(Math.log10(Math.max(1, bytes)) / 3)));
  const value = bytes / 1_000 ** at;
  return `${at === 0 || value >= 100 ? value.toFixed(0) : value.toPrecision(2)} ${units[at]}`;
}
