// What a vessel will do without the link, by the words of its own supervisor for lost communications.

import type { Update } from "../api/types.gen";
import { placeCameUs } from "./fleet";
import { type Labels, meaning, type Values } from "./vitals";

export interface LinkLoss {
  /** Label of the supervisor; null where the vessel has told of none. */
  readonly entity: string | null;
  /** What it said last; empty for nothing. */
  readonly words: string;
  /** When that came, µs since 1970 UTC. */
  readonly saidUs: number | null;
  /** When it acts next, as it said, µs since 1970 UTC; null where it named no time. */
  readonly dueUs: number | null;
  /** Whether it says that no console is heard. */
  readonly lost: boolean;
  /** When its place came last, by the server's clock like all ages, µs since 1970 UTC; null for never. */
  readonly placeUs: number | null;
}

const UNKNOWN: LinkLoss = { entity: null, words: "", saidUs: null, dueUs: null, lost: false, placeUs: null };
const DAY_US = 86_400_000_000;

export function linkLoss(values: Values, labels: Labels): LinkLoss {
  const found = [...labels].find(([, label]) => /lost ?comm/i.test(label));
  const placeUs = placeCameUs(values);
  if (!found) return { ...UNKNOWN, placeUs };
  const [number, entity] = found;
  const state = [...values.values()].find((one) => one.abbrev === "EntityState" && one.entity === number);
  if (!state) return { ...UNKNOWN, entity, placeUs };
  const words = said(state);
  return { entity, words, saidUs: state.received_us, dueUs: due(words, state.received_us), lost: meaning(state, "state") !== "NORMAL", placeUs };
}

function said(state: Update): string {
  const value = state.fields.find((field) => field.name === "description")?.value;
  return typeof value === "string" ? value : "";
}

/** The last time of day in `words`, on the day on which it comes after they were said. */
export function due(words: string, saidUs: number): number | null {
  const last = [...words.matchAll(/ at (\d\d):(\d\d):(\d\d) UTC/g)].at(-1);
  if (!last) return null;
  const [hours, minutes, seconds] = last.slice(1).map(Number) as [number, number, number];
  const at = Math.floor(saidUs / DAY_US) * DAY_US + ((hours * 60 + minutes) * 60 + seconds) * 1e6;
  // A minute of grace for the way and for clocks that differ a little.
  return at < saidUs - 60e6 ? at + DAY_US : at;
}
