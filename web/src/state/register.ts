// The register of studies: its kinds and their fields, what somebody types, as the server takes it, and whose tag was heard. Pure.

import type { Detection, RegisterEntry, RegisterKind, RegisterRecord, RegisterTag } from "../api/types.gen";
import { t, tn } from "../words/words";
import type { Wrong } from "./notes";
import { picked, pickedUs, timeWrong } from "./takeout";

/** What a field holds: `ref` the name of an entry of a kind, `vessel` an address. */
type Holds = "line" | "text" | "number" | "whole" | "time" | "sex" | "vessel" | { readonly ref: RegisterKind };

export interface Field {
  /** Its column in files; times are called `_us` in the API. */
  readonly name: string;
  readonly label: string;
  readonly holds: Holds;
  readonly needed?: boolean;
  /** Whether the list shows it. */
  readonly listed?: boolean;
}

/** A draft: each field as it stands in its input. */
export type Draft = Readonly<Record<string, string>>;

export const KINDS: readonly RegisterKind[] = ["tag", "animal", "receiver", "deployment", "project", "person"];

const PROJECT_OF: Field = { name: "project", label: t("Project"), holds: { ref: "project" }, listed: true };
const NOTES: Field = { name: "notes", label: t("Notes"), holds: "text" };
const FROM: Field = { name: "from_time", label: t("From (UTC)"), holds: "time", listed: true };

export const FIELDS: Readonly<Record<RegisterKind, readonly Field[]>> = {
  tag: [
    { name: "name", label: t("Name, empty for protocol and number"), holds: "line" },
    { name: "protocol", label: t("Protocol, such as R64K"), holds: "line", needed: true, listed: true },
    { name: "tag_id", label: t("Number"), holds: "whole", needed: true, listed: true },
    { name: "animal", label: t("Animal"), holds: { ref: "animal" }, listed: true },
    FROM,
    { name: "to_time", label: t("To (UTC)"), holds: "time", listed: true },
    PROJECT_OF,
    { name: "serial", label: t("Serial number"), holds: "line", listed: true },
    { name: "manufacturer", label: t("Manufacturer"), holds: "line" },
    { name: "model", label: t("Model"), holds: "line" },
    { name: "frequency_khz", label: t("Frequency, kHz, empty for any"), holds: "whole" },
    { name: "codespace", label: t("Code space, such as A69-1303"), holds: "line" },
    { name: "sensor_type", label: t("Sensor, such as depth"), holds: "line" },
    { name: "sensor_slope", label: t("Slope (value = slope · count + intercept)"), holds: "number" },
    { name: "sensor_intercept", label: t("Intercept"), holds: "number" },
    { name: "sensor_unit", label: t("Unit"), holds: "line" },
    { name: "interval_min_s", label: t("Least ping interval, s"), holds: "number" },
    { name: "interval_max_s", label: t("Greatest ping interval, s"), holds: "number" },
    NOTES,
  ],
  animal: [
    { name: "name", label: t("Name"), holds: "line", needed: true },
    PROJECT_OF,
    { name: "scientific_name", label: t("Scientific name"), holds: "line", listed: true },
    { name: "aphia_id", label: t("AphiaID (WoRMS)"), holds: "whole" },
    { name: "common_name", label: t("Common name"), holds: "line", listed: true },
    { name: "length_mm", label: t("Length, mm"), holds: "number", listed: true },
    { name: "length_type", label: t("Which length, such as total or fork"), holds: "line" },
    { name: "weight_g", label: t("Weight, g"), holds: "number", listed: true },
    { name: "sex", label: t("Sex"), holds: "sex" },
    { name: "life_stage", label: t("Stage of life"), holds: "line" },
    { name: "capture_time", label: t("Caught (UTC)"), holds: "time" },
    { name: "capture_place", label: t("Caught where"), holds: "line" },
    { name: "capture_lat_deg", label: t("Latitude of the catch, °"), holds: "number" },
    { name: "capture_lon_deg", label: t("Longitude of the catch, °"), holds: "number" },
    { name: "release_time", label: t("Released (UTC)"), holds: "time", listed: true },
    { name: "release_place", label: t("Released where"), holds: "line" },
    { name: "release_lat_deg", label: t("Latitude of the release, °"), holds: "number" },
    { name: "release_lon_deg", label: t("Longitude of the release, °"), holds: "number" },
    { name: "release_group", label: t("Group"), holds: "line" },
    NOTES,
  ],
  receiver: [
    { name: "name", label: t("Name, empty for model and serial number"), holds: "line" },
    { name: "serial", label: t("Serial number"), holds: "whole", needed: true, listed: true },
    { name: "model", label: t("Model"), holds: "line", listed: true },
    { name: "manufacturer", label: t("Manufacturer"), holds: "line", listed: true },
    NOTES,
  ],
  deployment: [
    { name: "name", label: t("Name, empty for receiver and begin"), holds: "line" },
    { name: "receiver", label: t("Receiver"), holds: { ref: "receiver" }, needed: true, listed: true },
    { name: "vessel", label: t("Vessel"), holds: "vessel", needed: true, listed: true },
    { ...FROM, needed: true },
    { name: "to_time", label: t("To (UTC), empty while it goes on"), holds: "time", listed: true },
    { name: "depth_m", label: t("Depth of the hydrophone, m"), holds: "number", listed: true },
    { name: "lat_deg", label: t("Latitude of a fixed station, °"), holds: "number" },
    { name: "lon_deg", label: t("Longitude of a fixed station, °"), holds: "number" },
    PROJECT_OF,
    NOTES,
  ],
  project: [
    { name: "name", label: t("Short name"), holds: "line", needed: true },
    { name: "title", label: t("Title"), holds: "line", listed: true },
    { name: "principal_investigator", label: t("Led by"), holds: { ref: "person" }, listed: true },
    { name: "contact", label: t("Contact"), holds: { ref: "person" }, listed: true },
    { name: "citation", label: t("How to cite it"), holds: "line" },
    { name: "licence", label: t("Licence of the data, such as CC-BY-4.0"), holds: "line" },
    NOTES,
  ],
  person: [
    { name: "name", label: t("Name"), holds: "line", needed: true },
    { name: "affiliation", label: t("Affiliation"), holds: "line", listed: true },
    { name: "orcid", label: t("ORCID, such as 0000-0002-1825-0097"), holds: "line", listed: true },
    NOTES,
  ],
};

