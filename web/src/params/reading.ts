// Asking a vessel to tell its parameters, and waiting until it has.

import { getJson, postJson } from "../api/http";
import type { VesselQuery, VesselQuerySent, VesselParameters } from "../api/types.gen";

const PATIENCE_MS = 8_000;
/** How often is looked whether the answers are there, ms. */
const LOOK_MS = 300;
/** How long answers are waited for, and how long once some have come, ms. */
const ANSWER_MS = 6_000;
const QUIET_MS = 1_500;
/** An answer that others asked for within this is as good as one of our own, µs. */
const ONCE_US = 2_000_000;

export interface Reading {
  readonly told: VesselParameters;
  /** Entities that were asked and said nothing. */
  readonly silent: readonly string[];
  readonly reached: boolean;
}

export interface Reader {
  /** What the server knows already. */
  known(): Promise<VesselParameters>;
  /** Asks the vessel for these entities, or for all. */
  read(entities?: readonly string[]): Promise<Reading>;
}

export function createReader(path: string): Reader {
  const known = (): Promise<VesselParameters> => getJson<VesselParameters>(`${path}/parameters`);
  const wait = (ms: number): Promise<void> => new Promise((done) => setTimeout(done, ms));
  return {
    known,
    async read(entities = []) {
      const ask: VesselQuery = { about: "parameters", entities: [...entities] };
      const began = performance.now();
      let asked = await postJson<VesselQuerySent>(`${path}/ask`, PATIENCE_MS, ask);
      // The same question goes out once in two seconds. What is read back must be asked for after it was written.
      while (entities.length && asked.packets < asked.entities.length && performance.now() - began < ANSWER_MS) {
        await wait(LOOK_MS);
        asked = await postJson<VesselQuerySent>(`${path}/ask`, PATIENCE_MS, ask);
      }
      let [told, before, changed] = [await known(), -1, performance.now()];
      const sinceUs = asked.time_us - (entities.length ? 0 : ONCE_US);
      const silent = (): string[] => asked.entities.filter((one) => !told.entities.some(({ entity, time_us }) => entity === one && time_us >= sinceUs));
      if (!asked.reached) return { told, silent: silent(), reached: false };
      const end = performance.now() + ANSWER_MS;
      while (silent().length && performance.now() < end) {
        if (silent().length !== before) [before, changed] = [silent().length, performance.now()];
        // Not every part of a vessel answers.
        if (before < asked.entities.length && performance.now() - changed > QUIET_MS) break;
        await wait(LOOK_MS);
        told = await known();
      }
      return { told, silent: silent(), reached: asked.reached };
    },
  };
}
