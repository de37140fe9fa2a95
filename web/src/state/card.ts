// What a vessel's card says: pure.

import type { Alarm, Liveness } from "../api/types.gen";
import { age, bearing, knots, position, systemName } from "../ui/format";
import { t } from "../words/words";
import { type Priority, PRIORITY_WORDS, SHAPES } from "./alarms";
import { alarmText } from "./alarmwords";
import { doing, progressText, runs } from "./doing";
import { tame } from "./foreign";
import type { Listed } from "./order";
import type { Reading } from "./vitals";
import { transportNames } from "./ways";

/** Letters of a vessel's own words on its card. */
const MOST = 240;
/** How many colours there are for vessels. */
const SERIES = 4;
/** A battery below this is told, %. */
const LOW = 20;

/** What stands where a vessel has said nothing. */
export const NOT_REPORTED = t("not reported");

/** Text and shape, as colour alone tells nobody in night colours. */
export const LIVENESS: Readonly<Record<Liveness, string>> = {
  live: t("● live"),
  late: t("◐ late"),
  stale: t("○ stale"),
  lost: t("✕ lost"),
};

/** A text, and whether it is older than its contract. */
export interface CardText {
  readonly text: string;
  readonly old: boolean;
}

export interface Card {
  readonly address: number;
  readonly name: string;
  /** Its name with what it is. */
  readonly title: string;
  /** Which of the colours on the map is its own. */
  readonly series: number;
  readonly liveness: Liveness;
  readonly link: string;
  readonly heard: string;
  readonly doing: CardText;
  readonly plan: CardText;
  readonly progress: CardText;
  readonly speed: CardText;
  readonly heading: CardText;
  readonly battery: CardText & { readonly low: boolean };
  readonly place: CardText;
  readonly placeAge: CardText;
  /** The worst that is wrong, or how its parts are. */
  readonly worst: { readonly text: string; readonly quiet: boolean };
}

/** `linked`: whether the server is heard; without it nobody knows how anything is. */
export function cardOf({ system, placeIsOld, placeS, vitals, parts, alarm, legs }: Listed, nowUs: number, linked: boolean): Card {
  const { mode, plan, progress, battery } = vitals;
  const { fix } = system;
  const of = (reading: Reading, text: string): CardText => told(reading.ageS === null ? NOT_REPORTED : text, reading.ageS !== null && (reading.old || !linked));
  const old = placeIsOld || system.liveness === "stale" || system.liveness === "lost";
  const here = (text: string | undefined): CardText => told(text ?? "—", fix !== null && (old || !linked));
  const said = alarm ? alarmLine(alarm) : "";
  const heardS = Math.max(0, (nowUs - system.heard_us) / 1e6);
  const never = !system.heard_us;
  return {
    address: system.address,
    name: systemName(system),
    title: tame(system.kind ? `${systemName(system)} · ${system.kind}` : systemName(system), MOST),
    series: (system.address % SERIES) + 1,
    liveness: linked ? system.liveness : "lost",
    link: !linked ? t("? not known") : never ? t("○ not heard") : LIVENESS[system.liveness],
    heard: never ? t("not heard since the server started") : tame(system.transports.length ? t("heard {age} ago by {ways}", { age: age(heardS), ways: transportNames(system.transports) }) : t("heard {age} ago", { age: age(heardS) }), MOST),
    doing: told(doing(mode, plan), mode.ageS !== null && (mode.old || !linked)),
    plan: told(runs(plan) ? plan.note : "", plan.old || !linked),
    progress: told(progressText(plan, progress, legs, t("progress not reported")), plan.old || !linked),
    speed: here(fix ? knots(fix.speed_mps) : undefined),
    heading: here(fix ? bearing(fix.heading_rad) : undefined),
    battery: { ...(never ? told("—", false) : of(battery, battery.value === null ? "—" : `${battery.value.toFixed(0)} %`)), low: battery.value !== null && battery.value < LOW },
    place: here(fix ? `${position(fix)}${old ? ` ${t("(old)")}` : ""}` : t("no position")),
    placeAge: here(fix && placeS !== null ? age(placeS) : undefined),
    worst: { text: tame(said || `${parts.bad ? "▲ " : ""}${parts.text}`, MOST), quiet: !said && !parts.bad },
  };
}

/** An alarm by its priority; whether it is over stands before its words, which may be cut off. */
function alarmLine(alarm: Alarm): string {
  const priority = alarm.priority as Priority;
  const over = alarm.state === "returned" ? ` (${t("over")})` : "";
  return `${SHAPES[priority] ?? ""} ${PRIORITY_WORDS[priority] ?? priority}${over}: ${alarmText(alarm)}`;
}

/** The alarm that a vessel's card tells, of what is told of all: one that is active before one that is over. */
export function alarmOf(all: readonly Alarm[], vessel: number): Alarm | undefined {
  const own = all.filter((one) => one.vessel === vessel);
  return own.find(({ state }) => state !== "returned") ?? own[0];
}

function told(text: string, old: boolean): CardText {
  return { text: tame(text, MOST), old };
}

/** Cards in the places that they had, while somebody is among them; those that are new come last. */
export function inPlaces<C extends { readonly address: number }>(cards: readonly C[], places: readonly number[]): C[] {
  const place = ({ address }: C): number => (places.includes(address) ? places.indexOf(address) : places.length);
  return [...cards].sort((one, other) => place(one) - place(other));
}
