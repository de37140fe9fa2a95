// Steering by hand, decided without a screen: what a person's hands say, and the words for how it stands.

import type { TeleopStatus } from "../api/types.gen";
import { t, worded } from "../words/words";

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
  readonly id: string;
  /** `standard` where the browser knows the order of axes and buttons. */
  readonly mapping: string;
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

/** Keys and a finger count as alive for so long after they last changed, ms. */
export const VIGIL_MS = 10_000;
/** The person is asked for a change after this, ms. */
const VIGIL_ASKS_MS = 7_000;
/** What comes later than this after the sample before is the server's to judge: it takes it for silence or a clock that jumps, ms. */
const VIGIL_STEP_MS = 1_000;

/** How long ago keys or a finger last showed a change. A key that hangs, and one that the computer repeats by itself, show none. */
export class Vigil {
  private quietMs = 0;
  private atMs = 0;

  /** A key was pressed or let go, or the finger moved. */
  changed(nowMs: number): void {
    [this.quietMs, this.atMs] = [0, nowMs];
  }

  /** Time passes: whether the hands are alive, are to show it soon, or count as gone. */
  look(nowMs: number): "alive" | "asked" | "gone" {
    this.quietMs += Math.max(0, Math.min(VIGIL_STEP_MS, nowMs - this.atMs));
    this.atMs = nowMs;
    return this.quietMs >= VIGIL_MS ? "gone" : this.quietMs >= VIGIL_ASKS_MS ? "asked" : "alive";
  }
}

/** What the person is asked for before the hands count as gone. */
export function vigilText(device: "keys" | "touch"): string {
  const act = device === "keys" ? t("Press or let go any key") : t("Move your finger a little");
  return t("Still there? {act}: without a change the motors stop {seconds} s after the last one.", { act, seconds: VIGIL_MS / 1_000 });
}

/** The dead-man of a gamepad: either trigger or shoulder button in the standard layout. */
const TRIGGERS = [4, 5, 6, 7];

/** Sticks within this are in neutral for the server, which takes it off the rest, of 1. */
const NEUTRAL = 0.08;

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

/** The sticks that steer, as people call them. */
const AXES = [t("port and starboard"), t("ahead and astern")];
const STUCK = t("Let go of it. If it stays there it is worn or calibrated wrongly: calibrate it in the settings of this computer, or leave the gamepad out and steer with keys or touch.");

/** Axes that are not in neutral, in words that do not change with each tremor; empty for none. */
export function offNeutral(pad: Pad): string {
  const off = AXES.filter((_, index) => Math.abs(unit(pad.axes[index] ?? 0)) > NEUTRAL);
  return off.length ? t("The gamepad's stick for {axes} is not in neutral, so nothing moves. {remedy}", { axes: off.join(` ${t("and for")} `), remedy: STUCK }) : "";
}

/** What is taken from a gamepad, and what it says now. */
export function padText(pad: Pad): string {
  const axes = AXES.map((name, index) => t("axis {index} ({name}) {unit}", { index, name, unit: unit(pad.axes[index] ?? 0).toFixed(2) })).join(", ");
  const now = t("Now: {axes}; up to {neutral} counts as neutral.", { axes, neutral: NEUTRAL });
  if (pad.mapping === "standard") {
    return t("Gamepad: {id}. Hold a trigger or shoulder button, steer with the left stick and keep it moving a little: one that shows no change counts as hung. {now}", { id: pad.id, now });
  }
  const pressed = pad.buttons.flatMap((button, index) => (button.pressed ? [index] : []));
  const last = TRIGGERS.at(-1);
  return t("Gamepad: {id}. This browser does not know the order of its buttons: numbers {first} to {last} are taken for the dead-man, axes 0 and 1 for the stick. Try it before you hold one: pressed now: {pressed}. {now} If that is not what your hands do, leave it out and steer with keys or touch.", { id: pad.id, first: TRIGGERS[0] ?? "?", last: last ?? "?", pressed: pressed.join(", ") || t("none"), now });
}

/** Whether a gamepad lives, by what it says: some browsers stamp it with the present at each look, though it hangs. */
export class PadLife {
  private said = "";
  private changes = 0;

