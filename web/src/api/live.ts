// The live socket: connects, subscribes, and comes back by itself when the link breaks, when the computer has slept,
// and when what comes has waited too long on the way. Stops go by it as well, by each new connection again until they
// are answered.

import { Arrivals, Awake } from "../state/arrival";
import { Inflater } from "./compact";
import { getJson, Refusal, STOP_WANTED_MS } from "./http";
import type { LiveAnswer, LiveFrame, LiveRequest, LiveStop, LiveStopped, Me, Subscription } from "./types.gen";

/** The server sends a frame every second; after this silence it counts as gone. The page greys within 3 s. */
const SILENCE_MS = 2_800;
/** A connection has so long to begin: the page is grey meanwhile. */
const BEGIN_MS = 10_000;
/** How often it is looked whether the computer slept, ms. */
const LOOK_MS = 250;
/** A stop does not wait so long for a connection that does not begin, or for one that says nothing after the stop was sent by it. */
const HURRY_MS = 1_500;
/** Each further connection for a stop has twice the time, up to this, ms: on a slow link one must come about in the end. */
const LONGEST_HURRY_MS = 6_000;
/** The server says within this whether somebody is still logged in, ms. */
const LOGIN_MS = 8_000;
const FIRST_WAIT_MS = 500;
const LONGEST_WAIT_MS = 5_000;

/** What a page wants to hear; it always comes in the compact form. */
export type Wanted = Omit<Subscription, "compact">;

export interface LiveHandlers {
  /** `atMs`: when it could have come by the quickest way so far, ms of the steady clock. */
  frame(frame: LiveFrame, atMs: number): void;
  /** Nothing was heard for too long, or the socket closed. */
  lost(): void;
  /** Nobody is logged in any more. */
  loggedOut(): void;
  /** A stop was answered. */
  stopped?(answer: LiveStopped): void;
}

export class Live {
  private socket: WebSocket | undefined;
  private watchdog: number | undefined;
  private wait = FIRST_WAIT_MS;
  private ended = false;
  private arrivals = new Arrivals();
  private readonly awake = new Awake();
  /** When something was heard last, ms of the steady clock; undefined before. */
  private heardMs: number | undefined;
  private readonly looks: number;
  /** Stops without an answer, by their keys. */
  private readonly stops = new Map<string, { stop: LiveStop; untilMs: number }>();
  /** When the present connection was begun, ms of the steady clock, and until when the next one waits. */
  private begunMs = 0;
  /** How long a stop waits for a connection. */
  private patienceMs = HURRY_MS;
  private pause: number | undefined;

  constructor(
    private readonly subscription: Wanted,
    private readonly handlers: LiveHandlers,
  ) {
    this.connect();
    this.looks = window.setInterval(this.look, LOOK_MS);
    // A tab that was hidden had its timers held back: it is looked before anything is drawn.
    document.addEventListener("visibilitychange", this.look);
    window.addEventListener("pageshow", this.look);
  }

  close(): void {
    this.ended = true;
    window.clearInterval(this.looks);
    document.removeEventListener("visibilitychange", this.look);
    window.removeEventListener("pageshow", this.look);
    window.clearTimeout(this.watchdog);
    window.clearTimeout(this.pause);
    this.socket?.close();
  }

  /** Sends a stop at once if there is a connection, and by each new one until it is answered or given up. */
  stop(stop: LiveStop): void {
    const untilMs = this.stops.get(stop.key)?.untilMs ?? Date.now() + STOP_WANTED_MS;
    this.stops.set(stop.key, { stop, untilMs });
    if (this.socket?.readyState === WebSocket.OPEN) this.sayStop(stop);
    else this.hurry();
  }

  /** A stop needs no answer by this way any more. */
  giveUp(key: string): void {
    this.stops.delete(key);
  }

  /** Somebody waits for a connection: a new one is tried in place of one that does not begin. */
  hurry(): void {
    if (this.ended || this.socket?.readyState === WebSocket.OPEN) return;
    if (this.socket && performance.now() - this.begunMs < this.patienceMs) return;
    const old = this.socket;
    if (old) this.patienceMs = Math.min(2 * this.patienceMs, LONGEST_HURRY_MS);
    this.connect();
    old?.close();
  }

