// One question to the server at a time: a new one ends the one before, and each has a time-out and a plain word of trouble.

import { signal, type Signal } from "@preact/signals";
import { getJson, reason } from "./http";

export interface Resource<T> {
  readonly value: Signal<T | undefined>;
  /** What `value` answers; another question has been asked since where that differs. */
  readonly path: Signal<string>;
  readonly trouble: Signal<string>;
  readonly busy: Signal<boolean>;
  /** Asks; the answer is undefined where a newer question ended this one or it failed. */
  ask(path: string): Promise<T | undefined>;
}

export function resource<T>(patienceMs = 20_000): Resource<T> {
  const value = signal<T | undefined>(undefined);
  const answered = signal("");
  const trouble = signal("");
  const busy = signal(false);
  let now = new AbortController();
  return {
    value,
    path: answered,
    trouble,
    busy,
    async ask(path) {
      now.abort();
      const mine = (now = new AbortController());
      busy.value = true;
      try {
        const answer = await getJson<T>(path, AbortSignal.any([mine.signal, AbortSignal.timeout(patienceMs)]));
        if (mine !== now) return undefined;
        [value.value, answered.value, trouble.value, busy.value] = [answer, path, "", false];
        return answer;
      } catch (error) {
        if (mine !== now) return undefined;
        [trouble.value, busy.value] = [reason(error), false];
        return undefined;
      }
    },
  };
}
