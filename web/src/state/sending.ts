// What is on its way to the server: its key, and what is said while nobody answers. Pure.

import { t, tn } from "../words/words";

/**
 * Keys of what is sent. What is sent again as it was has the key of before, so that the server takes it once; what was changed
 * meanwhile, and what comes after an answer, has another.
 */
export class Keys<T> {
  private last: { readonly draft: string; readonly key: string } | undefined;

  constructor(private readonly make: () => string) {}

  of(draft: T): string {
    const text = JSON.stringify(draft);
    if (this.last?.draft !== text) this.last = { draft: text, key: this.make() };
    return this.last.key;
  }

  answered(): void {
    this.last = undefined;
  }
}

/** What a form says after so many tries that nobody answered. */
export function sendingText(tries: number): string {
  return tries ? tn(tries, "No answer yet. Trying again; what you wrote is kept here …", "No answer after {n} tries. Trying again; what you wrote is kept here …") : t("Sending …");
}
