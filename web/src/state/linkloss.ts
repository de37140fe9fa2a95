// What a vessel will do without the link, by the words of its own supervisor for lost communications.

import type { Update } from "../api/types.gen";
import { placeCameUs } from "./fleet";
import { type PartValues, partValues } from "./partvalues";
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

export function linkLoss(values: Values, labels: Labels): LinkLoss {
  const found = [...labels].find(([, label]) => /lost ?comm/i.test(label));
  const placeUs = placeCameUs(values);
  if (!found) return { ...UNKNOWN, placeUs };
  const [number, entity] = found;
  const state = [...values.values()].find((one) => one.abbrev === "EntityState" && one.entity === number);
  if (!state) return { ...UNKNOWN, entity, placeUs };
  const words = said(state);
  return { entity, words, saidUs: state.received_us, dueUs: due(partValues(values, number)), lost: meaning(state, "state") !== "NORMAL", placeUs };
}

function said(state: Update): string {
  const value = state.fields.find((field) => field.name === "description")?.value;
  return typeof value === "string" ? value : "";
}

/** When it acts next, by the vessel's clock. */
function due(said: PartValues | undefined): number | null {
  const due_s = said?.values.get("due_s");
  return said && due_s ? said.timeUs + Number(due_s) * 1e6 : null;
}
