// What is wrong, gathered from frames.

import type { Alarm, LiveFrame } from "../api/types.gen";
import { utc } from "../ui/format";
import { alarmText } from "./alarmwords";
import { t } from "../words/words";

export type Alarms = ReadonlyMap<number, Alarm>;

export const NO_ALARMS: Alarms = new Map();

/** The most urgent first. */
export const PRIORITIES = ["emergency", "alarm", "warning", "caution"] as const;
export type Priority = (typeof PRIORITIES)[number];

/** A priority in words. */
export const PRIORITY_WORDS: Readonly<Record<Priority, string>> = { emergency: t("emergency"), alarm: t("alarm"), warning: t("warning"), caution: t("caution") };

/** Shape beside the colour: diamond, triangle, circle, square. */
export const SHAPES: Readonly<Record<Priority, string>> = { emergency: "◆", alarm: "▲", warning: "●", caution: "■" };

/** The alarms after a frame. */
export function withAlarms(alarms: Alarms, frame: LiveFrame): Alarms {
  if (!frame.snapshot && !frame.alarms.length) return alarms;
  const next = new Map(frame.snapshot ? [] : alarms);
  for (const alarm of frame.alarms) {
    if (alarm.state === "normal" && !alarm.shelved) next.delete(alarm.id);
    else next.set(alarm.id, alarm);
  }
  return next;
}

export function rank(alarm: Alarm): number {
  const at = (PRIORITIES as readonly string[]).indexOf(alarm.priority);
  return at < 0 ? PRIORITIES.length : at;
}

/** What is told, the most urgent first: unacknowledged before acknowledged, then the newest. */
export function told(alarms: Alarms): Alarm[] {
  const shown = [...alarms.values()].filter((one) => one.state !== "normal" && !one.shelved && !one.collapsed);
  const open = (one: Alarm): number => (one.state === "unacknowledged" ? 0 : one.state === "returned" ? 2 : 1);
  return shown.sort((one, other) => rank(one) - rank(other) || open(one) - open(other) || other.since_us - one.since_us);
}

/** How many of each priority are told. */
export function counts(shown: readonly Alarm[]): Readonly<Record<Priority, number>> {
  const all = { emergency: 0, alarm: 0, warning: 0, caution: 0 };
  for (const one of shown) if (one.priority in all) all[one.priority as Priority] += 1;
  return all;
}

/** The most urgent priority that is to be heard now: what sounded again since `before`. */
export function newlySounding(before: Alarms, now: Alarms): Priority | undefined {
  const louder = [...now.values()].filter((one) => one.wants_acknowledgement && one.state === "unacknowledged" && one.sounded > (before.get(one.id)?.sounded ?? 0));
  const worst = louder.sort((one, other) => rank(one) - rank(other))[0];
  return worst ? (worst.priority as Priority) : undefined;
}

/** Without the server for so long, the page is grey and nobody would hear of an alarm: that is told by a sound, ms. */
export const DEAF_MS = 3_000;
/** And sounds again after this, as long as it is not heard, ms. */
export const DEAF_AGAIN_MS = 30_000;

/** What the bar says. `deafUs`: when the server was heard last, if it is not heard any more; null for never. */
export function barText(top: Alarm | undefined, shelved: number, deafUs?: number | null): string {
  const known = top ? `${top.vessel_name ?? t("Server")}: ${alarmText(top)}${returned(top)}` : shelved ? t("No alarms; {shelved} shelved", { shelved }) : t("No alarms");
  if (deafUs === undefined) return known;
  if (deafUs === null) return t("Alarms unknown: the server is not reached");
  return t("Alarms unknown since {time}: the server is not reached. Last known: {known}", { time: utc(deafUs, false), known });
}

/** What is said of an alarm that is over and that nobody acknowledged. */
function returned({ state, over_us }: Alarm): string {
  if (state !== "returned") return "";
  return `; ${over_us === null ? t("over, not acknowledged") : t("over since {time}, not acknowledged", { time: utc(over_us, false) })}`;
}

/** From when to when it was wrong, or since when it is. */
export function whenText({ since_us, over_us }: Pick<Alarm, "since_us" | "over_us">): string {
  return over_us === null ? t("since {time}", { time: utc(since_us) }) : t("from {since} to {over}", { since: utc(since_us), over: utc(over_us, false) });
}

/** The words for where an alarm is. */
export function stateText(alarm: Alarm): string {
  if (alarm.shelved) return t("shelved by {by}: {reason}", { by: alarm.shelved.by, reason: alarm.shelved.reason });
  if (alarm.collapsed) return t("part of another alarm");
  if (alarm.priority === "caution") return alarm.state === "returned" ? t("over") : t("active; no acknowledgement needed");
  if (alarm.state === "acknowledged") return alarm.acknowledged ? t("acknowledged by {by}", { by: alarm.acknowledged.by }) : t("acknowledged");
  return alarm.state === "returned" ? t("over, NOT ACKNOWLEDGED") : t("NOT ACKNOWLEDGED");
}
