// What is on its way to the server: its key, and what is said while nobody answers. Pure.

import { t, tn } from "../words/words";

/** What is on its way: its key, and when it was sent first (ms since 1970). */
export interface Sent {
  readonly key: string;
  readonly sinceMs: number;
}

/** A server takes no longer ones, ms. */
const LONGEST_WAIT_MS = 3_600_000;

/**
 * Keys of what is sent. What is sent again as it was has the key of before, so that the server takes it once; what was changed
 * meanwhile, and what comes after an answer, has another.
 */
export class Keys<T> {
  private last: (Sent & { readonly draft: string }) | undefined;

  constructor(
    private readonly make: () => string,
    private readonly nowMs: () => number = Date.now,
  ) {}

  of(draft: T): Sent {
    const text = JSON.stringify(draft);
    if (this.last?.draft !== text) this.last = { draft: text, key: this.make(), sinceMs: this.nowMs() };
    return this.last;
  }

  /** How long ago it was sent first, ms: by the clock of the day, which goes on while a phone sleeps. */
  waitedMs({ sinceMs }: Sent): number {
    return Math.min(Math.max(Math.round(this.nowMs() - sinceMs), 0), LONGEST_WAIT_MS);
  }

  answered(): void {
    this.last = undefined;
  }
}

/** What a form says after so many tries that nobody answered. */
export function sendingText(tries: number): string {
  return tries ? tn(tries, "No answer yet. Trying again; what you wrote is kept here …", "No answer after {n} tries. Trying again; what you wrote is kept here …") : t("Sending …");
}
