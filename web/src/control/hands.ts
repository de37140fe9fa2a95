// The person's hands: keys, a touch pad and a gamepad, one at a time. Whoever holds a dead-man first steers until all
// let go; a second device that is held at the same time is no dead-man but a reason to stop.

import type { TeleopStop } from "../api/types.gen";
import { type Hands, limited, ofKeys, ofPad, ofTouch, type Pad, STEERING_KEYS } from "../state/teleop";

export interface HandsSource {
  /** What the hands do now; `tick` is another number at each call. */
  sample(tick: number): Hands;
  /** Everything is let go: it must be pressed anew. */
  release(): void;
  /** The gamepad that is there, in words; empty for none. */
  gamepad(): string;
}

const NEUTRAL: Omit<Hands, "change"> = { held: false, thrust: 0, turn: 0 };

/** `keys` must have the focus for keys to count; `pad` is touched. `stopped` hears why the hands were taken away. */
export function createHands(keys: HTMLElement, pad: HTMLElement, knob: HTMLElement, most: () => number, stopped: (why: TeleopStop) => void): HandsSource {
  const down = new Set<string>();
  let touch: { id: number; x: number; y: number; dx: number; dy: number } | undefined;
  let known: number | undefined;

  const release = (): void => {
    down.clear();
    touch = undefined;
    knob.style.transform = "";
  };
  const lose = (why: TeleopStop): void => {
    release();
    stopped(why);
  };

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
  });
  pad.addEventListener("pointermove", (event) => {
    if (touch?.id !== event.pointerId) return;
    touch = { ...touch, dx: event.clientX - touch.x, dy: event.clientY - touch.y };
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
    if (event.gamepad.index === known) lose("gamepad_gone");
  });
  window.addEventListener("gamepadconnected", (event) => {
    if (known !== undefined && event.gamepad.index !== known) lose("two_devices");
  });
  const padNow = (): Pad | null | undefined => {
    const all = navigator.getGamepads().filter((one) => one?.connected);
    if (known !== undefined) {
      const same = all.find((one) => one?.index === known);
      if (!same) {
        // Gone without a word.
        known = undefined;
        lose("gamepad_gone");
      }
      return same;
    }
    known = all[0]?.index;
    return all[0];
  };

  return {
    sample(tick) {
      const found = padNow();
      const byPad = found ? ofPad(found) : undefined;
      const byKeys = ofKeys(down, tick);
      const byTouch = touch ? ofTouch(touch.dx, touch.dy, pad.clientHeight / 2, tick) : undefined;
      const held = [byTouch, byKeys.held ? byKeys : undefined, byPad?.held ? byPad : undefined].filter((one) => one !== undefined);
      const [only, ...others] = held;
      if (only && !others.length) return limited(only, most());
      if (others.length) {
        lose("two_devices");
        return { ...NEUTRAL, change: tick };
      }
      // Nothing is held. Sticks that are not in neutral are told, so that they must return.
      const moved = byPad && Math.hypot(byPad.thrust, byPad.turn) > Math.hypot(byKeys.thrust, byKeys.turn) ? byPad : byKeys;
      return { ...limited(moved, most()), held: false, change: tick };
    },
    release,
    gamepad: () => (known === undefined ? "" : (navigator.getGamepads()[known]?.id ?? "")),
  };
}
