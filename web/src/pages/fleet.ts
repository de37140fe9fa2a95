// The first page: the map, and the vessels beside it.

import { getJson } from "../api/http";
import type { System, TrackPoint } from "../api/types.gen";
import { createPlansUnderWay } from "../api/underway";
import { createMap } from "../map/map";
import { told } from "../state/alarms";
import { runs } from "../state/doing";
import { asSeen, EMPTY, placeCameUs, placeIsOld, serverNowUs } from "../state/fleet";
import { type Listed, unheard } from "../state/order";
import { Track } from "../state/track";
import { entities, GLANCE, partsInWords, vitals, worst } from "../state/vitals";
import { createChrome } from "../ui/chrome";
import { make } from "../ui/dom";
import { isShore, systemName } from "../ui/format";
import { createList } from "../ui/list";

/** The list is drawn anew so often, ms; the map at each frame. */
const TABLES_MS = 250;
/** A frame comes so often, ms: vessels move a metre meanwhile. */
const EVERY_MS = 250;
/** How much of the past is drawn at first, µs. */
const PAST_US = 3_600_000_000;

export function startFleet(root: HTMLElement): void {
  const names = JSON.parse(root.dataset["names"] ?? "{}") as Record<string, string>;
  const mapBox = make("div", { class: "map", tabindex: "0", role: "application", "aria-label": "Map. Arrow keys move it, plus and minus zoom; the list of vessels tells the same." });
  const listBox = make("section", { class: "panel list", "aria-label": "Vessels" });
  root.append(make("div", { class: "map-box" }, mapBox), listBox);

  let state = EMPTY;
  let linked = true;
  let selected: number | undefined;
  /** Whether a person chose it. */
  let byPerson = false;
  /** Systems that were heard while this page was open. */
  const met = new Set<number>();
  const tracks = new Map<number, Track>();
  const select = (address: number): void => {
    selected = address;
    byPerson = true;
    drawMap();
    drawTables();
  };
  const map = createMap(mapBox, { select });
  const list = createList(listBox, select);
  const underWay = createPlansUnderWay();

  const systems = (): System[] =>
    [
      // The server's own words and those of its people make no vessel.
      ...[...state.systems.values()].filter((system) => !isShore(system)),
      // A vessel with a name is there before it is heard; while nothing is known of the fleet at all, nothing is said.
      ...Object.entries(names).flatMap(([address, name]) => (state.serverUs && !state.systems.has(Number(address)) ? [unheard(Number(address), name)] : [])),
    ]
      .map((system) => ({ ...system, name: names[String(system.address)] ?? system.name }))
      .sort((one, other) => systemName(one).localeCompare(systemName(other)));
  const isOurs = (system: System): boolean => String(system.address) in names;
  const isGone = (system: System): boolean => system.liveness === "lost" || system.liveness === "stale";
  /** The vessel that is shown while nobody has chosen: one with a name from people before others, one that is heard before one that is not. */
  const firstOf = (known: readonly System[]): System | undefined => {
    const rank = (system: System): number => (isOurs(system) ? 4 : 0) + (isGone(system) ? 0 : 2) + (system.fix ? 1 : 0);
    const best = Math.max(...known.map(rank));
    return known.find((system) => rank(system) === best && (isOurs(system) || !isGone(system)));
  };
  const labels = (system: System): Map<number, string> =>
    new Map(Object.entries(system.entities).map(([number, label]) => [Number(number), label ?? ""]));
  const listed = (system: System, nowUs: number): Listed => {
    const [known, label] = [state.values.get(system.address) ?? new Map(), labels(system)];
    const [parts, read, came] = [entities(known, label, nowUs), vitals(known, label, nowUs), placeCameUs(known)];
    return {
      system,
      ours: isOurs(system),
      placeIsOld: placeIsOld(state.values.get(system.address), nowUs),
      placeS: came === null ? null : Math.max(0, (nowUs - came) / 1e6),
      vitals: read,
      worst: worst(parts),
      parts: partsInWords(parts),
      alarm: told(chrome.alarms()).find((one) => one.vessel === system.address),
      legs: underWay.legs(system.address, runs(read.plan) ? read.plan.note : ""),
    };
  };

  const drawMap = (): void => {
    const nowUs = serverNowUs(state, performance.now());
    map.update(systems().map((system) => asSeen(system, state.values.get(system.address), nowUs, linked)), selected, nowUs);
  };
  const drawTables = (): void => {
    const nowUs = serverNowUs(state, performance.now());
    const known = systems();
    for (const system of known) if (!isGone(system)) met.add(system.address);
    const before = known.find((system) => system.address === selected);
    if (!byPerson && (!before || (isGone(before) && !isOurs(before)))) selected = firstOf(known)?.address ?? selected;
    list.update(known.map((system) => listed(system, nowUs)), selected, nowUs, linked);
    const chosen = known.find((system) => system.address === selected);
    // A stranger that is gone does not come to where the STOP of a vessel of these people is looked for.
    chrome.stop?.target(chosen && (isOurs(chosen) || met.has(chosen.address)) ? { address: chosen.address, name: systemName(chosen) } : undefined);
  };

  const follow = (system: System): void => {
    if (!system.fix) return;
    let track = tracks.get(system.address);
    if (!track) {
      track = new Track();
      tracks.set(system.address, track);
      void past(system.address, track, system.fix.time_us);
    }
    if (track.add(system.fix)) map.track(system.address, track.all());
  };
  const past = async (address: number, track: Track, nowUs: number): Promise<void> => {
    const query = `from_us=${Math.round(nowUs - PAST_US)}&to_us=${Math.round(nowUs)}`;
    try {
      track.recorded(await getJson<TrackPoint[]>(`/api/v1/vessels/${address}/track?${query}`));
      map.track(address, track.all());
    } catch {
      // Without a history the track begins now.
    }
  };

  let due = false;
  const chrome = createChrome({ messages: [...GLANCE], events: false, every_ms: EVERY_MS }, {
    frame(now) {
      linked = true;
      state = now;
      if (due) return;
      due = true;
      requestAnimationFrame(() => {
        due = false;
        chrome.draw("map", () => {
          for (const system of state.systems.values()) follow(system);
          drawMap();
        });
      });
    },
    lost() {
      linked = false;
      drawTables();
      drawMap();
    },
  });
  window.setInterval(() => {
    chrome.draw("tables", drawTables);
    chrome.draw("map", drawMap);
  }, TABLES_MS);
}
