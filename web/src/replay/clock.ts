// The time that the page stands at while it does not follow the present: playing, stepping, and its address. Pure.

import { ends, isLive, type Range, SHORTEST_US } from "../plot/model";

/** Playing at a time; there is none while the page follows the present. */
export interface Playback {
  /** By the vessel's clock, µs since 1970 UTC. */
  readonly atUs: number;
  /** Times as fast as it was. */
  readonly speed: number;
  readonly playing: boolean;
}

export const SPEEDS: readonly number[] = [0.1, 0.25, 0.5, 1, 2, 5, 10, 20, 50, 100];
/** What a step is, µs. */
export const STEP_US = 1_000_000;
export const FAR_US = 10_000_000;
/** Around a time that is given alone, µs. */
const AROUND_US = 450_000_000;

/** The playback that belongs to a range: none while it follows the present, within it otherwise. */
export function within(play: Playback | null, range: Range, speed = 1): Playback | null {
  if (isLive(range)) return null;
  const { fromUs, toUs } = range;
  if (!play) return { atUs: toUs, speed, playing: false };
  return { ...play, atUs: Math.round(Math.min(toUs, Math.max(fromUs, play.atUs))) };
}

/** After `ms` of the watcher's time; it stops at the end of the range. */
export function advanced(play: Playback, ms: number, toUs: number): Playback {
  if (!play.playing) return play;
  const atUs = play.atUs + Math.max(0, ms) * 1_000 * play.speed;
  return atUs >= toUs ? { ...play, atUs: toUs, playing: false } : { ...play, atUs };
}

/** Plays, or pauses; from the end it starts over. */
export function toggled(play: Playback, range: Range): Playback {
  const { fromUs, toUs } = ends(range, play.atUs);
  return { ...play, playing: !play.playing, atUs: !play.playing && play.atUs >= toUs ? fromUs : play.atUs };
}

/** The range lengthened or shortened about the time, which stays where it is in it; it does not reach beyond the present. */
export function zoomedAbout(range: { readonly fromUs: number; readonly toUs: number }, atUs: number, factor: number, nowUs: number): Range {
  const by = Math.max(factor, SHORTEST_US / (range.toUs - range.fromUs));
  const fromUs = Math.max(0, Math.floor(atUs - (atUs - range.fromUs) * by));
  const toUs = Math.ceil(atUs + (range.toUs - atUs) * by);
  return { fromUs, toUs: Math.max(fromUs + SHORTEST_US, Math.min(toUs, Math.max(range.toUs, Math.round(nowUs)))) };
}

/** What stands in an address. */
export interface Asked {
  readonly range: Range;
  readonly play: Playback | null;
}

/** The range and time that an address asks for; without any, the last `spanUs` as they go on. */
export function fromAddress(query: URLSearchParams, spanUs: number): Asked {
  const number = (name: string): number => (/^\d+(\.\d+)?$/.test(query.get(name) ?? "") ? Number(query.get(name)) : NaN);
  const [span, from, to, t] = [number("span"), number("from"), number("to"), number("t")];
  const speed = SPEEDS.find((one) => one === number("speed")) ?? 1;
  const range: Range =
    from >= 0 && from < to ? { fromUs: from, toUs: to }
    : span >= 1 ? { spanUs: span * 1e6 }
    : t > 0 ? { fromUs: Math.max(0, t - AROUND_US), toUs: t + AROUND_US }
    : { spanUs };
  return { range, play: within(t > 0 ? { atUs: t, speed, playing: false } : null, range, speed) };
}

/** The same the other way. */
export function toAddress({ range, play }: Asked): URLSearchParams {
  const query = new URLSearchParams();
  if (isLive(range)) query.set("span", String(Math.round(range.spanUs / 1e6)));
  else {
    query.set("from", String(range.fromUs));
    query.set("to", String(range.toUs));
  }
  if (play) {
    query.set("t", String(Math.round(play.atUs)));
    query.set("speed", String(play.speed));
  }
  return query;
}
