// What alarms say, in the person's language: their codes and figures as words. Pure.

import type { Alarm, AlarmSaying, ChartDifference } from "../api/types.gen";
import { utc } from "../ui/format";
import { fromServer, t } from "../words/words";

const STATES: Readonly<Record<string, string>> = { fault: t("fault"), error: t("error"), failure: t("failure") };

/** What is wrong; what an older server kept without codes, as it was kept. */
export function alarmText({ says, text }: Pick<Alarm, "says" | "text">): string {
  return says.length ? says.map(saying).join("; ") : text;
}

/** The advice of an alarm's kind. */
export function adviceOf({ cause, consequence, action }: Alarm): { readonly cause: string; readonly consequence: string; readonly action: string } {
  return { cause: fromServer(cause), consequence: fromServer(consequence), action: fromServer(action) };
}

function saying(one: AlarmSaying): string {
  switch (one.code) {
    case "part":
      return ofPart(one.part, STATES[one.state] ?? one.state, one.words);
    case "no_position":
      return t("no position since {time}", { time: utc(one.since_us, false) });
    case "hydrophone_silent":
      return t("the hydrophone is silent since {time}", { time: utc(one.since_us, false) });
    case "not_heard":
      return t("not heard since {time}", { time: utc(one.since_us, false) });
    case "never_heard":
      return t("not heard since the server started at {day} {time}", dayAndTime(one.since_us));
    case "other_source":
      return t("{peer} sends as this vessel by the transport {transport} and is refused: only the vessel's link is trusted", { peer: one.peer, transport: one.transport });
    case "charge":
      return t("{percent} % charge left", { percent: one.percent });
    case "clock":
      return clock(one.ahead_ms);
    case "chart":
      return chartDiffers(one.held, one.difference);
    case "log_book":
      return `${one.part}: ${one.words}`;
    case "server":
      return one.words;
    case "disk":
      return t("{free} GiB are free on the server's disk", { free: (one.free_mib / 1024).toFixed(1) });
    case "certificate_ends":
      return t("the certificate {file} ends on {day} at {time}", { file: one.file, ...dayAndTime(one.until_us) });
    case "certificate_ended":
      return t("the certificate {file} ended on {day} at {time}", { file: one.file, ...dayAndTime(one.until_us) });
    case "certificate_refused":
      return t("a new certificate cannot be used, the earlier one still is: {words}", { words: one.words });
    case "no_go_areas":
      return t("the no-go areas are not in force: {words}", { words: one.words });
    case "too_many":
      return t("{count} alarms have no place in the list of {most}", { count: one.count, most: one.most });
  }
}

function dayAndTime(us: number): { readonly day: string; readonly time: string } {
  return { day: new Date(us / 1_000).toISOString().slice(0, 10), time: utc(us, false) };
}

/** How a vessel's sea chart differs from the shore's; `held` says whether it has any. */
export function chartDiffers(held: boolean, difference: ChartDifference): string {
  switch (difference.stage) {
    case "other":
      return held ? t("another sea chart than ashore") : t("no sea chart aboard");
    case "fetching": {
      const { percent } = difference;
      return held ? t("another sea chart than ashore; {percent} % of the shore's is transferred", { percent }) : t("no sea chart aboard; {percent} % of the shore's is transferred", { percent });
    }
    case "waiting": {
      const { why } = difference;
      return held ? t("another sea chart than ashore; the shore's is aboard and waits: {why}", { why }) : t("no sea chart aboard; the shore's is aboard and waits: {why}", { why });
    }
    case "failed": {
      const { why } = difference;
      return held ? t("another sea chart than ashore; the chart from shore could not be used: {why}", { why }) : t("no sea chart aboard; the chart from shore could not be used: {why}", { why });
    }
    case "declined":
      return held ? t("another sea chart than ashore; the vessel is set up not to take charts from ashore") : t("no sea chart aboard; the vessel is set up not to take charts from ashore");
    case "none_ashore":
      return held ? t("there is no sea chart ashore to compare the vessel's with") : t("no sea chart aboard and no sea chart ashore");
  }
}

function ofPart(part: string, state: string, words: string): string {
  return words ? `${part}: ${state}: ${words}` : `${part}: ${state}`;
}

function clock(aheadMs: number): string {
  const seconds = (Math.abs(aheadMs) / 1_000).toFixed(1);
  return aheadMs > 0 ? t("the vessel's clock is {seconds} s ahead of the server's", { seconds }) : t("the vessel's clock is {seconds} s behind the server's", { seconds });
}
