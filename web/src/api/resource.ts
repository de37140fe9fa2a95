// One question to the server at a time: a new one ends the one before, and each has a time-out and a plain word of trouble.

import { signal, type Signal } from "@preact/signals";
import { getJson, reason, Refusal } from "./http";

export interface Resource<T> {
  readonly value: Signal<T | undefined>;
  /** What `value` answers; another question has been asked since where that differs. */
  readonly path: Signal<string>;
  readonly trouble: Signal<string>;
  readonly busy: Signal<boolean>;
  /** After so long the server may be asked again, as it had no room for the last question, ms; 0 where it did not say so. */
  readonly againMs: Signal<number>;
  /** Asks; the answer is undefined where a newer question ended this one or it failed. */
  ask(path: string): Promise<T | undefined>;
}

export function resource<T>(patienceMs = 20_000): Resource<T> {
  const value = signal<T | undefined>(undefined);
  const answered = signal("");
  const trouble = signal("");
  const busy = signal(false);
  const againMs = signal(0);
  let now = new AbortController();
  return {
    value,
    path: answered,
    trouble,
    busy,
    againMs,
    async ask(path) {
      now.abort();
      const mine = (now = new AbortController());
      busy.value = true;
      try {
        const answer = await getJson<T>(path, AbortSignal.any([mine.signal, AbortSignal.timeout(patienceMs)]));
        if (mine !== now) return undefined;
        [value.value, answered.value, trouble.value, againMs.value, busy.value] = [answer, path, "", 0, false];
        return answer;
      } catch (error) {
        if (mine !== now) return undefined;
        againMs.value = error instanceof Refusal && error.status === 503 ? error.waitS * 1_000 : 0;
        [trouble.value, busy.value] = [reason(error), false];
        return undefined;
      }
    },
  };
}
