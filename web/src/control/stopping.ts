// One STOP on its way: by the live socket and by a request at once, both with one key, so that the server carries it out
// once; and again by both, until one is answered or the person gives it up.

import { postStop, reason, Refusal, STOP_WANTED_MS } from "../api/http";
import { anyOf } from "../api/signal";
import type { LiveStop, LiveStopped, Ordered } from "../api/types.gen";
import { newKey, windowKey } from "../state/window";
import { worded } from "../words/words";

/** A request that is not answered within this may hang: another is tried, ms. */
const TRY_MS = 4_000;
/** Between two tries, ms. */
const AGAIN_MS = 1_000;
/** Where one way is refused the other has so long to do better, ms. */
const OTHER_WAY_MS = 2_000;

/** The part of the live socket that is needed. */
export interface StopLine {
  stop(stop: LiveStop): void;
  giveUp(key: string): void;
}

export interface StopNews {
  /** The server took it. */
  answered(ordered: Ordered): void;
  /** The server does not do it for this person. */
  refused(text: string): void;
  /** Neither way was answered as long as it was wanted. */
  forgotten(): void;
  /** Neither way was answered so far; it is tried again. */
  unanswered(text: string): void;
}

export interface Stopping {
  /** Tries again at once. */
  again(): void;
  giveUp(): void;
  /** What the live socket told. */
  heard(answer: LiveStopped): void;
}

export function createStopping(line: StopLine, vessel: number, news: StopNews): Stopping {
  const ask: LiveStop = { vessel, window: windowKey(), key: newKey() };
  const ended = new AbortController();
  let refusals = 0;
  /** Ends the pause between two tries. */
  let hurry = (): void => undefined;

  const end = (): boolean => {
    if (ended.signal.aborted) return false;
    ended.abort();
    line.giveUp(ask.key);
    hurry();
    return true;
  };
  const answered = (ordered: Ordered): void => void (end() && news.answered(ordered));
  const refused = (text: string): void => {
    refusals += 1;
    const settle = (): void => void (end() && news.refused(text));
    if (refusals > 1) settle();
    else window.setTimeout(settle, OTHER_WAY_MS);
  };
  /** One request; whether it settled what this way can settle. */
  const post = async (): Promise<boolean> => {
    try {
      answered(await postStop(vessel, ask.window, ask.key, anyOf(ended.signal, AbortSignal.timeout(TRY_MS))));
      return true;
    } catch (error) {
      if (ended.signal.aborted) return true;
      if (error instanceof Refusal && error.status < 500) {
        refused(reason(error));
        return true;
      }
      news.unanswered(reason(error));
      return false;
    }
  };
  const until = Date.now() + STOP_WANTED_MS;
  const run = async (): Promise<void> => {
    for (;;) {
      if (Date.now() > until) {
        if (end()) news.forgotten();
        return;
      }
      line.stop(ask);
      if (await post()) return;
      await new Promise<void>((done) => {
        hurry = done;
        window.setTimeout(done, AGAIN_MS);
      });
      if (ended.signal.aborted) return;
    }
  };
  void run();

  return {
    again() {
      if (ended.signal.aborted) return;
      line.stop(ask);
      hurry();
    },
    giveUp: () => void end(),
    heard(answer) {
      if (answer.key !== ask.key || answer.vessel !== vessel) return;
      if (answer.ordered) answered(answer.ordered);
      else refused(worded({ text: answer.refused ?? "", says: answer.says }));
    },
  };
}
