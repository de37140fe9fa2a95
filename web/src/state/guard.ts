// The guard of the sea chart aboard, as the vessel tells of it. Pure.

import { partValues } from "./partvalues";
import { entities, type Labels, type Values } from "./vitals";

/** What the vessel's grounding supervisor says; undefined where it says nothing or has no chart. */
export interface Guard {
  readonly text: string;
  /** It lets no thrust through in some direction. */
  readonly blocks: boolean;
  /** An operator had it lifted for a while. */
  readonly lifted: boolean;
}

export const GUARD_ENTITY = "Grounding Supervisor";

export function guardOf(values: Values, labels: Labels, nowUs: number): Guard | undefined {
  const one = entities(values, labels, nowUs).find(({ label }) => label === GUARD_ENTITY);
  const said = one && partValues(values, one.entity)?.values;
  if (!one || one.old || !one.description || said?.get("on") !== "1") return undefined;
  return { text: one.description, blocks: said.get("blocks") === "1", lifted: said.has("unguarded_s") };
}
