// In which order systems are listed: pure.

import type { Alarm, Liveness, RouteLeg, System } from "../api/types.gen";
import { systemName } from "../ui/format";
import { t } from "../words/words";
import { PRIORITIES } from "./alarms";
import type { EntityReading, Vitals } from "./vitals";

export type Order = "name" | "worst" | "heard" | "battery" | "mode" | "plan";

export const ORDERS: readonly (readonly [Order, string])[] = [
  ["name", t("name")],
  ["worst", t("worst state first")],
  ["heard", t("longest silence first")],
  ["battery", t("lowest battery first")],
  ["mode", t("mode")],
  ["plan", t("plan")],
];
const LIVENESS: readonly Liveness[] = ["lost", "stale", "late", "live"];
const STATES = ["FAILURE", "ERROR", "FAULT", "BOOT", "NORMAL"];

/** A system and what is known of how it does. */
export interface Listed {
  readonly system: System;
  /** Whether its place is no longer reported. */
  readonly placeIsOld: boolean;
  /** How long ago its place came, s; null where none was heard here. */
  readonly placeS: number | null;
  readonly vitals: Vitals;
  /** The part of it in the worst state; undefined where no part has said. */
  readonly worst: EntityReading | undefined;
  /** How all its parts are, and whether somebody should look. */
  readonly parts: { readonly text: string; readonly bad: boolean };
  /** The most urgent alarm that is told of it; undefined for none. */
  readonly alarm: Alarm | undefined;
  /** The maneuvers of the plan that it sails; undefined where they are not known. */
  readonly legs: readonly RouteLeg[] | undefined;
  /** Whether people gave it its name. */
  readonly ours: boolean;
}

/** A vessel that has a name and that nobody has heard since the server started. */
export function unheard(address: number, name: string): System {
  return { address, name, kind: null, liveness: "lost", heard_us: 0, transports: [], fix: null, entities: {} };
}

/** Sorted; what is not known comes after what is, and equal ones go by name. */
export function inOrder(all: readonly Listed[], order: Order): Listed[] {
  const rank = (known: readonly string[], one: string): number => (known.includes(one) ? known.indexOf(one) : known.length);
  const compare = (one: Listed, other: Listed): number => {
    const by = (value: (of: Listed) => number): number => value(one) - value(other);
    const words = (value: (of: Listed) => string): number => (value(one) === "" ? 1 : 0) - (value(other) === "" ? 1 : 0) || value(one).localeCompare(value(other));
    switch (order) {
      case "name":
        return 0;
      case "worst":
        return by(({ alarm }) => rank(PRIORITIES, alarm?.priority ?? "")) || by(({ worst }) => rank(STATES, worst?.state ?? ""));
      case "heard":
        // Those that are live have been heard within a second or two: who was first in it changes all the time.
        return by(({ system }) => LIVENESS.indexOf(system.liveness)) || by(({ system }) => (system.liveness === "lost" ? system.heard_us : 0));
      case "battery":
        return by(({ vitals }) => vitals.battery.value ?? Infinity) || 0;
      case "mode":
        return words(({ vitals }) => vitals.mode.word);
      case "plan":
        return words(({ vitals }) => vitals.plan.note);
    }
  };
  return [...all].sort((one, other) => compare(one, other) || systemName(one.system).localeCompare(systemName(other.system)));
}
