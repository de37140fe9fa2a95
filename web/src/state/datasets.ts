// Datasets: what somebody types, as the server takes it, and what is said of a version. Pure.

import type { DatasetContent, DatasetDraft, DatasetQuery, DatasetShare, DatasetShareRequest, DatasetState, FlagCode, ShareVisitKind } from "../api/types.gen";
import { count, t, tn } from "../words/words";
import { askedOf } from "./explore";
import type { Wrong } from "./notes";
import { picked, pickedUs, spanWrong, timeWrong } from "./takeout";

/** Licences to choose from; anything else is own words. */
export const LICENCES: readonly (readonly [string, string])[] = [
  ["CC-BY-4.0", t("CC BY 4.0: use it, and name the authors")],
  ["CC0-1.0", t("CC0 1.0: use it as you like")],
  ["CC-BY-NC-4.0", t("CC BY-NC 4.0: name the authors, and earn no money with it")],
];
/** What stands for own words in the list. */
export const OWN = "own";

/** Flags whose detections can be left out. */
export const FLAGS: readonly FlagCode[] = ["unconfirmed", "clock_not_set", "clock_lost", "clock_off", "no_place", "old_place", "lines_lost"];

/** A draft as it stands in the fields of its form. */
export interface Fields {
  readonly title: string;
  readonly description: string;
  readonly publisher: string;
  readonly authors: readonly string[];
  /** One of the list, or `own`. */
  readonly licence: string;
  readonly ownLicence: string;
  readonly embargo: string;
  readonly doi: string;
  /** Of a date picker, UTC. */
  readonly from: string;
  readonly to: string;
  readonly vessels: readonly string[];
  readonly tags: string;
  readonly projects: readonly string[];
  readonly area: string;
  readonly without: readonly FlagCode[];
}

export const EMPTY: Fields = { title: "", description: "", publisher: "", authors: [], licence: "CC-BY-4.0", ownLicence: "", embargo: "", doi: "", from: "", to: "", vessels: [], tags: "", projects: [], area: "", without: [] };

/** What the explorer's question becomes. */
export function fieldsOfSearch(search: string): Fields {
  const { from, to, vessel, tag, project, area } = askedOf(search);
  const parts = (text: string, between: RegExp): readonly string[] => text.split(between).map((one) => one.trim()).filter(Boolean);
  return { ...EMPTY, from, to, vessels: parts(vessel, /,/), tags: parts(tag, /[\s,]+/).join(", "), projects: project, area };
}

export function fieldsOf(draft: DatasetDraft): Fields {
  const { title, description, publisher, authors, licence, embargo_until, doi, query } = draft;
  const isListed = LICENCES.some(([id]) => id === licence);
  return {
    title, description, publisher, authors, doi,
    licence: isListed ? licence : OWN,
    ownLicence: isListed ? "" : licence,
    embargo: embargo_until,
    from: query.from_us === null ? "" : picked(query.from_us),
    to: query.to_us === null ? "" : picked(query.to_us),
    vessels: query.vessels.map(String),
    tags: query.tags.join(", "),
    projects: query.projects,
    area: query.area,
    without: query.without,
  };
}

/** A draft as the server takes it. A time that was not touched stays as fine as it was. */
export function draftOf(fields: Fields, before?: DatasetDraft): DatasetDraft {
  const time = (text: string, was: number | null | undefined): number | null => {
    if (!text) return null;
    return was !== null && was !== undefined && picked(was) === text ? was : pickedUs(text);
  };
  return {
    title: fields.title, description: fields.description, publisher: fields.publisher, authors: [...fields.authors],
    licence: fields.licence === OWN ? fields.ownLicence : fields.licence,
    embargo_until: fields.embargo,
    doi: fields.doi,
    query: {
      from_us: time(fields.from, before?.query.from_us),
      to_us: time(fields.to, before?.query.to_us),
      vessels: fields.vessels.map(Number),
      tags: fields.tags.split(/[\s,]+/).filter(Boolean),
      projects: [...fields.projects],
      area: fields.area.trim(),
      without: [...fields.without],
    },
  };
}

export function draftWrong({ title, licence, ownLicence, embargo, from, to }: Fields): Wrong | undefined {
  if (!title.trim()) return { field: "title", text: t("Give it a title.") };
  if (timeWrong(embargo, "day")) return { field: "embargo_until", text: timeWrong(embargo, "day") };
  if (licence === OWN && !ownLicence.trim()) return { field: "licence", text: t("Write what others may do with it.") };
  const span = spanWrong(from, to);
  if (span) return { field: `${span.field}_us`, text: span.text };
  return undefined;
}

/** The field that the server's words are about, and the words; of several fields the first. */
export function wrongOfWords(words: string): Wrong {
  const [, field = "", text = words] = /^(title|description|publisher|authors|licence|embargo_until|doi|from_us|to_us|vessels|tags|projects|area|reason|label|days|password|person|precision_m): ([^\n]*)/.exec(words) ?? [];
  return { field, text };
}