/** What a kind is called, in the plural. */
export function kindsWord(kind: RegisterKind): string {
  switch (kind) {
    case "tag": return t("Tags");
    case "animal": return t("Animals");
    case "receiver": return t("Receivers");
    case "deployment": return t("Deployments");
    case "project": return t("Projects");
    case "person": return t("People");
  }
}

/** What the button says by which one is added. */
export function addWord(kind: RegisterKind): string {
  switch (kind) {
    case "tag": return t("Add a tag");
    case "animal": return t("Add an animal");
    case "receiver": return t("Add a receiver");
    case "deployment": return t("Add a deployment");
    case "project": return t("Add a project");
    case "person": return t("Add a person");
  }
}

/** What to do where there is none yet. */
export function emptyWord(kind: RegisterKind, may: boolean): string {
  if (!may) return t("Nothing is registered here yet. Researchers of all vessels register tags, animals and receivers.");
  switch (kind) {
    case "tag": return t("No tags yet. Add one, or import a table: detections then carry its name, its animal and the unit of its sensor.");
    case "animal": return t("No animals yet. Add one, or import a table; then choose it at its tag.");
    case "receiver": return t("No receivers yet. Add each hydrophone by the serial number in its lines; then say on which vessel it is, under Deployments.");
    case "deployment": return t("No deployments yet. Add the receiver first, then say from when to when it is on which vessel.");
    case "project": return t("No projects yet. Add the people first, then the project that tags and animals belong to.");
    case "person": return t("No people yet. Add who leads a project or answers questions about it.");
  }
}

/** The name of a field in the API. */
function keyOf(name: string): string {
  return name.replace(/_time$/, "_us");
}

/** What an entry says in a field. */
function saidIn(record: RegisterRecord, name: string): unknown {
  return (record as unknown as Readonly<Record<string, unknown>>)[keyOf(name)];
}

export function nameOf(record: RegisterRecord): string {
  return record.name;
}

/** A field as the list shows it; vessels are called by `called`. */
export function shownOf(record: RegisterRecord, { name, holds }: Field, called: (address: number) => string): string {
  const value = saidIn(record, name);
  if (value === null || value === undefined) return "";
  if (holds === "time") return picked(Number(value));
  return holds === "vessel" ? called(Number(value)) : String(value);
}

/** An entry as it stands in the inputs of its form. */
export function draftOf(kind: RegisterKind, record?: RegisterRecord): Draft {
  const text = ({ name, holds }: Field): string => {
    const value = record && saidIn(record, name);
    if (value === null || value === undefined) return "";
    return holds === "time" ? picked(Number(value)) : String(value);
  };
  return Object.fromEntries(FIELDS[kind].map((field) => [field.name, text(field)]));
}

