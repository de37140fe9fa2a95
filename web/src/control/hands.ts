// The person's hands: keys, a touch pad and a gamepad, one at a time. Whoever holds a dead-man first steers until all
// let go; a second device that is held at the same time is no dead-man but a reason to stop.

import type { TeleopStop } from "../api/types.gen";
import { type Hands, isHeld, limited, ofKeys, ofPad, ofTouch, type Pad, PadLife, STEERING_KEYS, Vigil, vigilText } from "../state/teleop";

export interface HandsSource {
  /** What the hands do now, ms of the steady clock; `tick` is another number at each call. */
  sample(tick: number, nowMs: number): Hands;
  /** What the person has to do so that the hands go on to count; empty for nothing. */
  asks(): string;
  /** Everything is let go: it must be pressed again. */
  release(): void;
  /** The gamepad that is there, whether or not it counts. */
  gamepad(): Pad | undefined;
  /** Whether the gamepad counts: who has one that is worn or hangs may steer without it. */
  usePad(use: boolean): void;
}

const NEUTRAL: Omit<Hands, "change"> = { held: false, thrust: 0, turn: 0 };

/** `keys` must have the focus for keys to count; `pad` is touched. `stopped` hears why the hands were taken away. */
export function createHands(keys: HTMLElement, pad: HTMLElement, knob: HTMLElement, most: () => number, stopped: (why: TeleopStop) => void): HandsSource {
  return new OfPerson(keys, pad, knob, most, stopped);
}

/** Takes the hands away, for a reason. */
type Lose = (why: TeleopStop) => void;

class OfPerson implements HandsSource {
  private readonly keys: KeysDown;
  private readonly touch: Touched;
  private readonly pads: Pads;
  private readonly padLife = new PadLife();
  private asked = "";

  constructor(keys: HTMLElement, pad: HTMLElement, knob: HTMLElement, private readonly most: () => number, private readonly stopped: Lose) {
    const lose: Lose = (why) => this.lose(why);
    [this.keys, this.touch, this.pads] = [new KeysDown(keys, lose), new Touched(pad, knob), new Pads(lose)];
  }

  asks(): string {
    return this.asked;
  }

  release(): void {
    this.keys.release();
    this.touch.release();
    this.asked = "";
  }

  usePad(use: boolean): void {
    this.pads.used = use;
    // What is held at this moment was pressed for something else.
    this.lose("person");
  }

  gamepad(): Pad | undefined {
    return this.pads.known();
  }

  sample(tick: number, nowMs: number): Hands {
    const found = this.pads.now();
    const byPad = found ? ofPad(found, this.padLife.look(found)) : undefined;
    const [byKeys, byTouch] = [this.keys.hands(tick), this.touch.hands(tick)];
    const held = [byTouch, byKeys.held ? byKeys : undefined, byPad?.held ? byPad : undefined].filter((one) => one !== undefined);
    const [only, ...others] = held;
    // A gamepad tells by itself whether it is alive.
    const standing = only === undefined || only === byPad ? "alive" : (only === byTouch ? this.touch : this.keys).vigil.look(nowMs);
    this.asked = standing === "asked" ? vigilText(only === byTouch ? "touch" : "keys") : "";
    if (others.length || standing === "gone") {
      this.lose(others.length ? "two_devices" : "unmoved");
      return { ...NEUTRAL, change: tick };
    }
    if (only) return limited(only, this.most());
    // Nothing is held. Sticks that are not in neutral are told, so that they must return.
    const moved = byPad && Math.hypot(byPad.thrust, byPad.turn) > Math.hypot(byKeys.thrust, byKeys.turn) ? byPad : byKeys;
    return { ...limited(moved, this.most()), held: false, change: tick };
  }

  private lose(why: TeleopStop): void {
    this.release();
    this.stopped(why);
  }
}

/** The keys that are down while their place has the focus. */
class KeysDown {
  readonly vigil = new Vigil();
  private readonly down = new Set<string>();

