// Missions: what somebody types, as the server takes it, and the ways to what belongs to one. Pure.

import type { Mission, MissionRequest, Missions } from "../api/types.gen";
import { t } from "../words/words";
import { toldAgain } from "./newest";
import type { Wrong } from "./notes";
import { fileOf, type Kind, picked, pickedUs, spanWrong } from "./takeout";

/** A mission as it stands in the fields of its form. */
export interface MissionDraft {
  readonly name: string;
  readonly people: string;
  readonly purpose: string;
  readonly notes: string;
  readonly vessels: readonly number[];
  /** Of a date picker, UTC. */
  readonly from: string;
  /** The same; empty while it goes on. */
  readonly to: string;
}

/** A mission that begins now (ms since 1970). */
export function newDraft(nowMs: number): MissionDraft {
  return { name: "", people: "", purpose: "", notes: "", vessels: [], from: `${picked(nowMs * 1_000).slice(0, 16)}:00`, to: "" };
}

export function missionWrong({ name, vessels, from, to }: MissionDraft): Wrong | undefined {
  if (!name.trim()) return { field: "name", text: t("Give it a name.") };
  if (!vessels.length) return { field: "vessels", text: t("Choose a vessel.") };
  if (!from) return { field: "from_us", text: t("Enter when it begins.") };
  const span = spanWrong(from, to);
  if (span) return { field: `${span.field}_us`, text: span.text };
  return undefined;
}

/** A draft without anything wrong, as the server takes it. */
export function missionAsk({ name, people, purpose, notes, vessels, from, to }: MissionDraft): MissionRequest {
  return { name: name.trim(), people: people.trim(), purpose: purpose.trim(), notes: notes.trim(), vessels: [...vessels], from_us: pickedUs(from), to_us: to ? pickedUs(to) : null };
}

export function missionDraft({ name, people, purpose, notes, vessels, from_us, to_us }: MissionRequest): MissionDraft {
  return { name, people, purpose, notes, vessels, from: picked(from_us), to: to_us === null ? "" : picked(to_us) };
}

/** The vessel's page over the time of the mission, with the other vessels beside. */
export function replayOf({ vessels, from_us }: Pick<MissionRequest, "vessels" | "from_us">, vessel: number, toUs: number): string {
  const others = vessels.filter((one) => one !== vessel);
  const beside = others.length ? `&with=${others.join(",")}` : "";
  return `/vessels/${vessel}?tab=Plots&from=${from_us}&to=${Math.max(toUs, from_us + 1_000_000)}${beside}`;
}

/** A file of the mission's vessels and time, in whole seconds around it. */
export function missionFile(kind: Kind, { vessels, from_us }: Pick<MissionRequest, "vessels" | "from_us">, toUs: number): string {
  return fileOf({ kind, message: "", vessel: vessels.join(","), from: picked(from_us), to: picked(toUs + 999_999), angles: "deg", every_s: "", form: "csv", gzip: false });
}

/** The address of a vessel's track during a mission: for chart plotters, or NetCDF. */
export function trackFile(vessel: number, fromUs: number, toUs: number, ending: "gpx" | "nc"): string {
  return `/api/v1/vessels/${vessel}/track.${ending}?from_us=${fromUs}&to_us=${toUs}`;
}

/** The question for the notes of a mission: on its vessels and on none, of its time. */
export function notesOf({ vessels, from_us }: Pick<MissionRequest, "vessels" | "from_us">, toUs: number): string {
  return `vessel=${vessels.join(",")}&general=true&from_us=${from_us}&to_us=${toUs}`;
}

/** The newest missions as they are told again, and of those that were known the older ones. */
export function withNewestMissions(before: readonly Mission[], { missions, next }: Missions): readonly Mission[] {
  return toldAgain(before, missions, next !== null, ({ mission }) => mission.from_us);
}

/** Hours and minutes. */
export function hoursText(seconds: number): string {
  const minutes = Math.round(seconds / 60);
  return minutes < 60 ? `${minutes} min` : `${Math.floor(minutes / 60)} h ${minutes % 60} min`;
}
