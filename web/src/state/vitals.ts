// What an operator looks at first, read from the latest values. A reading is old when it is over its contract: three
// of its usual intervals.

import type { Detection, Field, Update } from "../api/types.gen";
import { t, tn } from "../words/words";
import { ageS, freshForS } from "./fleet";

export type Values = ReadonlyMap<string, Update>;
export type Labels = ReadonlyMap<number, string>;

/** One thing that is read off. */
export interface Reading {
  /** Null where nothing was ever said. */
  readonly value: number | null;
  /** What stands for it where it is no plain number. */
  readonly word: string;
  /** More about it. */
  readonly note: string;
  readonly ageS: number | null;
  readonly old: boolean;
}

/** The messages that a vessel is shown by where several are: what {@link vitals}, {@link entities} and its place are read from. */
export const GLANCE: readonly string[] = ["EstimatedState", "GpsFix", "Announce", "VehicleState", "PlanControlState", "FuelLevel", "EntityState"];

const NEVER: Reading = { value: null, word: "", note: "", ageS: null, old: true };

export interface Vitals {
  readonly speed_mps: Reading;
  readonly course_rad: Reading;
  readonly heading_rad: Reading;
  readonly port_rpm: Reading;
  readonly starboard_rpm: Reading;
  /** Charge, %. */
  readonly battery: Reading;
  /** Least voltage of the batteries. */
  readonly voltage: Reading;
  readonly mode: Reading;
  readonly plan: Reading;
  /** Of the plan, %. */
  readonly progress: Reading;
  /** Of the last tag that was heard, dB. */
  readonly snr: Reading;
}

/** Below this a course says nothing, m/s. */
const MOVING_MPS = 0.05;

export function vitals(values: Values, labels: Labels, nowUs: number): Vitals {
  const all = [...values.values()];
  const of = (abbrev: string): Update[] => all.filter((update) => update.abbrev === abbrev);
  const label = (update: Update): string => labels.get(update.entity) ?? "";
  const named = (abbrev: string, name: RegExp): Update | undefined => newest(of(abbrev).filter((update) => name.test(label(update))));
  const read = (update: Update | undefined, value: number | null, word = "", note = ""): Reading => {
    if (!update) return NEVER;
    const age = ageS(update, nowUs);
    return { value, word, note, ageS: age, old: age > freshForS(update) };
  };

  const state = newest(of("EstimatedState"));
  const [north, east] = [number(state, "vx"), number(state, "vy")];
  const speed = north === null || east === null ? null : Math.hypot(north, east);
  const course = north === null || east === null || speed === null || speed < MOVING_MPS ? null : Math.atan2(east, north);
  const port = named("Rpm", /port|left/i) ?? of("Rpm").find((update) => update.entity === least(of("Rpm")));
  const starboard = named("Rpm", /star|right/i) ?? newest(of("Rpm").filter((update) => update !== port));
  const fuel = named("FuelLevel", /fuel/i) ?? lowest(of("FuelLevel"));
  // A power rail of 5 V is not a battery that is flat.
  const sources = of("Voltage").filter((update) => !/\brail\b/i.test(label(update)));
  const volts = lowest(sources.filter((update) => /batt/i.test(label(update)))) ?? lowest(sources);
  const mode = newest(of("VehicleState"));
  const plan = newest(of("PlanControlState"));
  const progress = number(plan, "plan_progress");
  const tag = newest(of("TBRFishTag"));
  const errors = text(mode, "error_ents");
  return {
    speed_mps: read(state, speed),
    course_rad: read(state, course),
    heading_rad: read(state, number(state, "psi")),
    port_rpm: read(port, number(port, "value")),
    starboard_rpm: read(starboard, number(starboard, "value")),
    battery: read(fuel, number(fuel, "value")),
    voltage: read(volts, number(volts, "value"), "", volts ? label(volts) : ""),
    mode: read(mode, number(mode, "op_mode"), meaning(mode, "op_mode"), errors || text(mode, "last_error")),
    plan: read(plan, number(plan, "state"), meaning(plan, "state"), text(plan, "plan_id")),
    progress: read(plan, progress !== null && progress >= 0 ? progress : null, "", text(plan, "man_id")),
    // A tag is heard when it is near, not by a contract: its age alone tells. 0 dB: the receiver does not say it.
    snr: { ...read(tag, number(tag, "SNR") || null, "", tag ? `${meaning(tag, "trans_protocol")}-${number(tag, "trans_id") ?? "?"}` : ""), old: !tag },
  };
}

