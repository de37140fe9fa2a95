// What a part of a vessel says for programs, beside the words of its entity state: names and values in an Event. Pure.

import type { Values } from "./vitals";

/** The topic of such an Event; see `crates/onboard/src/states.rs`. */
const TOPIC = "EntityStateValues";

export interface PartValues {
  /** By the vessel's clock, µs since 1970 UTC. */
  readonly timeUs: number;
  readonly values: ReadonlyMap<string, string>;
}

/** The newest that an entity said; undefined where it says nothing in this way, like parts of other vessels than Lutra's. */
export function partValues(values: Values, entity: number): PartValues | undefined {
  let newest: PartValues | undefined;
  for (const one of values.values()) {
    if (one.abbrev !== "Event" || one.entity !== entity || one.fields.find(({ name }) => name === "topic")?.value !== TOPIC) continue;
    const data = one.fields.find(({ name }) => name === "data")?.value;
    if (typeof data !== "string" || (newest && newest.timeUs > one.time_us)) continue;
    newest = { timeUs: one.time_us, values: new Map(data.split(";").map((pair) => [pair.slice(0, Math.max(0, pair.indexOf("="))), pair.slice(pair.indexOf("=") + 1)])) };
  }
  return newest;
}
