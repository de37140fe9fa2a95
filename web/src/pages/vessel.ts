// One vessel: map, instruments, plots and tables over one stretch of time and one cursor.

import { getJson } from "../api/http";
import { createControl } from "../control/panel";
import type { At, Detections, Entity, Gap, LinkStatus, LogBook, Series, System, TrackPoint } from "../api/types.gen";
import { createMap } from "../map/map";
import { createMeasure } from "../map/measure";
import { ends, isLive, panned, type Range, type Source, written, zoomed } from "../plot/model";
import { createPlots } from "../plot/panel";
import { createParameters } from "../params/panel";
import { createUnderWay } from "../plan/underway";
import { createTimeBar } from "../plot/timebar";
import { createAsker } from "../replay/asker";
import { createBar } from "../replay/bar";
import { createBeside } from "../replay/beside";
import { advanced, fromAddress, type Playback, STEP_US, toAddress, toggled, within, zoomedAbout } from "../replay/clock";
import { labelsThen, nameThen, systemThen, valuesThen } from "../replay/then";
import { Behind } from "../state/behind";
import { controlLine, NO_CONTROL, partOf, withControl } from "../state/control";
import { asSeen, EMPTY, serverNowUs } from "../state/fleet";
import { linkLoss } from "../state/linkloss";
import { guardOf } from "../state/teleop";
import type { Stretch } from "../state/newest";
import { placeAt, Track } from "../state/track";
import { windowKey } from "../state/window";
import { entities, type Labels, type Values, vitals } from "../state/vitals";
import { createChrome } from "../ui/chrome";
import { make, setAttribute, setText } from "../ui/dom";
import { createDetections, createLogBook } from "../ui/events";
import { createEntities } from "../ui/entities";
import { hexAddress, position, systemName, utc } from "../ui/format";
import { createLinkLoss } from "../ui/linkloss";
import { createTabs } from "../ui/tabs";
import { createTiles } from "../ui/tiles";
import { createValues } from "../ui/values";

/** Instruments, tables and plots are drawn anew so often, ms. */
const TABLES_MS = 250;
/** The link, and what the history has beyond what came by itself, are looked after so often while the present is followed, ms. */
const AGAIN_MS = 5_000;
const SETTLE_MS = 200;
const POINTS = 5_000;
/** What is shown when nobody has chosen, µs. */
const SPAN_US = 900_000_000;
/** A replay that ends so near to the present goes on with it, µs. */
const PRESENT_US = 5_000_000;
/** While it plays, the address is brought up to date so often, ms; and no step of it is longer. */
const ADDRESS_MS = 1_000;
/** Tabs that are about a stretch of time. */
const TIMED = ["Plots", "Log book", "Tags"];
/** What is plotted when nobody has chosen. */
const FIRST: readonly (readonly [string, string])[] = [["Rpm", "value"], ["EstimatedState", "u"], ["FuelLevel", "value"]];

