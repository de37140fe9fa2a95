// Notes of the log book: what somebody types, as the server takes it, and which notes are asked for. Pure.

import type { LogNote, LogNoteRequest, LogNotes } from "../api/types.gen";
import { t } from "../words/words";
import { toldAgain } from "./newest";
import { picked, pickedUs, timeWrong } from "./takeout";
import { readAngle } from "./units";

/** Letters of a note. */
export const LETTERS = 4_000;
/** Bytes of a photo as the server takes it. */
export const PHOTO_BYTES = 4 * 2 ** 20;
/** What is a photo. */
export const PHOTO_KINDS = "image/jpeg,image/png,image/webp";

/** A note as it stands in the fields of its form. */
export interface Draft {
  readonly text: string;
  /** Address; empty for none. */
  readonly vessel: string;
  /** Of a date picker, UTC; empty for now. */
  readonly time: string;
  readonly lat: string;
  readonly lon: string;
}

export const EMPTY_DRAFT: Draft = { text: "", vessel: "", time: "", lat: "", lon: "" };

/** What is wrong, at which field. */
export interface Wrong {
  readonly field: string;
  readonly text: string;
}

/** What is wrong with a draft, before it is sent. */
export function wrongOf({ text, time, lat, lon }: Draft): Wrong | undefined {
  const letters = [...text.trim()].length;
  if (!letters) return { field: "text", text: t("Write something.") };
  if (letters > LETTERS) return { field: "text", text: t("{letters} characters; at most {most}.", { letters, most: LETTERS }) };
  if (timeWrong(time)) return { field: "time_us", text: timeWrong(time) };
  if (lat && readAngle(lat, "lat") === undefined) return { field: "lat_deg", text: t("Latitude from -90° to 90°, like 63.4405 or 63° 26.43′ N.") };
  if (lon && readAngle(lon, "lon") === undefined) return { field: "lon_deg", text: t("Longitude from -180° to 180°, like 10.3521 or 10° 21.13′ E.") };
  if (lat && !lon) return { field: "lon_deg", text: t("Give the longitude too.") };
  if (lon && !lat) return { field: "lat_deg", text: t("Give the latitude too.") };
  return undefined;
}

/** A draft without anything wrong, as the server takes it. */
export function askOf({ text, vessel, time, lat, lon }: Draft): LogNoteRequest {
  return {
    text: text.trim(),
    vessel: vessel ? Number(vessel) : null,
    time_us: time ? pickedUs(time) : null,
    lat_deg: lat ? (readAngle(lat, "lat") ?? null) : null,
    lon_deg: lon ? (readAngle(lon, "lon") ?? null) : null,
  };
}

/** A note to be corrected. */
export function draftOf({ text, vessel, time_us, lat_deg, lon_deg }: LogNote): Draft {
  return { text, vessel: vessel === null ? "" : String(vessel), time: picked(time_us), lat: lat_deg === null ? "" : String(lat_deg), lon: lon_deg === null ? "" : String(lon_deg) };
}

export function isSame(one: Draft, other: Draft): boolean {
  return (Object.keys(one) as (keyof Draft)[]).every((field) => one[field] === other[field]);
}

/** A correction whose time was not touched leaves the note's own, which may be finer than a picker. */
export function correctionOf(note: LogNote, draft: Draft): LogNoteRequest {
  const ask = askOf(draft);
  return draft.time === picked(note.time_us) ? { ...ask, time_us: note.time_us } : ask;
}

/** A draft as an address has it: `/logbook?write=1&about=2068&at=…&lat=…&lon=…`. */
export function draftFrom(query: URLSearchParams): Draft {
  const at = Number(query.get("at") ?? "");
  return { text: "", vessel: query.get("about") ?? "", time: at > 0 ? picked(at) : "", lat: query.get("lat") ?? "", lon: query.get("lon") ?? "" };
}

/** Which notes are wanted, as the filter has it. */
export interface Filter {
  readonly vessel: string;
  readonly from: string;
  readonly to: string;
  readonly text: string;
  readonly withdrawn: boolean;
}

/** The question for notes. */
export function questionOf({ vessel, from, to, text, withdrawn }: Filter): URLSearchParams {
  const query = new URLSearchParams();
  if (vessel) query.set("vessel", vessel);
  if (from) query.set("from_us", String(pickedUs(from)));
  if (to) query.set("to_us", String(pickedUs(to)));
  if (text.trim()) query.set("text", text.trim());
  if (withdrawn) query.set("withdrawn", "true");
  return query;
}

/** The filter in the page's address, to come back to it and to give it to others. */
export function addressOf(filter: Filter): string {
  const query = new URLSearchParams();
  for (const name of ["vessel", "from", "to", "text"] as const) if (filter[name]) query.set(name, filter[name]);
  if (filter.withdrawn) query.set("withdrawn", "1");
  const text = query.toString();
  return text ? `?${text}` : "";
}

export function filterFrom(query: URLSearchParams): Filter {
  const of = (name: string): string => query.get(name) ?? "";
  return { vessel: of("vessel"), from: of("from"), to: of("to"), text: of("text"), withdrawn: query.has("withdrawn") };
}

/** The newest notes as they are told again, and of those that were known the older ones. */
export function withNewest(before: readonly LogNote[], { notes, next }: LogNotes): readonly LogNote[] {
  return toldAgain(before, notes, next !== null, ({ time_us }) => time_us);
}

/** Days with their notes, in the order of the notes. */
export function byDay(notes: readonly LogNote[]): readonly (readonly [string, readonly LogNote[]])[] {
  const days = new Map<string, LogNote[]>();
  for (const note of notes) {
    const day = picked(note.time_us).slice(0, 10);
    const others = days.get(day);
    if (others) others.push(note);
    else days.set(day, [note]);
  }
  return [...days];
}

/** The field that the server's words are about, which their English names, and the words without its name; "" for none of the form's. */
export function fieldOf(words: string, english = words): Wrong {
  const [, field = ""] = /^(text|vessel|time_us|lat_deg|lon_deg|photo|name|purpose|people|notes|from_us|to_us|vessels|reason|corners): /.exec(english) ?? [];
  return { field, text: field ? words.replace(/^\S+: /, "") : words };
}
