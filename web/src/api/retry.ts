// Sending something until it is answered: for what the server takes once however often it comes, by a key.

import { postJson, Refusal } from "./http";

/** Between two tries, ms; the last one is kept. */
const PAUSES_MS = [1_000, 2_000, 4_000, 8_000, 15_000] as const;
/** What a server or what stands before it says while it cannot, for now. */
const FOR_NOW: readonly number[] = [502, 503, 504];

/** Whether the same may go better later: nobody answered, or the server cannot for now. */
export function mayPass(error: unknown): boolean {
  return !(error instanceof Refusal) || FOR_NOW.includes(error.status);
}

/** How long to wait after so many tries, ms. */
export function pauseMs(tries: number): number {
  return PAUSES_MS[Math.min(tries, PAUSES_MS.length) - 1] ?? PAUSES_MS[0];
}

/**
 * Sends `body` until it is answered or `within_ms` are over; `waits` is told before each further try. The browser ends a pause
 * early when it has a network again. The path is made for each try.
 */
export async function postUntilAnswered<T>(path: () => string, patienceMs: number, withinMs: number, body: unknown, waits: (tries: number) => void): Promise<T> {
  const began = performance.now();
  for (let tries = 1; ; tries++) {
    try {
      return await postJson<T>(path(), patienceMs, body);
    } catch (error) {
      if (!mayPass(error) || performance.now() - began + pauseMs(tries) > withinMs) throw error;
      waits(tries);
      await pause(pauseMs(tries));
    }
  }
}

function pause(ms: number): Promise<void> {
  return new Promise((done) => {
    const end = (): void => {
      window.clearTimeout(timer);
      window.removeEventListener("online", end);
      done();
    };
    const timer = window.setTimeout(end, ms);
    window.addEventListener("online", end);
  });
}
