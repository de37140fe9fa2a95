// Asks the history how the vessel was, one question at a time: of the times wanted meanwhile only the last is asked.

import { getJson, reason } from "../api/http";
import type { At } from "../api/types.gen";
import { t } from "../words/words";

/** Between two questions at least, ms. */
const APART_MS = 150;
/** After a failure, ms. */
const AGAIN_MS = 2_000;

export interface Asker {
  /** The time that is wanted; null for none. */
  want(us: number | null): void;
  /** The last answer; undefined before it, and when nothing is wanted. */
  known(): At | undefined;
  /** What went wrong with the last question; empty when nothing did. */
  trouble(): string;
}

/** `told` is called after every answer. */
export function createAsker(vessel: number, told: () => void): Asker {
  let wanted: number | null = null;
  let at: At | undefined;
  let trouble = "";
  let busy = false;
  const ask = async (us: number): Promise<void> => {
    busy = true;
    let wait = APART_MS;
    try {
      const answer = await getJson<At>(`/api/v1/vessels/${vessel}/at?time_us=${us}`);
      trouble = answer.cut ? t("There are more series than are shown.") : "";
      if (wanted !== null) at = answer;
    } catch (error) {
      trouble = reason(error);
      at = undefined;
      wait = AGAIN_MS;
    }
    if (wanted !== null) told();
    window.setTimeout(() => {
      busy = false;
      if (wanted !== null && (wanted !== us || !at)) void ask(wanted);
    }, wait);
  };
  return {
    want(us) {
      wanted = us === null ? null : Math.round(us);
      if (wanted === null) {
        at = undefined;
        trouble = "";
      } else if (!busy && wanted !== at?.time_us) void ask(wanted);
    },
    known: () => at,
    trouble: () => trouble,
  };
}
