// The person's hands: keys, a touch pad and a gamepad, one at a time. Whoever holds a dead-man first steers until all
// let go; a second device that is held at the same time is no dead-man but a reason to stop.

import type { TeleopStop } from "../api/types.gen";
import { type Hands, isHeld, limited, ofKeys, ofPad, ofTouch, type Pad, PadLife, STEERING_KEYS, Vigil, vigilText } from "../state/teleop";

export interface HandsSource {
  /** What the hands do now, ms of the steady clock; `tick` is another number at each call. */
  sample(tick: number, nowMs: number): Hands;
  /** What the person has to do so that the hands go on to count; empty for nothing. */
  asks(): string;
  /** Everything is let go: it must be pressed anew. */
  release(): void;
  /** The gamepad that is there, whether or not it counts. */
  gamepad(): Pad | undefined;
  /** Whether the gamepad counts: who has one that is worn or hangs may steer without it. */
  usePad(use: boolean): void;
}

const NEUTRAL: Omit<Hands, "change"> = { held: false, thrust: 0, turn: 0 };

/** `keys` must have the focus for keys to count; `pad` is touched. `stopped` hears why the hands were taken away. */
export function createHands(keys: HTMLElement, pad: HTMLElement, knob: HTMLElement, most: () => number, stopped: (why: TeleopStop) => void): HandsSource {
  const down = new Set<string>();
  let touch: { id: number; x: number; y: number; dx: number; dy: number } | undefined;
  let known: number | undefined;
  const [keysVigil, touchVigil] = [new Vigil(), new Vigil()];
  let asks = "";
  let padUsed = true;
  const padLife = new PadLife();

  const release = (): void => {
    down.clear();
    touch = undefined;
    asks = "";
    knob.style.transform = "";
  };
  const lose = (why: TeleopStop): void => {
    release();
    stopped(why);
  };

  // Any key tells that the keyboard is alive; those that the computer repeats by itself tell nothing.
  for (const kind of ["keydown", "keyup"] as const) {
    keys.addEventListener(kind, (event) => {
      if (!event.repeat) keysVigil.changed(performance.now());
    });
  }
  keys.addEventListener("keydown", (event) => {
    if (!STEERING_KEYS.includes(event.code) || event.ctrlKey || event.altKey || event.metaKey) return;
    event.preventDefault();
    // A key that was held all the time is no new press: after a stop it must be let go first.
    if (!event.repeat) down.add(event.code);
  });
  keys.addEventListener("keyup", (event) => {
    if (!STEERING_KEYS.includes(event.code)) return;
    event.preventDefault();
    down.delete(event.code);
  });
  keys.addEventListener("blur", () => {
    if (down.size) lose("unfocused");
  });

  pad.addEventListener("pointerdown", (event) => {
    if (touch || (event.pointerType === "mouse" && event.button !== 0)) return;
    pad.setPointerCapture(event.pointerId);
    touch = { id: event.pointerId, x: event.clientX, y: event.clientY, dx: 0, dy: 0 };
    touchVigil.changed(performance.now());
  });
  pad.addEventListener("pointermove", (event) => {
    if (touch?.id !== event.pointerId) return;
    const [dx, dy] = [event.clientX - touch.x, event.clientY - touch.y];
    // A screen may go on to tell of a finger that does not move.
    if (dx !== touch.dx || dy !== touch.dy) touchVigil.changed(performance.now());
    touch = { ...touch, dx, dy };
    const radius = pad.clientHeight / 2;
    const part = Math.min(1, radius / (Math.hypot(touch.dx, touch.dy) || 1));
    knob.style.transform = `translate(${touch.dx * part}px, ${touch.dy * part}px)`;
  });
  for (const name of ["pointerup", "pointercancel", "lostpointercapture"] as const) {
    pad.addEventListener(name, (event) => {
      if (touch?.id !== event.pointerId) return;
      touch = undefined;
      knob.style.transform = "";
    });
  }
  pad.addEventListener("contextmenu", (event) => event.preventDefault());

  window.addEventListener("gamepaddisconnected", (event) => {
    if (padUsed && event.gamepad.index === known) lose("gamepad_gone");
  });
  window.addEventListener("gamepadconnected", (event) => {
    if (padUsed && known !== undefined && event.gamepad.index !== known) lose("two_devices");
  });
  const padNow = (): Pad | null | undefined => {
    const all = navigator.getGamepads().filter((one) => one?.connected);
    if (known !== undefined) {
      const same = all.find((one) => one?.index === known);
      if (!same) {
        // Gone without a word.
        known = undefined;
        if (padUsed) lose("gamepad_gone");
        return same;
      }
      // Some receivers and sensors pass for gamepads: the one counts whose dead-man somebody holds.
      const other = isHeld(same) ? undefined : all.find((one) => one && isHeld(one));
      known = (other ?? same).index;
      return other ?? same;
    }
    known = all[0]?.index;
    return all[0];
  };

  return {
    asks: () => asks,
    usePad(use) {
      padUsed = use;
      // What is held at this moment was pressed for something else.
      lose("person");
    },
    sample(tick, nowMs) {
      const there = padNow();
      const found = padUsed ? there : undefined;
      const byPad = found ? ofPad(found, padLife.look(found)) : undefined;
      const byKeys = ofKeys(down, tick);
      const byTouch = touch ? ofTouch(touch.dx, touch.dy, pad.clientHeight / 2, tick) : undefined;
      const held = [byTouch, byKeys.held ? byKeys : undefined, byPad?.held ? byPad : undefined].filter((one) => one !== undefined);
      const [only, ...others] = held;
      // A gamepad tells by itself whether it is alive.
      const standing = only === undefined || only === byPad ? "alive" : (only === byTouch ? touchVigil : keysVigil).look(nowMs);
      asks = standing === "asked" ? vigilText(only === byTouch ? "touch" : "keys") : "";
      if (others.length || standing === "gone") {
        lose(others.length ? "two_devices" : "unmoved");
        return { ...NEUTRAL, change: tick };
      }
      if (only) return limited(only, most());
      // Nothing is held. Sticks that are not in neutral are told, so that they must return.
      const moved = byPad && Math.hypot(byPad.thrust, byPad.turn) > Math.hypot(byKeys.thrust, byKeys.turn) ? byPad : byKeys;
      return { ...limited(moved, most()), held: false, change: tick };
    },
    release,
    gamepad: () => (known === undefined ? undefined : (navigator.getGamepads()[known] ?? undefined)),
  };
}
