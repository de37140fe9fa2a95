// STOP of all vessels in two steps: pure.

import type { System } from "../api/types.gen";

/** So long the second step is offered, ms. */
export const OFFERED_MS = 5_000;
/** A press so soon after the first is the same one, which bounced, ms. */
const BOUNCE_MS = 350;

/** What a press does: `ask` for the second step, nothing, or `stop`. `askedMs`: when the first step was, if it stands. */
export function press(askedMs: number | undefined, nowMs: number): "ask" | "nothing" | "stop" {
  if (askedMs === undefined || nowMs - askedMs > OFFERED_MS) return "ask";
  return nowMs - askedMs < BOUNCE_MS ? "nothing" : "stop";
}

/** Whom it is about: all that have a name from people, heard or not, and of all others those that are heard. */
export function allToStop<S extends Pick<System, "address" | "liveness">>(vessels: readonly S[], given: Readonly<Record<string, string>>): S[] {
  return vessels.filter(({ address, liveness }) => String(address) in given || liveness === "live" || liveness === "late");
}