/** What is wrong with a draft, before it is sent; the server looks at all of it again. */
export function registerWrong(kind: RegisterKind, draft: Draft): Wrong | undefined {
  for (const { name, holds, needed } of FIELDS[kind]) {
    const text = (draft[name] ?? "").trim();
    if (needed && !text) return { field: name, text: t("This is needed.") };
    if (!text) continue;
    if (holds === "number" && !Number.isFinite(numberOf(text))) return { field: name, text: t("A number, such as 0.2.") };
    if (holds === "whole" && !/^\d+$/.test(text)) return { field: name, text: t("A whole number, such as 101.") };
    if (holds === "time" && timeWrong(text)) return { field: name, text: timeWrong(text) };
  }
  return undefined;
}

/** A number as people write it, with a point or a comma. */
function numberOf(text: string): number {
  return /^[+-]?(\d+([.,]\d*)?|[.,]\d+)(e[+-]?\d+)?$/i.test(text) ? Number(text.replace(",", ".")) : NaN;
}

/** A draft without anything wrong, as the server takes it. What a picker cuts of a time that was not touched is kept. */
export function recordOf(kind: RegisterKind, draft: Draft, before?: RegisterRecord): RegisterRecord {
  const untouched = draftOf(kind, before);
  const value = ({ name, holds }: Field): unknown => {
    const text = (draft[name] ?? "").trim();
    if (before && draft[name] === untouched[name]) return saidIn(before, name);
    switch (holds) {
      case "number": return text ? numberOf(text) : null;
      case "whole":
      case "vessel": return text ? Number(text) : null;
      case "time": return text ? pickedUs(text) : null;
      default: return text;
    }
  };
  const fields = Object.fromEntries(FIELDS[kind].map((field) => [keyOf(field.name), value(field)]));
  return { kind, ...fields } as unknown as RegisterRecord;
}

/** How many lines of a file are what. */
export function importText({ added, changed, same }: { readonly added: number; readonly changed: number; readonly same: number }): string {
  return [tn(added, "1 new.", "{n} new."), tn(changed, "1 changed.", "{n} changed."), tn(same, "1 as it is.", "{n} as they are.")].join(" ");
}

/** Formats of files of detections, by the names by which the server knows them. */
export const FORMATS: readonly (readonly [string, string])[] = [
  ["lutra", t("All columns")],
  ["vue", "VUE (Innovasea)"],
  ["fathom", "Fathom (Innovasea)"],
  ["thelma", "Thelma Biotel ComPort"],
  ["thelma-old", t("Thelma Biotel ComPort, earlier")],
  ["otn", "Ocean Tracking Network"],
  ["etn", "European Tracking Network"],
  ["glatos", "GLATOS 1.4"],
  ["actel", t("actel, detections")],
  ["actel-biometrics", t("actel, biometrics")],
  ["yaps", "yaps"],
  ["movebank", "Movebank"],
  ["darwin-core", t("Darwin Core (OBIS, GBIF), occurrences")],
  ["dwca", t("Darwin Core archive, first of each hour")],
  ["dwca-all", t("Darwin Core archive, every detection")],
  ["geojson", t("GeoJSON, for maps")],
  ["kml", t("KML, for Google Earth")],
  ["geopackage", t("GeoPackage, for maps")],
  ["parquet", t("Parquet, for programs")],
  ["netcdf", t("NetCDF (CF), for oceanographers")],
];

/** Tags by protocol and number: whose a detection is. */
export type TagNames = ReadonlyMap<string, readonly RegisterTag[]>;

function codeOf(protocol: string, id: number): string {
  return `${protocol.toUpperCase()}-${id}`;
}

export function tagNames(entries: readonly RegisterEntry[]): TagNames {
  const names = new Map<string, RegisterTag[]>();
  for (const { record } of entries) {
    if (record.kind !== "tag" || record.tag_id === null) continue;
    const code = codeOf(record.protocol, record.tag_id);
    names.set(code, [...(names.get(code) ?? []), record]);
  }
  return names;
}

/** What the register calls the tag that was heard, and its animal; nothing where it does not know it. */
export function calledBy(names: TagNames, one: Detection): string {
  const us = one.heard_us ?? one.time_us;
  const fits = (tag: RegisterTag): boolean =>
    (tag.frequency_khz === null || one.frequency_khz === null || tag.frequency_khz === one.frequency_khz) && (tag.from_us === null || tag.from_us <= us) && (tag.to_us === null || us < tag.to_us);
  const code = codeOf(one.protocol_name ?? String(one.protocol ?? ""), one.tag_id);
  const tag = names.get(code)?.find(fits);
  if (!tag) return "";
  const own = tag.name.toUpperCase() === code ? "" : tag.name;
  return [own, tag.animal].filter(Boolean).join(" · ") || tag.name;
}
