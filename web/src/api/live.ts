// The live socket: connects, subscribes, and comes back by itself when the link breaks.

import { getJson, Refusal } from "./http";
import type { Me } from "./types.gen";
import type { LiveFrame, Subscription } from "./types.gen";

/** The server sends a frame every second; after this silence it counts as gone. */
export const SILENCE_MS = 3_000;
const FIRST_WAIT_MS = 500;
const LONGEST_WAIT_MS = 5_000;

export interface LiveHandlers {
  frame(frame: LiveFrame): void;
  /** Nothing was heard for too long, or the socket closed. */
  lost(): void;
  /** Nobody is logged in any more. */
  loggedOut(): void;
}

export class Live {
  private socket: WebSocket | undefined;
  private watchdog: number | undefined;
  private wait = FIRST_WAIT_MS;
  private ended = false;

  constructor(
    private readonly subscription: Subscription,
    private readonly handlers: LiveHandlers,
  ) {
    this.connect();
  }

  close(): void {
    this.ended = true;
    window.clearTimeout(this.watchdog);
    this.socket?.close();
  }

  private connect(): void {
    const scheme = location.protocol === "https:" ? "wss:" : "ws:";
    const socket = new WebSocket(`${scheme}//${location.host}/api/live`);
    this.socket = socket;
    this.watch();
    socket.onopen = () => socket.send(JSON.stringify({ subscribe: this.subscription }));
    socket.onmessage = (event: MessageEvent<string>) => {
      if (socket !== this.socket) return;
      this.wait = FIRST_WAIT_MS;
      this.watch();
      this.handlers.frame(JSON.parse(event.data) as LiveFrame);
    };
    socket.onclose = () => {
      if (socket === this.socket) this.again();
    };
  }

  private watch(): void {
    window.clearTimeout(this.watchdog);
    this.watchdog = window.setTimeout(() => this.again(), SILENCE_MS);
  }

  private again(): void {
    const socket = this.socket;
    this.socket = undefined;
    window.clearTimeout(this.watchdog);
    socket?.close();
    if (this.ended) return;
    this.handlers.lost();
    void this.checkLogin();
    // Half to all of the wait, so that many browsers do not come back at the same moment.
    window.setTimeout(() => this.ended || this.connect(), this.wait * (0.5 + Math.random() / 2));
    this.wait = Math.min(this.wait * 2, LONGEST_WAIT_MS);
  }

  /** A refused socket does not say why; an ordinary request does. */
  private async checkLogin(): Promise<void> {
    try {
      await getJson<Me>("/api/v1/me");
    } catch (error) {
      if (error instanceof Refusal && (error.status === 401 || error.status === 403)) {
        this.close();
        this.handlers.loggedOut();
      }
    }
  }
}
