// Whether the history has more than what came by itself: then a page that follows the present asks for it again. Pure.

import type { LiveFrame } from "../api/types.gen";

/** It is asked at least so often, as logs are also brought in from files, µs. */
const ANYWAY_US = 60_000_000;

export class Behind {
  /** Whether something came ashore, or may have, that did not come by the live socket. */
  private more = true;
  private lagged = false;
  private waited = false;
  private askedUs = -Infinity;

  frame({ snapshot, events_missed, recording }: Pick<LiveFrame, "snapshot" | "events_missed" | "recording">): void {
    // After a broken connection, and while the history lags behind what was recorded.
    this.more ||= snapshot || events_missed > 0 || this.lagged;
    this.lagged = recording !== null;
  }

  /** How many records wait aboard: they belong to the past, and have come ashore by the next word about them. */
  backlog(records: number): void {
    this.more ||= this.waited;
    this.waited = records > 0;
  }

  due(nowUs: number): boolean {
    return this.more || nowUs - this.askedUs >= ANYWAY_US;
  }

  /** It is being asked now. */
  asked(nowUs: number): void {
    [this.more, this.askedUs] = [false, nowUs];
  }

  /** No answer came. */
  failed(): void {
    this.more = true;
  }
}
