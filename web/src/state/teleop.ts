// Steering by hand, decided without a screen: what a person's hands say, and the words for how it stands.

import type { TeleopTold } from "../api/types.gen";
import { entities, type Labels, type Values } from "./vitals";

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

/** Sticks within this are in neutral for the server, which takes it off the rest, of 1. */
const NEUTRAL = 0.08;

/** Less of what is beyond neutral, as the person chose; what is within stays as it is. */
export function limited(hands: Hands, most: number): Hands {
  const less = (value: number): number => (Math.abs(value) <= NEUTRAL ? value : Math.sign(value) * (NEUTRAL + (Math.abs(value) - NEUTRAL) * most));
  return { ...hands, thrust: less(hands.thrust), turn: less(hands.turn) };
}

/** How it stands: the state in words, why it stopped, and what to do. */
export interface Standing {
  readonly state: string;
  readonly why: string;
  readonly remedy: string;
}

const STATES: Readonly<Record<TeleopTold["phase"], string>> = {
  idle: "Connecting …",
  starting: "Asking the vessel …",
  locked: "STOPPED. Let go of everything.",
  ready: "READY. Motors stand still.",
  steering: "MOVING. Let go to stop.",
};
const PASS_NEUTRAL = "Release the dead-man and let the sticks go to neutral.";
const HOLD = "Hold the dead-man first, then steer.";

/** `told` is what the server said last, undefined when that is too long ago; `heard` whether it said anything yet. */
export function standing(told: TeleopTold | undefined, heard: boolean): Standing {
  if (!told && !heard) return { state: STATES.idle, why: "", remedy: "" };
  if (!told) {
    return { state: "STOPPED. The server is not heard.", why: "Nothing you do here reaches the vessel: its motors stop by themselves.", remedy: "Wait until it is heard, or stop the vessel by other means." };
  }
  const { phase } = told;
  const next = phase === "locked" ? PASS_NEUTRAL : phase === "ready" ? HOLD : "";
  return { state: STATES[phase], why: told.why && phase !== "steering" ? `It stopped: ${told.why}.` : "", remedy: [told.remedy, next].filter(Boolean).join(" ") };
}

/** The round trip in words. */
export function tripText(told: TeleopTold | undefined): string {
  const ms = told?.round_trip_ms;
  if (!told || ms === null || ms === undefined) return "Round trip: not known";
  const way = told.with_vessel ? "to the vessel and back" : "to the server and back; the vessel's part is not known: should its link fail, it stops by its own time limit";
  const slow = told.slow ? ". SLOW: steer with care." : "";
  const cap = told.cap < 1 ? ` Thrust is limited to ${Math.round(told.cap * 100)} %.` : "";
  return `Round trip ${Math.round(ms)} ms ${way}${slow}${cap}`;
}

/** What the vessel's grounding supervisor says; undefined where it says nothing or has no chart. */
export interface Guard {
  readonly text: string;
  /** It lets no thrust through in some direction. */
  readonly blocks: boolean;
  /** An operator had it lifted for a while. */
  readonly lifted: boolean;
}

export const GUARD_ENTITY = "Grounding Supervisor";

export function guardOf(values: Values, labels: Labels, nowUs: number): Guard | undefined {
  const one = entities(values, labels, nowUs).find(({ label }) => label === GUARD_ENTITY);
  if (!one || one.old || !one.description || one.description.startsWith("off:")) return undefined;
  return { text: one.description, blocks: one.description.includes("thrust towards danger is blocked"), lifted: one.description.includes("may steer unguarded") };
}
