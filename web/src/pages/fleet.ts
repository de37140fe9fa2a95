// The first page: the map, and the vessels beside it.

import { getJson } from "../api/http";
import type { System, TrackPoint } from "../api/types.gen";
import { createPlansUnderWay } from "../api/underway";
import { createMap, type FleetMap } from "../map/map";
import { told } from "../state/alarms";
import { alarmOf } from "../state/card";
import { runs } from "../state/doing";
import { asSeen, EMPTY, type FleetState, placeCameUs, placeIsOld, serverNowUs } from "../state/fleet";
import { type Listed, unheard } from "../state/order";
import { Track } from "../state/track";
import { entities, GLANCE, partsInWords, vitals, worst } from "../state/vitals";
import { type Chrome, createChrome } from "../ui/chrome";
import { make } from "../ui/dom";
import { isShore, systemName } from "../ui/format";
import { createList } from "../ui/list";
import { t } from "../words/words";

/** A frame comes so often, ms, and is drawn: vessels move a metre or two meanwhile. */
const EVERY_MS = 500;
/** Without frames all is drawn again so often, ms: what is known grows older. */
const AGES_MS = 1_000;
/** How much of the past is drawn at first, µs. */
const PAST_US = 3_600_000_000;

export function startFleet(root: HTMLElement): void {
  const names = JSON.parse(root.dataset["names"] ?? "{}") as Record<string, string>;
  const mapBox = make("div", { class: "map", tabindex: "0", role: "application", "aria-label": t("Map. Arrow keys move it, plus and minus zoom; the list of vessels tells the same.") });
  const listBox = make("section", { class: "panel list", "aria-label": t("Vessels") });
  root.append(make("div", { class: "map-box" }, mapBox), listBox);
  const page = new FleetPage(mapBox, listBox, names);
  let due = false;
  let drawnMs = -Infinity;
  const draw = (): void => {
    due = false;
    drawnMs = performance.now();
    chrome.draw("tables", () => page.drawTables(chrome));
    chrome.draw("map", () => page.follow());
  };
  const chrome = createChrome({ messages: [...GLANCE], events: false, every_ms: EVERY_MS }, {
    frame(now) {
      page.take(now);
      // Once in a picture; a page that is behind others has none.
      if (!due) requestAnimationFrame(draw);
      due = true;
    },
    lost: () => page.lost(chrome),
  });
  window.setInterval(() => performance.now() - drawnMs >= AGES_MS && draw(), AGES_MS);
  page.onSelect = () => page.drawTables(chrome);
}

class FleetPage {
  private state = EMPTY;
  private linked = true;
  private selected: number | undefined;
  /** Whether a person chose it. */
  private byPerson = false;
  /** Systems that were heard while this page was open. */
  private readonly met = new Set<number>();
  private readonly tracks = new Map<number, Track>();
  private readonly underWay = createPlansUnderWay();
  private readonly map: FleetMap;
  private readonly list: ReturnType<typeof createList>;
  /** A person chose another vessel. */
  onSelect: () => void = () => undefined;

  constructor(mapBox: HTMLElement, listBox: HTMLElement, private readonly names: Readonly<Record<string, string>>) {
    const select = (address: number): void => this.select(address);
    [this.map, this.list] = [createMap(mapBox, { select }), createList(listBox, select)] as const;
  }

  take(now: FleetState): void {
    this.linked = true;
    this.state = now;
  }

  lost(chrome: Chrome): void {
    this.linked = false;
    this.drawTables(chrome);
    this.drawMap();
  }

  /** Draws where all are, with the way there. */
  follow(): void {
    for (const system of this.state.systems.values()) this.track(system);
    this.drawMap();
  }

  drawMap(): void {
    const { state, linked, selected } = this;
    const nowUs = serverNowUs(state, performance.now());
    this.map.update(this.systems().map((system) => asSeen(system, state.values.get(system.address), nowUs, linked)), selected, nowUs);
  }

