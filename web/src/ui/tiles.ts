// Instruments: value, unit and age; hatched and struck when over the contract.

import type { LinkStatus, RouteLeg, System } from "../api/types.gen";
import { chartDiffers } from "../state/alarmwords";
import { LIVENESS } from "../state/card";
import { doing, planStateText, progressText, runs, whyText } from "../state/doing";
import type { Reading, Vitals } from "../state/vitals";
import { transportNames, waysText } from "../state/ways";
import { t, tn } from "../words/words";
import { createDial } from "./dial";
import { make, setAttribute, setText } from "./dom";
import { age, bearing, knots } from "./format";

interface Tile {
  readonly root: HTMLElement;
  readonly value: HTMLElement;
  readonly unit: HTMLElement;
  readonly note: HTMLElement;
  readonly age: HTMLElement;
}

export interface Tiles {
  /** `past`: how old the newest value was, s, at the time in the past that is shown; undefined in the present. */
  update(system: System | undefined, vitals: Vitals, link: LinkStatus | undefined, nowUs: number, linked: boolean, past?: number | null, legs?: readonly RouteLeg[]): void;
}

type Name = "link" | "chart" | "ways" | keyof Vitals;
/** What is read at each look. */
const FIRST: readonly (readonly [Name, string])[] = [
  ["mode", t("State")],
  ["plan", t("Plan")],
  ["progress", t("Progress")],
  ["speed_mps", t("Speed over ground")],
  ["heading_rad", t("Heading")],
  ["battery", t("Battery")],
  ["link", t("Link")],
];
/** What is there for who wants more. */
const FURTHER: readonly (readonly [Name, string])[] = [
  ["chart", t("Sea chart aboard")],
  ["ways", t("Link in use")],
  ["course_rad", t("Course over ground")],
  ["port_rpm", t("Motor port")],
  ["starboard_rpm", t("Motor starboard")],
  ["voltage", t("Lowest voltage")],
  ["snr", t("Last tag")],
];
/** Where the browser keeps whether somebody wants more. */
const KEPT = "lutra-instruments";

/** What each means, where its name does not say it all. */
const MEANS: Readonly<Partial<Record<Name, string>>> = {
  mode: t("Mode reported by the vessel"),
  progress: t("Which maneuver of the plan is sailed, and how many there are"),
  speed_mps: t("Speed over the bottom"),
  heading_rad: t("Direction of the bow, true"),
  course_rad: t("Direction of movement over the bottom, true"),
  battery: t("Charge as the vessel reports it"),
  link: t("How long ago it was heard, by which way, and how long a message takes there and back"),
  chart: t("Whether the vessel holds the chart that the server has"),
  ways: t("Which link carries live values and commands, and why; the tab Link loss has all links"),
  voltage: t("The lowest of its batteries"),
  snr: t("Signal of the last tag above the noise, dB"),
};

/** A reading with more letters than this takes more than one line; with fewer where words beside it must be read too. */
const LONG = 16;
const LONG_BESIDE = 9;
const CHART: Readonly<Record<string, string>> = { same: t("up to date"), waiting: t("waits"), failed: t("not taken"), declined: t("its own"), other: t("another"), none: t("none") };

/** Of a time in the past, the newest value older than this is an old one, s. */
const PAST_FRESH_S = 10;