/** With the tag that was heard last, where that is newer than what TBRFishTag tells: some codings have no number there. */
export function withHeard(known: Vitals, heard: Detection | undefined, nowUs: number): Vitals {
  const old = heard ? Math.max(0, (nowUs - heard.time_us) / 1e6) : Infinity;
  if (!heard || old > (known.snr.ageS ?? Infinity)) return known;
  const note = `${heard.protocol_name ?? heard.protocol ?? "?"}-${heard.tag_id}`;
  return { ...known, snr: { value: heard.snr_db, word: "", note, ageS: old, old: false } };
}

/** How an entity is, by its EntityState. */
export interface EntityReading {
  readonly entity: number;
  readonly label: string;
  readonly state: string;
  readonly description: string;
  readonly ageS: number | null;
  readonly old: boolean;
}

/** What is not normal, in words. */
export const STATE_WORDS: Readonly<Record<string, string>> = { BOOT: t("starting"), FAULT: t("fault"), ERROR: t("error"), FAILURE: t("failure") };
/** States from good to bad; the vessel's worst is the worst of its parts. */
const RANKS = ["NORMAL", "BOOT", "FAULT", "ERROR", "FAILURE"];

/** All entities by number, also those that never said how they are. */
export function entities(values: Values, labels: Labels, nowUs: number): EntityReading[] {
  const states = new Map<number, Update>();
  const numbers = new Set(labels.keys());
  for (const update of values.values()) {
    if (update.entity !== 255) numbers.add(update.entity);
    if (update.abbrev === "EntityState") states.set(update.entity, update);
  }
  return [...numbers].sort((one, other) => one - other).map((entity) => {
    const update = states.get(entity);
    const age = update ? ageS(update, nowUs) : null;
    return {
      entity,
      label: labels.get(entity) ?? "",
      state: update ? meaning(update, "state") : "",
      description: text(update, "description"),
      ageS: age,
      old: !update || (age ?? Infinity) > freshForS(update),
    };
  });
}

/** The worst state of a vessel's parts and which part has it; undefined while no part has said. */
export function worst(all: readonly EntityReading[]): EntityReading | undefined {
  let found: EntityReading | undefined;
  for (const one of all) {
    if (one.state && (!found || RANKS.indexOf(one.state) > RANKS.indexOf(found.state))) found = one;
  }
  return found;
}

/** How a vessel's parts are, in words; `bad` where somebody should look. A part that fell silent is not normal. */
export function partsInWords(all: readonly EntityReading[]): { text: string; bad: boolean } {
  const spoke = all.filter(({ state }) => state);
  const found = worst(spoke);
  if (!found) return { text: t("state of its parts unknown"), bad: false };
  const silent = spoke.filter(({ old }) => old);
  const called = ({ label, entity }: EntityReading): string => label || t("entity {entity}", { entity });
  const names = silent.slice(0, 2).map(called).join(", ") + (silent.length > 2 ? ` ${t("and {n} more", { n: silent.length - 2 })}` : "");
  const some = silent.length > 0 && silent.length < spoke.length ? t("{n} of {all} parts silent: {names}", { n: silent.length, all: spoke.length, names }) : "";
  if (found.state !== "NORMAL") {
    const said = `${called(found)}: ${[STATE_WORDS[found.state] ?? found.state, found.description].filter(Boolean).join(", ")}${found.old ? ` ${t("(old)")}` : ""}`;
    return { text: [said, some].filter(Boolean).join(" · "), bad: true };
  }
  if (some) return { text: some, bad: true };
  return silent.length ? { text: tn(spoke.length, "its only part is silent, normal before (old)", "all {n} parts silent, normal before (old)"), bad: false } : { text: t("all parts normal"), bad: false };
}

function newest(updates: readonly Update[]): Update | undefined {
  return updates.reduce<Update | undefined>((last, one) => (!last || one.received_us > last.received_us ? one : last), undefined);
}

function lowest(updates: readonly Update[]): Update | undefined {
  const known = updates.filter((update) => number(update, "value") !== null);
  return known.reduce<Update | undefined>((low, one) => (!low || (number(one, "value") ?? 0) < (number(low, "value") ?? 0) ? one : low), undefined);
}

function least(updates: readonly Update[]): number {
  return Math.min(...updates.map((update) => update.entity));
}

function find(update: Update | undefined, name: string): Field | undefined {
  return update?.fields.find((field) => field.name === name);
}

function number(update: Update | undefined, name: string): number | null {
  const value = find(update, name)?.value;
  return typeof value === "number" ? value : null;
}

function text(update: Update | undefined, name: string): string {
  const value = find(update, name)?.value;
  return typeof value === "string" ? value : "";
}

/** The word for a number, or the number where nobody has one. */
export function meaning(update: Update | undefined, name: string): string {
  const field = find(update, name);
  return field ? (field.meaning ?? String(field.value)) : "";
}
