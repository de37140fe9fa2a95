// What tells whether the page shows the present or the past, and plays the past: clock, scrub bar, speed, steps.

import type { Range } from "../plot/model";
import { make, setAttribute, setText } from "../ui/dom";
import { t } from "../words/words";
import { FAR_US, type Playback, SPEEDS, STEP_US } from "./clock";

/** The scrub bar has so many places. */
const PLACES = 10_000;

export interface BarHandlers {
  /** Out of the present, into the past. */
  enter(): void;
  live(): void;
  toggle(): void;
  seek(us: number): void;
  step(byUs: number): void;
  speed(factor: number): void;
}

export interface Bar {
  /** `hoverUs`: a time that is pointed to. `nowUs`: of the server. `fresh`: whether the vessel is heard
   * now. `trouble`: why the values are not those of the time. */
  update(range: Range, play: Playback | null, hoverUs: number | null, nowUs: number, fresh: boolean, trouble: string): void;
  /** Puts the focus on playing. */
  focus(): void;
}

export function createBar(root: HTMLElement, handlers: BarHandlers): Bar {
  const badge = make("strong", { class: "badge" });
  const [day, time] = [make("span", { class: "day" }), make("span")];
  const clock = make("span", { class: "clock num" }, day, time);
  const note = make("span", { class: "dim", role: "status" });
  const button = (text: string, label: string, act: () => void): HTMLButtonElement => {
    const made = make("button", { type: "button", "aria-label": label, title: label }, text);
    made.addEventListener("click", act);
    return made;
  };
  const play = button("▶", t("Play"), handlers.toggle);
  const scrub = make("input", { type: "range", class: "scrub", min: "0", max: String(PLACES), step: "1", "aria-label": t("Time. Left and right step by a second, with Shift by ten; space plays.") });
  const speed = make("select", { "aria-label": t("Speed") }, ...SPEEDS.map((one) => make("option", { value: String(one) }, `${one}×`)));
  const past = make("span", { class: "transport", role: "group", "aria-label": t("Replay") },
    button("−1 s", t("−1 s, step back"), () => handlers.step(-STEP_US)),
    play,
    button("+1 s", t("+1 s, step forward"), () => handlers.step(STEP_US)),
    speed,
    scrub,
  );
  const enter = button(t("Replay"), t("Replay what is shown"), handlers.enter);
  const live = button(t("Back to live"), t("Back to live"), handlers.live);
  live.className = "back";
  root.append(make("div", { class: "replaybar" }, badge, clock, note, past, enter, live));

  let ends = { fromUs: 0, toUs: 1 };
  scrub.addEventListener("input", () => handlers.seek(ends.fromUs + (Number(scrub.value) / PLACES) * (ends.toUs - ends.fromUs)));
  scrub.addEventListener("keydown", (event) => {
    const by = event.key === "ArrowRight" || event.key === "ArrowUp" ? 1 : event.key === "ArrowLeft" || event.key === "ArrowDown" ? -1 : 0;
    if (by) handlers.step(by * (event.shiftKey ? FAR_US : STEP_US));
    else if (event.key === " ") handlers.toggle();
    else return;
    event.preventDefault();
    event.stopPropagation();
  });
  speed.addEventListener("change", () => handlers.speed(Number(speed.value)));

  return {
    update(range, playback, hoverUs, nowUs, fresh, trouble) {
      const shown = playback?.playing ? playback.atUs : (hoverUs ?? playback?.atUs ?? nowUs);
      setAttribute(root, "data-time", playback ? "replay" : hoverUs !== null ? "cursor" : fresh ? "live" : "now");
      setText(badge, playback ? t("REPLAY") : hoverUs !== null ? t("AS OF") : fresh ? t("LIVE") : t("NOW"));
      const [date = "", ofDay = ""] = fine(shown, playback !== null && playback.speed < 1).split(" ");
      setText(day, `${date} `);
      setText(time, ofDay);
      setText(note, trouble);
      setAttribute(past, "hidden", playback ? null : "");
      setAttribute(live, "hidden", playback ? null : "");
      setAttribute(enter, "hidden", playback ? "" : null);
      if (!playback || !("fromUs" in range)) return;
      ends = range;
      setText(play, playback.playing ? "❚❚" : "▶");
      setAttribute(play, "aria-label", playback.playing ? t("Pause") : t("Play"));
      setAttribute(play, "title", playback.playing ? t("Pause") : t("Play"));
      scrub.value = String(Math.round(((playback.atUs - ends.fromUs) / Math.max(1, ends.toUs - ends.fromUs)) * PLACES));
      setAttribute(scrub, "aria-valuetext", fine(playback.atUs, false));
      if (document.activeElement !== speed) speed.value = String(playback.speed);
    },
    focus: () => play.focus(),
  };
}

/** A time, UTC, with tenths of a second where they pass slowly. */
function fine(us: number, tenths: boolean): string {
  const iso = new Date(us / 1_000).toISOString();
  return `${iso.slice(0, 10)} ${iso.slice(11, tenths ? 21 : 19)}Z`;
}