  /** By the connection that is open; by a new one if nothing is heard on it soon. */
  private sayStop(stop: LiveStop): void {
    this.say({ stop });
    const [socket, saidMs] = [this.socket, performance.now()];
    window.setTimeout(() => {
      if (socket !== this.socket || !this.stops.has(stop.key) || (this.heardMs ?? 0) > saidMs) return;
      // Most likely it is dead, and the silence that shows it for certain is too long for a stop.
      this.again();
      this.hurry();
      this.patienceMs = Math.min(2 * this.patienceMs, LONGEST_HURRY_MS);
    }, this.patienceMs);
  }

  private say(request: LiveRequest): void {
    this.socket?.send(JSON.stringify(request));
  }

  private connect(): void {
    window.clearTimeout(this.pause);
    this.begunMs = performance.now();
    const scheme = location.protocol === "https:" ? "wss:" : "ws:";
    const socket = new WebSocket(`${scheme}//${location.host}/api/live`);
    socket.binaryType = "arraybuffer";
    this.socket = socket;
    this.arrivals = new Arrivals();
    this.heardMs = undefined;
    this.watch(BEGIN_MS);
    socket.onopen = () => {
      if (socket !== this.socket) return;
      for (const { stop, untilMs } of this.stops.values()) if (Date.now() < untilMs) this.sayStop(stop);
      this.say({ subscribe: { ...this.subscription, compact: true } });
    };
    const leave = (): void => {
      if (socket === this.socket) this.again();
    };
    const inflater = new Inflater((frame, cameMs) => {
      if (socket === this.socket) this.take(frame, cameMs);
    }, leave);
    socket.onmessage = ({ data }: MessageEvent<string | ArrayBuffer>) => {
      // What became of a stop is true however late it comes.
      if (typeof data === "string") return this.handlers.stopped?.((JSON.parse(data) as LiveAnswer).stop);
      // What was said before the computer slept is not what is.
      this.look();
      if (socket === this.socket) inflater.take(data, performance.now());
    };
    socket.onclose = leave;
  }

  private take(frame: LiveFrame, cameMs: number): void {
    const dueMs = this.arrivals.dueMs(frame.now_us, cameMs);
    // Behind this one others wait that are old too; a new connection begins with the present.
    if (cameMs - dueMs > SILENCE_MS) return this.again();
    this.wait = FIRST_WAIT_MS;
    this.patienceMs = HURRY_MS;
    this.heardMs = cameMs;
    this.watch(SILENCE_MS);
    this.handlers.frame(frame, dueMs);
  }

  private watch(ms: number): void {
    window.clearTimeout(this.watchdog);
    this.watchdog = window.setTimeout(() => this.again(), ms);
  }

  /** Gives up a connection of which it is not known how old what it says is. */
  private readonly look = (): void => {
    const [jumped, nowMs] = [this.awake.jumped(Date.now(), performance.now()), performance.now()];
    if (this.socket && (jumped || nowMs - (this.heardMs ?? nowMs) > SILENCE_MS)) this.again();
  };

  private again(): void {
    const socket = this.socket;
    this.socket = undefined;
    window.clearTimeout(this.watchdog);
    socket?.close();
    if (this.ended) return;
    this.handlers.lost();
    void this.checkLogin();
    // Half to all of the wait, so that many browsers do not come back at the same moment.
    this.pause = window.setTimeout(() => this.connect(), this.wait * (0.5 + Math.random() / 2));
    this.wait = Math.min(this.wait * 2, LONGEST_WAIT_MS);
  }

  /** A refused socket does not say why; an ordinary request does. */
  private async checkLogin(): Promise<void> {
    try {
      await getJson<Me>("/api/v1/me", AbortSignal.timeout(LOGIN_MS));
    } catch (error) {
      if (error instanceof Refusal && (error.status === 401 || error.status === 403)) {
        this.close();
        this.handlers.loggedOut();
      }
    }
  }
}