export function stateWord(state: DatasetState): string {
  if (state === "draft") return t("draft");
  return state === "published" ? t("published") : t("withdrawn");
}

/** A question in words, one for each thing that narrows it. */
export function queryWords({ from_us, to_us, vessels, tags, projects, area, without }: DatasetQuery, called: (address: number) => string, flag: (code: FlagCode) => string): readonly string[] {
  const minute = (us: number): string => `${picked(us).slice(0, 16).replace("T", " ")} UTC`;
  const corners = area.split(";").filter(Boolean).length;
  return [
    from_us === null ? "" : t("From {time}", { time: minute(from_us) }),
    to_us === null ? "" : t("Before {time}", { time: minute(to_us) }),
    vessels.length ? t("Vessels: {names}", { names: vessels.map(called).join(", ") }) : t("All vessels"),
    tags.length ? t("Tags: {names}", { names: tags.join(", ") }) : t("All tags"),
    projects.length ? t("Projects: {names}", { names: projects.join(", ") }) : "",
    corners ? tn(corners, "In an area of 1 corner", "In an area of {n} corners") : "",
    without.length ? t("Without: {names}", { names: without.map(flag).join(", ") }) : "",
  ].filter(Boolean);
}

/** The time that a version covers. */
export function timeWords({ covered: { first_us, last_us } }: DatasetContent): string {
  const minute = (us: number): string => `${picked(us).slice(0, 16).replace("T", " ")} UTC`;
  return first_us === null || last_us === null ? t("not known") : t("{from} to {to}", { from: minute(first_us), to: minute(last_us) });
}

/** The extent that it has on the chart. */
export function placeWords({ covered: { south_deg, north_deg, west_deg, east_deg } }: DatasetContent): string {
  if (south_deg === null || north_deg === null || west_deg === null || east_deg === null) return t("No place is known.");
  const lat = (deg: number): string => (deg < 0 ? t("{n}° S", { n: Math.abs(deg).toFixed(4) }) : t("{n}° N", { n: deg.toFixed(4) }));
  const lon = (deg: number): string => (deg < 0 ? t("{n}° W", { n: Math.abs(deg).toFixed(4) }) : t("{n}° E", { n: deg.toFixed(4) }));
  return t("From {south} to {north}, and from {west} to {east}.", { south: lat(south_deg), north: lat(north_deg), west: lon(west_deg), east: lon(east_deg) });
}

/** A link as it stands in the fields of its form. */
export interface ShareFields {
  readonly label: string;
  readonly days: string;
  readonly password: string;
  /** The one account that can open it. Empty: anyone with the address. */
  readonly person: string;
  readonly precision: string;
  readonly from: string;
  readonly to: string;
  readonly tags: string;
  readonly area: string;
}

export const NEW_SHARE: ShareFields = { label: "", days: "30", password: "", person: "", precision: "", from: "", to: "", tags: "", area: "" };

export function shareWrong({ label, days, from, to }: ShareFields): Wrong | undefined {
  if (!label.trim()) return { field: "label", text: t("Name the recipient.") };
  if (!/^\d+$/.test(days.trim()) || Number(days) < 1 || Number(days) > 730) return { field: "days", text: t("1 to 730 days.") };
  const span = spanWrong(from, to);
  if (span) return { field: `${span.field}_us`, text: span.text };
  return undefined;
}

export function shareAsk(fields: ShareFields, version: number): DatasetShareRequest {
  return {
    version,
    label: fields.label.trim(),
    days: Number(fields.days),
    password: fields.password,
    person: fields.person.trim() || null,
    from_us: fields.from ? pickedUs(fields.from) : null,
    to_us: fields.to ? pickedUs(fields.to) : null,
    tags: fields.tags.split(/[\s,]+/).filter(Boolean),
    area: fields.area.trim(),
    precision_m: fields.precision ? Number(fields.precision) : null,
  };
}

/** What a link leaves out, and what it asks for. */
export function shareWords({ has_password, person, from_us, to_us, tags, area, precision_m, content }: DatasetShare): string {
  return [
    tn(content.rows, "1 detection", "{n} detections").replace(/\d{4,}/, (digits) => count(Number(digits))),
    person ? t("for the account {name} alone", { name: person }) : has_password ? t("with a password") : t("without a password"),
    from_us !== null || to_us !== null ? t("a part of the time") : "",
    tags.length ? t("tags {names}", { names: tags.join(", ") }) : "",
    area ? t("a part of the area") : "",
    precision_m === null ? "" : t("places coarsened to cells of about {n} m", { n: precision_m }),
  ].filter(Boolean).join(", ");
}

export function visitWord(what: ShareVisitKind): string {
  if (what === "view") return t("looked at");
  return what === "download" ? t("downloaded") : t("wrong password");
}