export function startVessel(root: HTMLElement): void {
  const address = Number(root.dataset["address"]);
  const given = root.dataset["name"] || null;
  const path = `/api/v1/vessels/${address}`;
  const query = new URLSearchParams(location.search);

  const mapBox = make("div", { class: "map", tabindex: "0", role: "application", "aria-label": "Map. Arrow keys move it, plus and minus zoom; instruments and tables tell the same." });
  const here = make("p", { class: "here num", role: "status" });
  const replayBox = make("section", { class: "replay", "aria-label": "Present or past" });
  const tileBox = make("section", { class: "instruments", "aria-label": "Instruments" });
  const timeBox = make("section", { class: "timebar", "aria-label": "Time" });
  const side = make("div", { class: "side" });
  const tagsCut = make("p", { class: "tags-cut", role: "status" });
  const mapFrame = make("div", { class: "map-box" }, mapBox, here, tagsCut);
  const nothing = make("p", { class: "empty", hidden: "" }, "Nothing is recorded of this vessel yet. A log of it is brought in under Admin, Import; then it is watched here as it was.");
  const who = make("p", { class: "in-control", role: "status" });
  const head = make("div", { class: "vessel-head" }, root.querySelector("h1") ?? make("h1", {}, given ?? hexAddress(address)), who, replayBox);
  tileBox.append(head);
  const besideBox = make("section", { class: "beside", "aria-label": "Vessels" });
  root.append(tileBox, mapFrame, make("div", { class: "work" }, timeBox, nothing, side));
  const names = JSON.parse(root.dataset["names"] ?? "{}") as Record<string, string>;
  // What is looked at stays; the page begins anew with those who are in its address.
  const beside = createBeside(besideBox, address, names, query, (addresses) => {
    remember();
    const next = new URLSearchParams(location.search);
    if (addresses.length) next.set("with", addresses.join(","));
    else next.delete("with");
    location.assign(`${location.pathname}?${next}`);
  });
  const panel = (): HTMLElement => make("div", { class: "tabpanel" });
  const panels = { Control: panel(), Plots: panel(), Values: panel(), Entities: panel(), "Log book": panel(), Tags: panel(), "Link loss": panel(), Parameters: panel() };

  let state = EMPTY;
  let control = NO_CONTROL;
  let linked = true;
  const inAddress = fromAddress(query, SPAN_US);
  let range: Range = inAddress.range;
  /** Null while the page follows the present. */
  let play: Playback | null = inAddress.play;
  /** The time that is pointed to. */
  let hoverUs: number | null = null;
  let named: readonly Entity[] = [];
  const speed0 = inAddress.play?.speed ?? 1;
  let system: System | undefined;
  let labels: Labels = new Map();
  /** As the history knows them. */
  let lastLabels: Labels = new Map();
  let track: readonly TrackPoint[] = [];
  let catalogue: readonly Series[] = [];
  let silences: readonly Gap[] = [];
  let link: LinkStatus | undefined;
  let chosen: readonly Source[] = [];
  const ahead = new Track();
  const behind = new Behind();
  /** What the history did not answer is asked again. */
  const heeded = <T>(answer: Promise<T>): Promise<T> =>
    answer.catch((error: unknown) => {
      behind.failed();
      throw error;
    });
  const nowUs = (): number => (state.serverUs ? serverNowUs(state, performance.now()) : Date.now() * 1_000);
  const entity = (number: number): string => labels.get(number) ?? lastLabels.get(number) ?? (number === 255 ? "" : String(number));

  const map = createMap(mapBox, { vessel: address, first: beside.colours });
  const tiles = createTiles(tileBox, head);
  createMeasure(map);
  /** The time of which map, plots and tables tell; null for the present. */
  const atUs = (): number | null => (play?.playing ? play.atUs : (hoverUs ?? play?.atUs ?? null));
  const asker = createAsker(address, () => draw());
  let then: { at: At; values: Values; labels: Labels; us: number } | undefined;
  const asItWas = (): typeof then => {
    const at = atUs() === null ? undefined : asker.known();
    if (!at) return undefined;
    if (then?.at !== at) then = { at, values: valuesThen(at), labels: labelsThen(named, at.time_us), us: at.time_us };
    return then;
  };
  /** Brings everything that depends on the cursor's time up to date, once for each picture. */
  let due = false;
  /** Whether all the rest is to be drawn as well. */
  let whole = false;
  const point = (): void => {
    if (due) return;
    due = true;
    requestAnimationFrame(() => chrome.draw("cursor", () => {
      due = false;
      if (whole) draw();
      whole = false;
      const us = atUs();
      asker.want(us);
      // The plot that is pointed to has its cursor by itself, and has told the others.
      if (!byPlot || hoverUs === null || play?.playing) plots.cursor(us);
      drawHere(us);
      drawPlace();
      drawBar();
    }));
  };
  /** Where the vessel was at the time that is pointed to, if at any. */
  const drawHere = (us: number | null): void => {
    const place = us === null ? undefined : placeAt(track, us, silences);
    // Where the replayed vessel itself is drawn, a mark would only hide it.
    map.overlays.cursor(us === play?.atUs ? null : (place ?? null));
    setText(here, us === null ? "" : `${utc(us)}${place ? `  ${position(place)}` : "  no place known then"}`);
  };
  let byPlot = false;
  const hover = (us: number | null, plot = false): void => {
    hoverUs = us;
    byPlot = plot;
    point();
  };
  /** `told`: whether the address is told at once; while somebody drags, only in the end. */
  const setPlay = (next: Playback | null, told = true): void => {
    const began = next?.playing && !play?.playing;
    play = next;
    hoverUs = null;
    point();
    draw();
    if (began) playOn(performance.now(), performance.now(), ++run);
    rememberSoon(told);
  };
  const rememberSoon = (now: boolean): void => {
    window.clearTimeout(dragged);
    if (now) remember();
    else dragged = window.setTimeout(remember, SETTLE_MS);
  };
  let dragged: number | undefined;
  /** Counts plays, so that one that was ended for another does not go on beside it. */
  let run = 0;
  /** Stands still at a time of the range. */
  const pick = (us: number): void => {
    const { fromUs, toUs } = ends(range, nowUs());
    if (isLive(range)) choose({ fromUs: Math.round(fromUs), toUs: Math.round(toUs) }, false);
    if (play) setPlay(within({ ...play, atUs: us, playing: false }, range));
  };
  const step = (byUs: number): void => void (play && setPlay(within({ ...play, atUs: play.atUs + byUs, playing: false }, range), false));
  const toggle = (): void => void (play && setPlay(toggled(play, range)));
  const goLive = (): void => {
    const { fromUs, toUs } = ends(range, nowUs());
    choose({ spanUs: Math.min(SPAN_US, toUs - fromUs) });
  };
  const playOn = (beforeMs: number, savedMs: number, mine: number): void =>
    void requestAnimationFrame((ms) => {
      if (!play?.playing || isLive(range) || mine !== run) return;
      play = advanced(play, Math.min(ADDRESS_MS, ms - beforeMs), range.toUs);
      if (!play.playing && nowUs() - range.toUs < PRESENT_US) return goLive();
      point();
      const save = ms - savedMs > ADDRESS_MS || !play.playing;
      if (save) remember();
      playOn(ms, save ? ms : savedMs, mine);
    });
  const bar = createBar(replayBox, {
    enter() {
      pick(ends(range, nowUs()).fromUs);
      bar.focus();
    },
    live() {
      goLive();
      timeBox.querySelector("select")?.focus();
    },
    toggle,
    seek: (us) => play && setPlay(within({ ...play, atUs: us }, range), false),
    step,
    speed: (speed) => play && setPlay({ ...play, speed }),
  });
  root.addEventListener("keydown", (event) => {
    // Where keys mean something else, they mean that.
    const busy = event.target instanceof Element && event.target.closest("input, select, textarea, button, a, summary, .map, .canvas, [role=tab]");
    if (!play || event.defaultPrevented || event.ctrlKey || event.altKey || event.metaKey) return;
    if (event.key === " " && !(busy && !busy.matches(".map, .canvas"))) toggle();
    else if (!busy && (event.key === "ArrowLeft" || event.key === "ArrowRight")) step((event.key === "ArrowLeft" ? -1 : 1) * STEP_US * (event.shiftKey ? 10 : 1));
    else return;
    event.preventDefault();
  });
  const choose = (next: Range, fit = true, told = true): void => {
    range = next;
    const before = play;
    play = within(play, range, speed0);
    if (!before !== !play) hoverUs = null;
    plots.range(range);
    rememberSoon(told);
    whole = true;
    point();
    askPast(fit);
  };
  const moves = {
    // A wheel turns faster than pictures are drawn, and than a browser lets its address be changed.
    pan: (part: number): void => choose(panned(range, part, nowUs()), true, false),
    scale: (factor: number): void => choose(play && !isLive(range) ? zoomedAbout(range, play.atUs, factor, nowUs()) : zoomed(range, factor, nowUs()), true, false),
  };
  const timeBar = createTimeBar(timeBox, {
    ...moves,
    choose,
    all() {
      const [firsts, lasts] = [catalogue.flatMap((one) => one.first_us ?? []), catalogue.flatMap((one) => one.last_us ?? [])];
      if (firsts.length) choose({ fromUs: Math.min(...firsts), toUs: Math.max(...lasts) + 1_000_000 });
    },
  });
  timeBox.querySelector("form")?.before(besideBox);
  const plots = createPlots(panels.Plots, address, root.dataset["researcher"] !== undefined, query.get("plots") ?? "", entity, {
    ...moves,
    cursor: (us) => hover(us, true),
    pick,
    zoom: (fromUs, toUs) => choose({ fromUs: Math.round(fromUs), toUs: Math.round(toUs) }),
    changed(sources) {
      chosen = sources;
      remember();
    },
  });
  const values = createValues(panels.Values, ({ update, field }) => {
    plots.add({ message: update.abbrev, entity: update.entity, field: field.name });
    tabs.open("Plots");
  });
  const parts = createEntities(panels.Entities);
  const lossBox = make("div", { class: "linkloss" });
  panels["Link loss"].append(lossBox);
  const loss = createLinkLoss(lossBox, address, root.dataset["operator"] !== undefined);
  const events = {
    at: (us: number | null): void => hover(us),
    pick,
    vessel: () => (system ? systemName(system) : (given ?? hexAddress(address))),
    may: root.dataset["researcher"] !== undefined,
  };
  const logBook = createLogBook(panels["Log book"], async (query, signal) => {
    const { entries, next } = await heeded(getJson<LogBook>(`${path}/logbook?${query}`, signal));
    return { items: entries, next };
  }, entity, events);
  const tags = createDetections(panels.Tags, async (query, signal) => {
    const { detections, next } = await getJson<Detections>(`${path}/detections?${query}`, signal);
    return { items: detections, next };
  }, events, ({ items, next }) => {
    map.overlays.detections(items);
    const last = next ? items.at(-1) : undefined;
    setText(tagsCut, last ? `Tags on the map: the newest ${items.length}, since ${utc(last.time_us)}. Older ones: under Tags.` : "");
  });
  // Whoever looks at the past commands nothing by accident. STOP is not in here.
  const controlBox = make("div", { class: "control-box" });
  const fromPast = make("p", { class: "note warn", hidden: "" }, "You look at the past: nothing is commanded from here. STOP works, and Back to live brings the commands back.");
  panels.Control.append(fromPast, controlBox);
  const panelOfControl = createControl(controlBox, {
    address,
    me: root.dataset["me"] ?? "",
    may: root.dataset["operator"] !== undefined,
    steers: true,
    attention: () => chrome.attention(),
    name: () => (system ? systemName(system) : (given ?? hexAddress(address))),
    pick: (told) => map.overlays.pick(told),
    mark: (place) => map.overlays.cursor(place ? { lat_deg: place[0], lon_deg: place[1] } : null),
  });
  const parameters = createParameters(panels.Parameters, {
    address,
    me: root.dataset["me"] ?? "",
    may: root.dataset["operator"] !== undefined,
    name: () => (system ? systemName(system) : (given ?? hexAddress(address))),
    openControl: () => tabs.open("Control"),
  });
  const underWay = createUnderWay(mapFrame, map, address);
  let tab = "";
  /** The time bar is there where time is chosen. */
  const drawTimeBar = (): void => setAttribute(timeBox, "hidden", play || TIMED.includes(tab) ? null : "");
  const tabs = createTabs(side, "Of this vessel", Object.entries(panels), (name) => {
    tab = name;
    drawTimeBar();
    if (state.serverUs) {
      draw();
      remember();
    }
  });
  tabs.open(Object.keys(panels).find((name) => name === query.get("tab")) ?? "Plots");
  map.overlays.followPointer(() => track, (place) => hover(place?.time_us ?? null));
  map.overlays.onTrack((place) => pick(place.time_us));
  map.overlays.onTags((group) => {
    tags.only(group);
    tabs.open("Tags");
  });

  const remember = (): void => {
    const next = toAddress({ range, play });
    if (chosen.length) next.set("plots", chosen.map(written).join(","));
    else if (!begun && query.get("plots")) next.set("plots", query.get("plots") ?? "");
    if (tab !== "Plots") next.set("tab", tab);
    if (beside.addresses.length) next.set("with", beside.addresses.join(","));
    history.replaceState(null, "", `${location.pathname}?${next}`);
  };

  let settle: number | undefined;
  let asked = new AbortController();
  /** The range that was asked for last. */
  let askedRange: Range | undefined;
  const stretchNow = (): Stretch => {
    const { fromUs, toUs } = ends(range, nowUs());
    return { fromUs: Math.max(0, Math.round(fromUs)), toUs: Math.round(toUs) + 1, open: isLive(range) };
  };
  const askPast = (fit: boolean): void => {
    window.clearTimeout(settle);
    settle = window.setTimeout(() => void past(fit), SETTLE_MS);
  };
  const past = async (fit = true): Promise<void> => {
    asked.abort();
    asked = new AbortController();
    const { signal } = asked;
    const stretch = stretchNow();
    const goesOn = isLive(range) && askedRange === range;
    askedRange = range;
    if (goesOn && !behind.due(nowUs())) {
      await tags.follow(stretch, signal);
      return again(signal);
    }
    behind.asked(nowUs());
    const askTrack = async (): Promise<void> => {
      try {
        const points = await heeded(getJson<TrackPoint[]>(`${path}/track?points=${POINTS}&from_us=${stretch.fromUs}&to_us=${stretch.toUs}`, signal));
        ahead.recorded(points);
        track = isLive(range) ? ahead.all() : points;
        if (play) point();
        else map.track(address, track);
        drawPlace();
        if (!isLive(range) && fit) map.showAll();
      } catch {
        // The track that is known stays; the tables tell that the history does not answer.
      }
    };
    await Promise.all([beside.ask(range, nowUs(), signal), askTrack(), logBook.show(stretch, goesOn, signal), goesOn ? tags.follow(stretch, signal) : tags.show(stretch, false, signal)]);
    if (beside.addresses.length && !isLive(range) && fit && !signal.aborted) {
      drawPlace();
      map.showAll();
    }
    again(signal);
  };
  const again = (signal: AbortSignal): void => {
    window.clearTimeout(settle);
    if (isLive(range) && !signal.aborted) settle = window.setTimeout(() => void past(), AGAIN_MS);
  };

  const learn = async (): Promise<void> => {
    try {
      const now = nowUs();
      const [series, gaps, entities] = await Promise.all([
        getJson<Series[]>(`/api/v1/series?system=${address}`),
        getJson<Gap[]>(`${path}/gaps?from_us=0&to_us=${Math.round(now)}`),
        getJson<Entity[]>(`${path}/entities`),
      ]);
      catalogue = series;
      silences = gaps;
      named = entities;
      lastLabels = labelsThen(named, Infinity);
      then = undefined;
      setAttribute(nothing, "hidden", series.length || state.values.get(address)?.size ? "" : null);
      const last = Math.max(...series.map((one) => one.last_us ?? 0));
      // A vessel of which there is only an old log is looked at as it was.
      const old = isLive(range) && !query.has("span") && !query.has("t") && last > 0 && now - last > 3.6e9 && system?.liveness !== "live";
      if (old) choose({ fromUs: Math.max(0, last - 3.6e9), toUs: last + 1_000_000 });
      plots.catalogue(series, gaps);
      if (beside.addresses.length) plots.beside(await beside.learn());
    } catch {
      plots.catalogue([], []);
    }
    if (!query.has("plots")) for (const source of first()) plots.add(source);
  };
  const first = (): Source[] =>
    FIRST.flatMap(([message, field]) => {
      const found = new Map<string, Source>();
      for (const one of catalogue) if (one.message === message) found.set(String(one.entity), { message, entity: one.entity, field });
      for (const one of state.values.get(address)?.values() ?? []) if (one.abbrev === message) found.set(String(one.entity), { message, entity: one.entity, field });
      return [...found.values()].slice(0, 2);
    });
  const askLink = async (): Promise<void> => {
    try {
      link = (await getJson<LinkStatus[]>("/api/v1/links")).find((one) => one.vessel === address);
      behind.backlog(link?.backlog_records ?? 0);
    } catch {
      link = undefined;
    }
    window.setTimeout(() => void askLink(), AGAIN_MS);
  };

  const drawBar = (): void => {
    const heard = linked && (system?.liveness === "live" || system?.liveness === "late");
    bar.update(range, play, hoverUs, nowUs(), heard, atUs() === null ? "" : asker.trouble());
  };
  /** The vessel on the map: where it was then, or where it is. */
  const drawPlace = (): void => {
    const others = beside.draw(map, play, state.systems);
    if (play) {
      const known: Values = asItWas()?.values ?? new Map();
      map.track(address, track, play.atUs);
      map.update([systemThen(address, given ?? system?.name ?? nameThen(known), known, placeAt(track, play.atUs, silences), play.atUs), ...others], address, play.atUs);
    } else if (system) map.update([system, ...others].map((one) => asSeen(one, state.values.get(one.address), nowUs(), linked)), address, nowUs());
  };
  const draw = (): void => {
    const now = nowUs();
    panelOfControl.update(control, system, now, guardOf(state.values.get(address) ?? new Map(), labels, now));
    const us = atUs();
    // The track may have come, or gone on, since the pointer came to rest.
    if (us !== null) drawHere(us);
    const then = asItWas();
    const known: Values = us === null ? (state.values.get(address) ?? new Map()) : (then?.values ?? new Map());
    const called = us === null ? labels : (then?.labels ?? labels);
    // Values are asked for and come while time goes on: their age counts to the time that is shown.
    const asOf = us === null ? now : Math.max(us, then?.us ?? us);
    const newest = Math.max(...[...known.values()].map((one) => one.time_us));
    const past = us === null ? undefined : known.size ? (asOf - newest) / 1e6 : null;
    const readings = vitals(known, called, asOf);
    tiles.update(system, readings, link, asOf, us === null ? linked : true, past, us === null ? underWay.legs() : undefined);
    setText(who, controlLine(control.lease, partOf(control.lease, root.dataset["me"] ?? "", windowKey()), linked));
    drawTimeBar();
    underWay.update(readings, us === null);
    // Where it is not known that the vessel rests, it may be under way.
    parameters.update(control, system, now, us !== null || readings.mode.old || readings.mode.word !== "SERVICE", play === null && tabs.shows("Parameters"));
    panels.Parameters.inert = play !== null;
    timeBar.update(range, now);
    // What the vessel will do without its link is about the present, whatever is looked at.
    if (tabs.shows("Link loss")) loss.update(system, linkLoss(state.values.get(address) ?? new Map(), labels), control.commands, now, linked);
    drawBar();
    setAttribute(root, "data-time", play ? "replay" : us === null ? "live" : "cursor");
    setAttribute(fromPast, "hidden", play ? null : "");
    controlBox.inert = play !== null;
    // With nothing in it that takes the focus, keys could not scroll it.
    setAttribute(panels.Control, "tabindex", play ? "0" : null);
    if (tabs.shows("Plots")) {
      plots.draw(now);
      if (hoverUs === null) plots.cursor(us);
    }
    if (tabs.shows("Values")) values.update(us === null ? "Latest values" : `Values as of ${utc(asOf)}`, [...known.values()], called, asOf);
    if (tabs.shows("Entities")) parts.update(entities(known, called, asOf));
    if (tabs.shows("Log book")) logBook.cursor(us);
    if (tabs.shows("Tags")) tags.cursor(us);
    drawPlace();
    const title = root.querySelector("h1");
    if (title && system) setText(title, systemName(system));
    if (system) beside.name(systemName(system));
  };

  let begun = false;
  const chrome = createChrome({ systems: [address, ...beside.addresses], events: true, every_ms: 100 }, {
    frame(now, frame) {
      linked = true;
      state = now;
      control = withControl(control, frame, address);
      const found = state.systems.get(address);
      system = found ? { ...found, name: given ?? found.name } : undefined;
      labels = new Map(Object.entries(system?.entities ?? {}).map(([number, label]) => [Number(number), label ?? ""]));
      plots.live(frame.values);
      parameters.heard(frame);
      tags.frame(frame, address, stretchNow());
      logBook.frame(frame, address, stretchNow());
      behind.frame(frame);
      chrome.stop?.target({ address, name: system ? systemName(system) : (given ?? hexAddress(address)) });
      if (system?.fix && ahead.add(system.fix) && isLive(range)) {
        const { fromUs } = ends(range, nowUs());
        track = ahead.all().filter((point) => point.time_us >= fromUs);
        map.track(address, track);
      }
      if (begun) return;
      begun = true;
      plots.range(range);
      void learn();
      void past();
      void askLink();
      point();
      draw();
    },
    lost() {
      linked = false;
      draw();
    },
  });
  // STOP waits for no frame.
  chrome.stop?.target({ address, name: given ?? hexAddress(address) });
  window.setInterval(() => chrome.draw("instruments", draw), TABLES_MS);
}
