// The sound of alarms. Browsers keep silent until a person has touched the page, so it is armed by a button whose first
// act is to let the person hear it; until then the page says that it is muted.

import type { Priority } from "../state/alarms";

/** Tones of each priority, Hz, one after the other; alarm and warning cannot be confused. */
const TONES: Readonly<Record<Priority, readonly number[]>> = {
  emergency: [880, 660, 880, 660, 880, 660],
  alarm: [784, 988, 1175],
  warning: [523],
  caution: [],
};
const TONE_S = 0.22;
const GAP_S = 0.06;
const LOUDNESS = 0.25;

export interface Sound {
  readonly armed: boolean;
  /** Arms it and lets it be heard; false where the browser plays nothing. */
  arm(): Promise<boolean>;
  mute(): void;
  play(priority: Priority): void;
}

/** Remembers for this window that somebody turned it on. */
const WANTED = "lutra-sound";

/** `changed` is told when it is armed again by itself. */
export function createSound(changed: () => void): Sound {
  let context: AudioContext | undefined;
  let armed = false;
  const wake = async (): Promise<boolean> => {
    context ??= new AudioContext();
    await Promise.race([context.resume(), new Promise((done) => setTimeout(done, 1_000))]);
    armed = context.state === "running";
    if (armed) sessionStorage.setItem(WANTED, "on");
    return armed;
  };
  // Another page of ours, where it was on before: with the first touch it is on again, as browsers allow no earlier.
  const again = (event: Event): void => {
    // The button itself says what it does.
    if (event.target instanceof Element && event.target.closest(".arm")) return;
    for (const kind of ["pointerdown", "keydown"]) document.removeEventListener(kind, again);
    if (!armed && sessionStorage.getItem(WANTED) === "on") void wake().then(changed);
  };
  for (const kind of ["pointerdown", "keydown"]) document.addEventListener(kind, again);
  const play = (priority: Priority): void => {
    if (!context || !armed) return;
    let at = context.currentTime + 0.02;
    for (const tone of TONES[priority]) {
      const [oscillator, gain] = [context.createOscillator(), context.createGain()];
      oscillator.type = "triangle";
      oscillator.frequency.value = tone;
      gain.gain.setValueAtTime(0, at);
      gain.gain.linearRampToValueAtTime(LOUDNESS, at + 0.02);
      gain.gain.setValueAtTime(LOUDNESS, at + TONE_S - 0.03);
      gain.gain.linearRampToValueAtTime(0, at + TONE_S);
      oscillator.connect(gain).connect(context.destination);
      oscillator.start(at);
      oscillator.stop(at + TONE_S);
      at += TONE_S + GAP_S;
    }
  };
  return {
    get armed() {
      // A browser may suspend it again: then it is not armed, whatever was pressed.
      return armed && context?.state === "running";
    },
    async arm() {
      const heard = await wake();
      play("alarm");
      return heard;
    },
    mute() {
      armed = false;
      sessionStorage.removeItem(WANTED);
    },
    play,
  };
}