  /** Another number than before where an axis or a button says something else. */
  look(pad: Pad): number {
    const says = JSON.stringify([pad.index, pad.axes, pad.buttons.map(({ pressed, value }) => [pressed, value])]);
    if (says !== this.said) [this.said, this.changes] = [says, this.changes + 1];
    return this.changes;
  }
}

/** Whether its dead-man is held. */
export function isHeld(pad: Pad): boolean {
  return TRIGGERS.some((index) => pad.buttons[index]?.pressed);
}

/** The left stick steers while a trigger is held; `change` is what PadLife says. */
export function ofPad(pad: Pad, change: number): Hands {
  return { held: isHeld(pad), thrust: unit(-(pad.axes[1] ?? 0)), turn: unit(pad.axes[0] ?? 0), change };
}

/** Less of what is beyond neutral, as the person chose; what is within stays as it is. */
export function limited(hands: Hands, most: number): Hands {
  const less = (value: number): number => (Math.abs(value) <= NEUTRAL ? value : Math.sign(value) * (NEUTRAL + (Math.abs(value) - NEUTRAL) * most));
  return { ...hands, thrust: less(hands.thrust), turn: less(hands.turn) };
}

/** Whether the hands ask for no thrust. */
export function isNeutral(hands: Pick<Hands, "thrust" | "turn">): boolean {
  return Math.abs(hands.thrust) <= NEUTRAL && Math.abs(hands.turn) <= NEUTRAL;
}

/** How it stands: the state in words, why it stopped, and what to do. */
export interface Standing {
  readonly state: string;
  readonly why: string;
  readonly remedy: string;
}

const STATES: Readonly<Record<TeleopStatus["phase"], string>> = {
  idle: t("Connecting …"),
  starting: t("Asking the vessel …"),
  locked: t("STOPPED. Let go of everything."),
  ready: t("READY. Motors stand still."),
  steering: t("STEERING. Let go to stop."),
};
/** The dead-man is held, and the motors stand still all the same. */
const HELD = t("HELD IN NEUTRAL. Motors stand still until you steer.");
const PASS_NEUTRAL = t("Release the dead-man and let the sticks go to neutral.");
const HOLD = t("Hold the dead-man first, then steer.");

/**
 * `told` is what the server said last, undefined when that is too long ago; `heard` whether it said anything yet;
 * `neutral` whether the hands ask for no thrust, and `stuck` which sticks are not let go, in words.
 */
export function standing(told: TeleopStatus | undefined, heard: boolean, neutral: boolean, stuck: string): Standing {
  if (!told && !heard) return { state: STATES.idle, why: "", remedy: "" };
  if (!told) {
    return { state: t("STOPPED. The server is not heard."), why: t("Nothing you do here reaches the vessel: its motors stop by themselves."), remedy: t("Wait until it is heard, or stop the vessel by other means.") };
  }
  const { phase } = told;
  const next = phase === "locked" ? stuck || PASS_NEUTRAL : phase === "ready" ? stuck || HOLD : "";
  return { state: phase === "steering" && neutral ? HELD : STATES[phase], why: told.why && phase !== "steering" ? t("It stopped: {why}.", { why: worded({ text: told.why, says: told.why_says }) }) : "", remedy: [worded({ text: told.remedy, says: told.remedy_says }), next].filter(Boolean).join(" ") };
}

/** The round trip in words. */
export function tripText(told: TeleopStatus | undefined): string {
  const ms = told?.round_trip_ms;
  if (!told || ms === null || ms === undefined) return t("Round trip: unknown");
  const way = told.with_vessel ? t("to the vessel and back") : t("to the server and back; the vessel's part is not known: should its link fail, it stops by its own time limit");
  const slow = told.slow ? `. ${t("SLOW: steer with care.")}` : "";
  const cap = told.cap < 1 ? ` ${t("Thrust is limited to {cap} %.", { cap: Math.round(told.cap * 100) })}` : "";
  return `${t("Round trip {ms} ms {way}", { ms: Math.round(ms), way })}${slow}${cap}`;
}