  constructor(keys: HTMLElement, lose: Lose) {
    // Any key tells that the keyboard is alive; those that the computer repeats by itself tell nothing.
    for (const kind of ["keydown", "keyup"] as const) {
      keys.addEventListener(kind, (event) => {
        if (!event.repeat) this.vigil.changed(performance.now());
      });
    }
    keys.addEventListener("keydown", (event) => {
      if (!STEERING_KEYS.includes(event.code) || event.ctrlKey || event.altKey || event.metaKey) return;
      event.preventDefault();
      // A key that was held all the time is no new press: after a stop it must be let go first.
      if (!event.repeat) this.down.add(event.code);
    });
    keys.addEventListener("keyup", (event) => {
      if (!STEERING_KEYS.includes(event.code)) return;
      event.preventDefault();
      this.down.delete(event.code);
    });
    keys.addEventListener("blur", () => {
      if (this.down.size) lose("unfocused");
    });
  }

  release(): void {
    this.down.clear();
  }

  hands(tick: number): Hands {
    return ofKeys(this.down, tick);
  }
}

/** The one finger that is on the pad, from where it touched. */
class Touched {
  readonly vigil = new Vigil();
  private finger: { id: number; x: number; y: number; dx: number; dy: number } | undefined;

  constructor(private readonly pad: HTMLElement, private readonly knob: HTMLElement) {
    pad.addEventListener("pointerdown", (event) => {
      if (this.finger || (event.pointerType === "mouse" && event.button !== 0)) return;
      pad.setPointerCapture(event.pointerId);
      this.finger = { id: event.pointerId, x: event.clientX, y: event.clientY, dx: 0, dy: 0 };
      this.vigil.changed(performance.now());
    });
    pad.addEventListener("pointermove", (event) => this.move(event));
    for (const name of ["pointerup", "pointercancel", "lostpointercapture"] as const) {
      pad.addEventListener(name, (event) => {
        if (this.finger?.id === event.pointerId) this.release();
      });
    }
    pad.addEventListener("contextmenu", (event) => event.preventDefault());
  }

  release(): void {
    this.finger = undefined;
    this.knob.style.transform = "";
  }

  hands(tick: number): Hands | undefined {
    return this.finger ? ofTouch(this.finger.dx, this.finger.dy, this.pad.clientHeight / 2, tick) : undefined;
  }

  private move({ pointerId, clientX, clientY }: PointerEvent): void {
    const { finger } = this;
    if (finger?.id !== pointerId) return;
    const [dx, dy] = [clientX - finger.x, clientY - finger.y];
    // A screen may go on to tell of a finger that does not move.
    if (dx !== finger.dx || dy !== finger.dy) this.vigil.changed(performance.now());
    this.finger = { ...finger, dx, dy };
    const part = Math.min(1, this.pad.clientHeight / 2 / (Math.hypot(dx, dy) || 1));
    this.knob.style.transform = `translate(${dx * part}px, ${dy * part}px)`;
  }
}

/** The gamepads that are there, of which one counts. */
class Pads {
  /** Whether gamepads count at all. */
  used = true;
  private index: number | undefined;

  constructor(private readonly lose: Lose) {
    window.addEventListener("gamepaddisconnected", (event) => {
      if (this.used && event.gamepad.index === this.index) lose("gamepad_gone");
    });
    window.addEventListener("gamepadconnected", (event) => {
      if (this.used && this.index !== undefined && event.gamepad.index !== this.index) lose("two_devices");
    });
  }

  known(): Pad | undefined {
    return this.index === undefined ? undefined : (navigator.getGamepads()[this.index] ?? undefined);
  }

  /** The one that counts, where gamepads do; which that is, is found out either way. */
  now(): Pad | undefined {
    const there = this.there() ?? undefined;
    return this.used ? there : undefined;
  }

  private there(): Pad | null | undefined {
    const all = navigator.getGamepads().filter((one) => one?.connected);
    if (this.index === undefined) {
      this.index = all[0]?.index;
      return all[0];
    }
    const same = all.find((one) => one?.index === this.index);
    if (!same) {
      // Gone without a word.
      this.index = undefined;
      if (this.used) this.lose("gamepad_gone");
      return same;
    }
    // Some receivers and sensors pass for gamepads: the one counts whose dead-man somebody holds.
    const other = isHeld(same) ? undefined : all.find((one) => one && isHeld(one));
    this.index = (other ?? same).index;
    return other ?? same;
  }
}
