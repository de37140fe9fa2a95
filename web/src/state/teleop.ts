// What a person's hands say: pure functions from keys, a touch and a gamepad to one stick position.

/** What the hands do. `change` is another number than before when the device has shown life. */
export interface Hands {
  readonly held: boolean;
  readonly thrust: number;
  readonly turn: number;
  readonly change: number;
}

/** A gamepad as the browser tells it, as far as it counts here. */
export interface Pad {
  readonly index: number;
  readonly connected: boolean;
  readonly timestamp: number;
  readonly axes: readonly number[];
  readonly buttons: readonly { readonly pressed: boolean; readonly value: number }[];
}

/** The key that must be held, and those that steer. */
export const DEAD_MAN_KEY = "Space";
const AHEAD = ["ArrowUp", "KeyW"];
const ASTERN = ["ArrowDown", "KeyS"];
const PORT = ["ArrowLeft", "KeyA"];
const STARBOARD = ["ArrowRight", "KeyD"];
export const STEERING_KEYS: readonly string[] = [DEAD_MAN_KEY, ...AHEAD, ...ASTERN, ...PORT, ...STARBOARD];

/** The dead-man of a gamepad: either trigger or shoulder button in the standard layout. */
const TRIGGERS = [4, 5, 6, 7];

const unit = (value: number): number => (Number.isFinite(value) ? Math.max(-1, Math.min(1, value)) : 0);

/** Keys are all or nothing: the turn is half, for both motors astern of each other turn on the spot. */
export function ofKeys(down: ReadonlySet<string>, tick: number): Hands {
  const any = (keys: readonly string[]): number => (keys.some((key) => down.has(key)) ? 1 : 0);
  return { held: down.has(DEAD_MAN_KEY), thrust: any(AHEAD) - any(ASTERN), turn: (any(STARBOARD) - any(PORT)) / 2, change: tick };
}

/** A touch steers by how far it moved from where it began; `radius` is full deflection. */
export function ofTouch(dx: number, dy: number, radius: number, tick: number): Hands {
  return { held: true, thrust: unit(-dy / radius), turn: unit(dx / radius), change: tick };
}

/** The left stick steers while a trigger is held. */
export function ofPad(pad: Pad): Hands {
  const held = TRIGGERS.some((index) => pad.buttons[index]?.pressed);
  return { held, thrust: unit(-(pad.axes[1] ?? 0)), turn: unit(pad.axes[0] ?? 0), change: pad.timestamp };
}

/** Less of it, as the person chose; neutral stays neutral. */
export function limited(hands: Hands, most: number): Hands {
  return { ...hands, thrust: hands.thrust * most, turn: hands.turn * most };
}
