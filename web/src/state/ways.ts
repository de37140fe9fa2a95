// The links of a vessel that has several, in words: which carries what, why, and how each is.

import type { LinkStatus, LinkWay, LinkWays } from "../api/types.gen";
import { t } from "../words/words";

export interface WaysText {
  /** The link of live values and commands. */
  readonly word: string;
  readonly note: string;
  readonly alert: "" | "warn" | "bad";
}

const WHY: Readonly<Record<string, string>> = {
  only: t("the first that was up"),
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

/** Of a vessel with several links; undefined of any other. `linked`: whether the page has its link to the server. */
export function waysText(link: LinkStatus | undefined): WaysText | undefined {
  const ways = link?.ways;
  if (!ways) return undefined;
  const live = at(ways, ways.live);
  const why = live ? (WHY[ways.live_why] ?? "") : "";
  const records = at(ways, ways.records);
  const kept = records === live ? "" : records ? t("records by {way}", { way: records.name }) : t("records wait aboard");
  const note = [why, kept].filter(Boolean).join(" · ");
  const alert = !live ? "bad" : live.thinning !== "nothing" || ways.ways.some((way) => way.state !== "up") ? "warn" : "";
  return { word: live?.name ?? t("none"), note, alert };
}

/** One link in the words of a table's row; what is not known is a dash. */
export interface WayRow {
  readonly name: string;
  readonly state: string;
  readonly good: boolean;
  /** What goes by it now. */
  readonly carries: string;
  readonly trip: string;
  readonly late: string;
  readonly rate: string;
  /** Bytes of the day, and what is left out because of them. */
  readonly today: string;
}

/** All links of a vessel with several, in the order of its settings; empty of any other. */
export function wayRows(link: LinkStatus | undefined, linked = true): WayRow[] {
  const ways = link?.ways;
  if (!ways) return [];
  return ways.ways.map((way, place) => (linked ? row(way, place === ways.live, place === ways.records) : unknown(way)));
}

/** While the page has no link it does not know how they are. */
function unknown(way: LinkWay): WayRow {
  return { name: way.name, state: t("not known"), good: false, carries: "—", trip: "—", late: "—", rate: "—", today: mb(way) };
}

function row(way: LinkWay, live: boolean, records: boolean): WayRow {
  const good = way.state === "up";
  return {
    name: way.name,
    state: good ? t("up") : way.state === "suspect" ? t("does not answer") : t("down"),
    good,
    carries: [live ? t("live values, commands") : "", records ? t("records") : ""].filter(Boolean).join(", ") || t("standby"),
    trip: good && way.round_trip_ms !== null ? `${way.round_trip_ms} ms` : "—",
    late: good ? `${Math.round(way.late_per_mille / 10)} %` : "—",
    rate: good && way.rate_bytes_per_s !== null ? `${Math.round(way.rate_bytes_per_s / 1_000)} kB/s` : "—",
    today: [mb(way), THINNED[way.thinning]].filter(Boolean).join("; "),
  };
}

function mb({ today_bytes, daily_bytes }: LinkWay): string {
  const written = (bytes: number): string => (bytes / 1e6).toFixed(1);
  return daily_bytes === null ? `${written(today_bytes)} MB` : t("{mb} of {of} MB", { mb: written(today_bytes), of: written(daily_bytes) });
}

function at(ways: LinkWays, place: number | null): LinkWay | undefined {
  return place === null ? undefined : ways.ways[place];
}

/** By which ways a vessel is heard, as people name them. */
export function transportNames(transports: readonly string[]): string {
  return transports.map((one) => (one === "link" ? t("link") : one)).join(", ");
}
