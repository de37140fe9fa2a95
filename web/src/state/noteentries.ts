// Notes of people among the entries of a vessel's own log book. Pure, and apart from the form's part, which a vessel's page does
// not load.

import type { LogBookEntry, LogNote, LogNotes } from "../api/types.gen";
import type { Part } from "./newest";

/** The way to the form with vessel, time (µs since 1970 UTC; null for now) and place filled in. */
export function wayToWrite(vessel: number, at: number | null, place: { readonly lat_deg: number; readonly lon_deg: number } | null): string {
  const query = new URLSearchParams({ write: "1", about: String(vessel) });
  if (at !== null) query.set("at", String(Math.round(at)));
  if (place) {
    query.set("lat", place.lat_deg.toFixed(6));
    query.set("lon", place.lon_deg.toFixed(6));
  }
  return `/logbook?${query}`;
}

/** The kind of what people wrote, among the entries of a vessel's own log book. */
export const NOTE = -1;
/** Stands before the author's name in a note's context; files keep it. */
export const NOTE_BY = "note by ";
/** The entity of nobody. */
const NOBODY = 255;

/** A note as an entry of a vessel's log book. */
export function asEntry({ time_us, written_us, by, text }: LogNote): LogBookEntry {
  return { entity: NOBODY, time_us, written_us, kind: NOTE, kind_name: "note", context: `${NOTE_BY}${by}`, text };
}

/**
 * A part of a vessel's log book with the notes of the same time. `ask` gets a page of notes of the question of the part,
 * which is the newest first: where older entries follow, older notes come with them.
 */
export async function withNotes(part: Part<LogBookEntry>, vessel: number, query: string, ask: (question: string) => Promise<LogNotes>): Promise<Part<LogBookEntry>> {
  const wanted = new URLSearchParams(query);
  const last = part.next ? part.items.at(-1) : undefined;
  const span = new URLSearchParams({ vessel: String(vessel), from_us: String(last?.time_us ?? wanted.get("from_us") ?? 0), to_us: wanted.get("to_us") ?? "", limit: "500" });
  const notes: LogNote[] = [];
  for (let before: string | null = ""; before !== null; ) {
    const page: LogNotes = await ask(`${span}${before && `&before=${before}`}`);
    notes.push(...page.notes);
    before = page.next;
  }
  if (!notes.length) return part;
  const items = [...part.items, ...notes.map(asEntry)].sort((one, other) => other.time_us - one.time_us);
  return { items, next: part.next };
}
