// The ways of a vessel to the server in words: which carries what, why, and how each is.

import type { LinkStatus, LinkWay, LinkWays } from "../api/types.gen";
import { t } from "../words/words";

export interface WaysText {
  /** The way of live values and commands. */
  readonly word: string;
  readonly note: string;
  readonly alert: "" | "warn" | "bad";
}

const WHY: Readonly<Record<string, string>> = {
  only: t("the first that stood"),
  better: t("the fastest"),
  cheaper: t("the cheapest"),
  failover: t("another stopped answering"),
  budget: t("another has used its bytes of the day"),
};
const THINNED: Readonly<Record<string, string>> = {
  records: t("no records today"),
  most: t("only position, alarms and answers today"),
  all_but_last: t("its bytes of the day are used"),
};

/** Of a vessel with several ways; undefined of any other. */
export function waysText(link: LinkStatus | undefined): WaysText | undefined {
  const ways = link?.ways;
  if (!ways) return undefined;
  const live = at(ways, ways.live);
  const why = live ? (WHY[ways.live_why] ?? "") : "";
  const records = at(ways, ways.records);
  const kept = records === live ? "" : records ? t("records by {way}", { way: records.name }) : t("records wait aboard");
  const note = [why, kept, ...ways.ways.map(wayText)].filter(Boolean).join("; ");
  const alert = !live ? "bad" : live.thinning !== "nothing" || ways.ways.some((way) => way.state !== "up") ? "warn" : "";
  return { word: live?.name ?? t("none"), note, alert };
}

/** One way: how it is, and what it has carried today. */
export function wayText(way: LinkWay): string {
  const state = way.state === "down" ? t("down") : way.state === "suspect" ? t("does not answer") : "";
  const trip = way.state === "up" && way.round_trip_ms !== null ? `${way.round_trip_ms} ms` : "";
  const late = way.state === "up" && way.late_per_mille >= 10 ? t("{percent} % late", { percent: Math.round(way.late_per_mille / 10) }) : "";
  const rate = way.state === "up" && way.rate_bytes_per_s !== null ? `${Math.round(way.rate_bytes_per_s / 1_000)} kB/s` : "";
  const mb = (bytes: number): string => (bytes / 1e6).toFixed(1);
  const today = way.daily_bytes === null ? t("{mb} MB today", { mb: mb(way.today_bytes) }) : t("{mb} of {of} MB today", { mb: mb(way.today_bytes), of: mb(way.daily_bytes) });
  const thinned = THINNED[way.thinning] ?? "";
  return `${way.name}: ${[state, trip, late, rate, today, thinned].filter(Boolean).join(", ")}`;
}

function at(ways: LinkWays, place: number | null): LinkWay | undefined {
  return place === null ? undefined : ways.ways[place];
}
