// When what the server sends would have come by the quickest way: what waited on the way is as old as it is. Pure.

/** Clocks of server and browser may drift apart by this part of the time. */
const DRIFT = 1e-3;
/** Steady and wall clock of a browser part by this much when it slept or when somebody set its clock, ms. */
const JUMP_MS = 2_000;

/** Of one connection. */
export class Arrivals {
  private best: { readonly serverUs: number; readonly atMs: number } | undefined;

  /** When a frame that the server sent at `serverUs` and that came at `atMs` could have come, ms of the steady clock. */
  dueMs(serverUs: number, atMs: number): number {
    const { best } = this;
    const due = best ? best.atMs + (serverUs - best.serverUs) / 1e3 + (atMs - best.atMs) * DRIFT : atMs;
    if (best && due < atMs) return due;
    this.best = { serverUs, atMs };
    return atMs;
  }
}

/** Notices that the computer slept, while its steady clock stood, and that its clock was set. */
export class Awake {
  private apartMs: number | undefined;

  /** Whether that was the case since it was asked last. */
  jumped(wallMs: number, steadyMs: number): boolean {
    const apart = wallMs - steadyMs;
    const jumped = this.apartMs !== undefined && Math.abs(apart - this.apartMs) > JUMP_MS;
    // What a clock is slewed by is no jump.
    this.apartMs = apart;
    return jumped;
  }
}
