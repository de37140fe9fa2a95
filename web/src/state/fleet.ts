// The fleet as the browser knows it: a pure function from frames to state.

import type { LiveFrame, System, Update } from "../api/types.gen";

/** Events that are kept to be shown. */
const EVENTS = 200;

export interface FleetState {
  readonly systems: ReadonlyMap<number, System>;
  /** By system, then by message, entity and instance. */
  readonly values: ReadonlyMap<number, ReadonlyMap<string, Update>>;
  readonly events: readonly Update[];
  /** Values that newer ones replaced before they were sent. */
  readonly skipped: number;
  readonly eventsMissed: number;
  /** Why nothing is recorded; null while all is well. */
  readonly recording: string | null;
  /** The server's clock when the last frame came, µs since 1970 UTC. */
  readonly serverUs: number;
  /** This browser's steady clock when that was so, ms. */
  readonly atMs: number;
}

export const EMPTY: FleetState = {
  systems: new Map(),
  values: new Map(),
  events: [],
  skipped: 0,
  eventsMissed: 0,
  recording: null,
  serverUs: 0,
  atMs: 0,
};

/** Tells the series of a system apart. */
export function seriesKey(update: Update): string {
  return `${update.abbrev}/${update.entity}/${update.instance ?? ""}`;
}

/** The state after a frame that came at `atMs`. */
export function withFrame(state: FleetState, frame: LiveFrame, atMs: number): FleetState {
  const values = new Map(frame.snapshot ? [] : state.values);
  const touched = new Map<number, Map<string, Update>>();
  for (const update of frame.values) {
    let series = touched.get(update.system);
    if (!series) {
      series = new Map(values.get(update.system) ?? []);
      touched.set(update.system, series);
      values.set(update.system, series);
    }
    series.set(seriesKey(update), update);
  }
  const events = frame.snapshot ? frame.events : [...state.events, ...frame.events];
  return {
    systems: new Map([...(frame.snapshot ? [] : state.systems), ...frame.systems.map((system) => [system.address, system] as const)]),
    values,
    events: events.slice(-EVENTS),
    skipped: state.skipped + frame.skipped,
    eventsMissed: state.eventsMissed + frame.events_missed,
    recording: frame.recording,
    serverUs: frame.now_us,
    atMs,
  };
}

/** The server's clock at `nowMs`, µs since 1970 UTC: its last word and the time that passed here since. */
export function serverNowUs(state: FleetState, nowMs: number): number {
  return state.serverUs + (nowMs - state.atMs) * 1_000;
}

/** Seconds since this value came. */
export function ageS(update: Update, nowUs: number): number {
  return Math.max(0, (nowUs - update.received_us) / 1e6);
}

/** What tells where a system is, the best first. */
const PLACES = ["EstimatedState", "GpsFix", "Announce"];

/** Whether the place of a system is no longer reported; not known where nothing of it was heard here. */
export function placeIsOld(values: ReadonlyMap<string, Update> | undefined, nowUs: number): boolean {
  const all = [...(values?.values() ?? [])];
  for (const abbrev of PLACES) {
    const told = all.filter((update) => update.abbrev === abbrev);
    if (told.length) return told.every((update) => ageS(update, nowUs) > freshForS(update));
  }
  return false;
}

/** When a system's place came last, by the server's clock, µs since 1970 UTC; null where none was heard here. */
export function placeCameUs(values: ReadonlyMap<string, Update>): number | null {
  const all = [...values.values()];
  const told = PLACES.map((abbrev) => all.filter((update) => update.abbrev === abbrev)).find(({ length }) => length);
  return told ? Math.max(...told.map(({ received_us }) => received_us)) : null;
}

/** A system as it may be drawn: without the server nothing is known, and a place that is no longer reported is old. */
export function asSeen(system: System, values: ReadonlyMap<string, Update> | undefined, nowUs: number, linked: boolean): System {
  if (!linked) return { ...system, liveness: "lost" };
  const heard = system.liveness === "live" || system.liveness === "late";
  return heard && placeIsOld(values, nowUs) ? { ...system, liveness: "stale" } : system;
}

/** After so many seconds a value is old: three of its usual intervals, within bounds. */
export function freshForS(update: Pick<Update, "period_s">): number {
  return update.period_s === null ? 10 : Math.min(60, Math.max(2, 3 * update.period_s));
}