/** Shows instruments in `root`, with the button for more of them in `head`. */
export function createTiles(root: HTMLElement, head: HTMLElement): Tiles {
  const tiles = new Map<Name, Tile>();
  const add = (list: HTMLElement, [name, title]: readonly [Name, string]): void => {
    const [value, unit, note, old] = [span("reading num"), span("unit"), span("note-line"), span("age num")];
    const main = make("dd", {}, value, unit);
    if (name === "heading_rad") main.append(dial.root);
    const root = make("div", { class: "tile", "data-tile": name }, make("dt", { title: MEANS[name] ?? "" }, title), main, make("dd", { class: "under" }, note, old));
    tiles.set(name, { root, value, unit, note, age: old });
    list.append(root);
  };
  const dial = createDial();
  const list = make("dl", { class: "tiles" });
  for (const one of FIRST) add(list, one);
  const further = make("dl", { class: "tiles further", id: "further" });
  for (const one of FURTHER) add(further, one);
  head.append(more(further));
  root.append(list, further);
  let recorded = false;
  const show = (name: Name, text: string, unit: string, note: string, reading: Pick<Reading, "ageS" | "old">, linked: boolean, alert = ""): void => {
    const tile = tiles.get(name);
    if (!tile) return;
    const told = reading.ageS === null ? "—" : text;
    setText(tile.value, told);
    // Long names of plans stand on several lines in place of being cut off, or of cutting off how it goes.
    setAttribute(tile.value, "data-long", told.length > (name === "plan" && note ? LONG_BESIDE : LONG) ? "" : null);
    setAttribute(tile.value, "title", told.length > LONG ? told : null);
    setText(tile.unit, reading.ageS === null ? "" : unit);
    setText(tile.note, reading.ageS === null ? (recorded ? t("nothing recorded") : t("not reported")) : note);
    setAttribute(tile.note, "title", note || null);
    setText(tile.age, reading.ageS === null ? "" : `${reading.old || !linked ? `${t("old:")} ` : ""}${age(reading.ageS)}`);
    setAttribute(tile.root, "data-old", reading.old || !linked ? "" : null);
    setAttribute(tile.root, "data-alert", alert || null);
  };

  return {
    update(system, vitals, link, nowUs, linked, past, legs) {
      recorded = past !== undefined;
      const { mode, plan, progress, speed_mps, course_rad, heading_rad, port_rpm, starboard_rpm, battery, voltage, snr } = vitals;
      const silence = system ? Math.max(0, (nowUs - system.heard_us) / 1e6) : null;
      const live = system?.liveness === "live" || system?.liveness === "late";
      const trip = link?.up && link.round_trip_s !== null ? `${Math.round(link.round_trip_s * 1_000)} ms` : "";
      const waiting = link?.backlog_records ? tn(link.backlog_records, "one record waits aboard", "{n} records wait aboard") : "";
      const by = system?.transports.length ? t("by {ways}", { ways: transportNames(system.transports) }) : "";
      if (past !== undefined) show("link", "recorded", "", "", { ageS: past, old: (past ?? Infinity) > PAST_FRESH_S }, true);
      else show("link", system ? (linked ? LIVENESS[system.liveness] : t("? not known")) : "", "", [trip, waiting, by].filter(Boolean).join(" · "), { ageS: silence, old: !live }, linked);
      const held = chart(link);
      const told = link?.chart.told_us ?? null;
      const toldS = past !== undefined || told === null ? null : link?.up && live ? (silence ?? 0) : (nowUs - told) / 1e6;
      show("chart", held.word, "", held.note, { ageS: toldS, old: !link?.up || !live }, linked, held.alert);
      const ways = waysText(link);
      tiles.get("ways")?.root.toggleAttribute("hidden", ways === undefined);
      show("ways", ways?.word ?? "", "", ways?.note ?? "", { ageS: ways && past === undefined ? silence : null, old: !ways || !link?.up || !live }, linked, ways?.alert);
      show("mode", doing(mode, plan), "", whyText(mode), mode, linked, mode.word === "ERROR" && whyText(mode) === mode.note ? "bad" : "");
      show("plan", plan.note || t("none"), "", planStateText(plan.word), plan, linked);
      // What was told of the last plan says nothing of one that does not run.
      show("progress", progressText(plan, progress, legs) || t("no plan runs"), "", runs(plan) ? progress.note : "", progress, linked);
      show("speed_mps", bare(knots(speed_mps.value)), "kn", speed_mps.value === null ? "" : `${speed_mps.value.toFixed(2)} m/s`, speed_mps, linked);
      show("course_rad", bearing(course_rad.value), "", course_rad.value === null ? t("not moving") : "", course_rad, linked);
      show("heading_rad", bearing(heading_rad.value), "", "", heading_rad, linked);
      dial.turn(heading_rad.value);
      show("port_rpm", whole(port_rpm.value), "rpm", "", port_rpm, linked);
      show("starboard_rpm", whole(starboard_rpm.value), "rpm", "", starboard_rpm, linked);
      show("battery", battery.value === null ? "—" : battery.value.toFixed(0), "%", "", battery, linked, battery.value !== null && battery.value < 20 ? "warn" : "");
      show("voltage", voltage.value === null ? "—" : voltage.value.toFixed(1), "V", voltage.note, voltage, linked);
      show("snr", snr.value === null ? "—" : snr.value.toFixed(0), "dB", snr.note, snr, linked);
    },
  };
}

/** Shows and hides what is further, but for what needs somebody; the browser keeps which. */
function more(further: HTMLElement): HTMLButtonElement {
  const button = make("button", { type: "button", class: "more-instruments", "aria-controls": "further" }, t("More"));
  const show = (whether: boolean): void => {
    setAttribute(button, "aria-expanded", String(whether));
    setAttribute(further, "data-more", whether ? "" : null);
  };
  button.setAttribute("aria-label", t("More instruments"));
  button.addEventListener("click", () => {
    const whether = button.getAttribute("aria-expanded") !== "true";
    localStorage.setItem(KEPT, whether ? "all" : "first");
    show(whether);
  });
  show(localStorage.getItem(KEPT) === "all");
  return button;
}

/** The chart that the vessel holds: a word, all of it, and whether somebody has to look. */
function chart(link: LinkStatus | undefined): { word: string; note: string; alert: string } {
  if (!link) return { word: "", note: "", alert: "" };
  const { state, edition, digest, difference } = link.chart;
  const word = difference?.stage === "fetching" ? `${difference.percent} %` : (CHART[state] ?? state);
  const holds = edition ? t("holds {edition}", { edition }) : "";
  const differs = difference ? chartDiffers(digest !== null, difference) : t("not known: the vessel has not reported since it was set up, or its program is too old");
  const note = state === "same" ? (edition ?? "") : [differs, holds].filter(Boolean).join("; ");
  return { word, note, alert: state === "failed" ? "bad" : state === "other" || state === "waiting" ? "warn" : "" };
}

function bare(text: string): string {
  return text.replace(" kn", "");
}

function whole(value: number | null): string {
  return value === null ? "—" : String(Math.round(value)).replace("-", "−");
}

function span(kind: string): HTMLSpanElement {
  return make("span", { class: kind });
}