  drawTables(chrome: Chrome): void {
    const nowUs = serverNowUs(this.state, performance.now());
    const known = this.systems();
    for (const system of known) if (!isGone(system)) this.met.add(system.address);
    const before = known.find((system) => system.address === this.selected);
    if (!this.byPerson && (!before || (isGone(before) && !this.isOurs(before)))) this.selected = this.firstOf(known)?.address ?? this.selected;
    this.list.update(known.map((system) => this.listed(system, nowUs, chrome)), this.selected, nowUs, this.linked);
    const chosen = known.find((system) => system.address === this.selected);
    // A stranger that is gone does not come to where the STOP of a vessel of these people is looked for.
    chrome.stop?.target(chosen && (this.isOurs(chosen) || this.met.has(chosen.address)) ? { address: chosen.address, name: systemName(chosen) } : undefined);
  }

  private select(address: number): void {
    this.selected = address;
    this.byPerson = true;
    this.drawMap();
    this.onSelect();
  }

  private systems(): System[] {
    const { state, names } = this;
    return (
      [
        // The server's own words and those of its people make no vessel.
        ...[...state.systems.values()].filter((system) => !isShore(system)),
        // A vessel with a name is there before it is heard; while nothing is known of the fleet at all, nothing is said.
        ...Object.entries(names).flatMap(([address, name]) => (state.serverUs && !state.systems.has(Number(address)) ? [unheard(Number(address), name)] : [])),
      ]
        .map((system) => ({ ...system, name: names[String(system.address)] ?? system.name }))
        .sort((one, other) => systemName(one).localeCompare(systemName(other)))
    );
  }

  private isOurs(system: System): boolean {
    return String(system.address) in this.names;
  }

  /** The vessel that is shown while nobody has chosen: one with a name from people before others, one that is heard before one that is not. */
  private firstOf(known: readonly System[]): System | undefined {
    const rank = (system: System): number => (this.isOurs(system) ? 4 : 0) + (isGone(system) ? 0 : 2) + (system.fix ? 1 : 0);
    const best = Math.max(...known.map(rank));
    return known.find((system) => rank(system) === best && (this.isOurs(system) || !isGone(system)));
  }

  private listed(system: System, nowUs: number, chrome: Chrome): Listed {
    const values = this.state.values.get(system.address);
    const [known, label] = [values ?? new Map(), labels(system)];
    const [parts, read, came] = [entities(known, label, nowUs), vitals(known, label, nowUs), placeCameUs(known)];
    return {
      system,
      ours: this.isOurs(system),
      placeIsOld: placeIsOld(values, nowUs),
      placeS: came === null ? null : Math.max(0, (nowUs - came) / 1e6),
      vitals: read,
      worst: worst(parts),
      parts: partsInWords(parts),
      alarm: alarmOf(told(chrome.alarms()), system.address),
      legs: this.underWay.legs(system.address, runs(read.plan) ? read.plan.note : ""),
    };
  }

  private track(system: System): void {
    if (!system.fix) return;
    let track = this.tracks.get(system.address);
    if (!track) {
      track = new Track();
      this.tracks.set(system.address, track);
      void this.past(system.address, track, system.fix.time_us);
    }
    if (track.add(system.fix)) this.map.track(system.address, track.all());
  }

  private async past(address: number, track: Track, nowUs: number): Promise<void> {
    const query = `from_us=${Math.round(nowUs - PAST_US)}&to_us=${Math.round(nowUs)}`;
    try {
      track.recorded(await getJson<TrackPoint[]>(`/api/v1/vessels/${address}/track?${query}`));
      this.map.track(address, track.all());
    } catch {
      // Without a history the track begins now.
    }
  }
}

function isGone(system: System): boolean {
  return system.liveness === "lost" || system.liveness === "stale";
}

function labels(system: System): Map<number, string> {
  return new Map(Object.entries(system.entities).map(([number, label]) => [Number(number), label ?? ""]));
}
