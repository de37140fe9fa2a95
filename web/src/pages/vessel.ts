// One vessel: map, instruments, plots and tables over one stretch of time and one cursor.

import { getJson, reason } from "../api/http";
import { createControl } from "../control/panel";
import type { Detection, Detections, Gap, LinkStatus, LogBook, Series, System, TrackPoint, Update } from "../api/types.gen";
import { createMap } from "../map/map";
import { ends, isLive, panned, type Range, type Source, written, zoomed } from "../plot/model";
import { createPlots } from "../plot/panel";
import { createTimeBar } from "../plot/timebar";
import { NO_CONTROL, withControl } from "../state/control";
import { EMPTY, serverNowUs } from "../state/fleet";
import { linkLoss } from "../state/linkloss";
import { placeAt, Track } from "../state/track";
import { entities, type Labels, vitals } from "../state/vitals";
import { createChrome } from "../ui/chrome";
import { make, setText } from "../ui/dom";
import { createDetections, createLogBook } from "../ui/events";
import { createEntities } from "../ui/entities";
import { position, systemName, utc } from "../ui/format";
import { createLinkLoss } from "../ui/linkloss";
import { createTabs } from "../ui/tabs";
import { createTiles } from "../ui/tiles";
import { createValues } from "../ui/values";

/** Instruments, tables and plots are drawn anew so often, ms. */
const TABLES_MS = 250;
/** Links and the history's events are asked for so often while the present is followed, ms. */
const AGAIN_MS = 5_000;
const SETTLE_MS = 200;
const POINTS = 5_000;
/** What is plotted when nobody has chosen. */
const FIRST: readonly (readonly [string, string])[] = [["Rpm", "value"], ["EstimatedState", "u"], ["FuelLevel", "value"]];

export function startVessel(root: HTMLElement): void {
  const address = Number(root.dataset["address"]);
  const given = root.dataset["name"] || null;
  const path = `/api/v1/vessels/${address}`;
  const query = new URLSearchParams(location.search);

  const mapBox = make("div", { class: "map", tabindex: "0", role: "application", "aria-label": "Map. Arrow keys move it, plus and minus zoom; instruments and tables tell the same." });
  const all = make("button", { type: "button", class: "show-all" }, "Show all");
  const here = make("p", { class: "here num", role: "status" });
  const tileBox = make("section", { class: "instruments", "aria-label": "Instruments" });
  const timeBox = make("section", { class: "timebar", "aria-label": "Time" });
  const side = make("div", { class: "side" });
  root.append(tileBox, make("div", { class: "map-box" }, mapBox, all, here), make("div", { class: "work" }, timeBox, side));
  const panel = (): HTMLElement => make("div", { class: "tabpanel" });
  const panels = { Control: panel(), Plots: panel(), Values: panel(), Entities: panel(), "Log book": panel(), Tags: panel(), "Link loss": panel() };

  let state = EMPTY;
  let control = NO_CONTROL;
  let linked = true;
  let range: Range = fromQuery(query);
  let system: System | undefined;
  let labels: Labels = new Map();
  let track: readonly TrackPoint[] = [];
  let catalogue: readonly Series[] = [];
  let link: LinkStatus | undefined;
  let chosen: readonly Source[] = [];
  const ahead = new Track();
  const nowUs = (): number => (state.serverUs ? serverNowUs(state, performance.now()) : Date.now() * 1_000);
  const entity = (number: number): string => labels.get(number) ?? (number === 255 ? "" : String(number));

  const map = createMap(mapBox, () => undefined);
  all.addEventListener("click", () => map.showAll());
  const tiles = createTiles(tileBox);
  const cursor = (us: number | null, from: "map" | "plot" | "table"): void => {
    if (from !== "plot") plots.cursor(us);
    const place = us === null ? undefined : placeAt(track, us);
    map.overlays.cursor(place ?? null);
    setText(here, us === null ? "" : `${utc(us)}${place ? `  ${position(place)}` : "  no place known then"}`);
  };
  const choose = (next: Range): void => {
    range = next;
    plots.range(range);
    timeBar.update(range, nowUs());
    remember();
    askPast();
  };
  const moves = {
    pan: (part: number): void => choose(panned(range, part, nowUs())),
    scale: (factor: number): void => choose(zoomed(range, factor, nowUs())),
  };
  const timeBar = createTimeBar(timeBox, {
    ...moves,
    choose,
    all() {
      const [firsts, lasts] = [catalogue.flatMap((one) => one.first_us ?? []), catalogue.flatMap((one) => one.last_us ?? [])];
      if (firsts.length) choose({ fromUs: Math.min(...firsts), toUs: Math.max(...lasts) + 1_000_000 });
    },
  });
  const plots = createPlots(panels.Plots, address, root.dataset["researcher"] !== undefined, query.get("plots") ?? "", entity, {
    ...moves,
    cursor: (us) => cursor(us, "plot"),
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
  const logBook = createLogBook(panels["Log book"], entity, (us) => cursor(us, "table"));
  const tags = createDetections(panels.Tags, (us) => cursor(us, "table"));
  const panelOfControl = createControl(panels.Control, {
    address,
    me: root.dataset["me"] ?? "",
    may: root.dataset["operator"] !== undefined,
    name: () => (system ? systemName(system) : (given ?? String(address))),
    pick: (told) => map.overlays.pick(told),
    mark: (place) => map.overlays.cursor(place ? { lat_deg: place[0], lon_deg: place[1] } : null),
  });
  const tabs = createTabs(side, "Of this vessel", Object.entries(panels), () => state.serverUs && draw());
  tabs.open("Plots");
  map.overlays.followPointer(() => track, (point) => cursor(point?.time_us ?? null, "map"));

  const remember = (): void => {
    const next = new URLSearchParams();
    if (isLive(range)) next.set("span", String(Math.round(range.spanUs / 1e6)));
    else {
      next.set("from", String(range.fromUs));
      next.set("to", String(range.toUs));
    }
    if (chosen.length) next.set("plots", chosen.map(written).join(","));
    history.replaceState(null, "", `${location.pathname}?${next}`);
  };

  let settle: number | undefined;
  let asked = new AbortController();
  const askPast = (): void => {
    window.clearTimeout(settle);
    settle = window.setTimeout(() => void past(), SETTLE_MS);
  };
  const past = async (): Promise<void> => {
    asked.abort();
    asked = new AbortController();
    const { signal } = asked;
    const { fromUs, toUs } = ends(range, nowUs());
    const time = `from_us=${Math.max(0, Math.round(fromUs))}&to_us=${Math.round(toUs) + 1}`;
    const get = async <T>(what: string, told: (answer: T) => void, failed: (text: string) => void): Promise<void> => {
      try {
        told(await getJson<T>(`${path}/${what}${time}`, signal));
      } catch (error) {
        if (!signal.aborted) failed(reason(error));
      }
    };
    await Promise.all([
      get<TrackPoint[]>(`track?points=${POINTS}&`, (points) => {
        ahead.recorded(points);
        track = isLive(range) ? ahead.all() : points;
        map.track(address, track);
        if (!isLive(range)) map.showAll();
      }, () => undefined),
      get<LogBook>("logbook?limit=2000&", ({ entries, next }) => logBook.update(entries, next !== null), logBook.failed),
      get<Detections>("detections?limit=5000&", ({ detections, next }) => showTags(detections, next !== null), tags.failed),
    ]);
    window.clearTimeout(settle);
    if (isLive(range) && !signal.aborted) settle = window.setTimeout(() => void past(), AGAIN_MS);
  };
  const showTags = (all: readonly Detection[], more: boolean): void => {
    tags.update(all, more);
    map.overlays.detections(all);
  };

  const learn = async (): Promise<void> => {
    try {
      const now = nowUs();
      const [series, gaps] = await Promise.all([
        getJson<Series[]>(`/api/v1/series?system=${address}`),
        getJson<Gap[]>(`${path}/gaps?from_us=0&to_us=${Math.round(now)}`),
      ]);
      catalogue = series;
      const last = Math.max(...series.map((one) => one.last_us ?? 0));
      // A vessel of which there is only an old log is looked at as it was.
      const old = isLive(range) && !query.has("span") && last > 0 && now - last > 3.6e9 && system?.liveness !== "live";
      if (old) choose({ fromUs: Math.max(0, last - 3.6e9), toUs: last + 1_000_000 });
      plots.catalogue(series, gaps);
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
    } catch {
      link = undefined;
    }
    window.setTimeout(() => void askLink(), AGAIN_MS);
  };

  const draw = (): void => {
    const now = nowUs();
    const known = state.values.get(address) ?? new Map<string, Update>();
    panelOfControl.update(control, system, now);
    tiles.update(system, vitals(known, labels, now), link, now, linked);
    timeBar.update(range, now);
    if (tabs.shows("Link loss")) loss.update(system, linkLoss(known, labels), control.commands, now, linked);
    if (tabs.shows("Plots")) plots.draw(now);
    if (tabs.shows("Values")) values.update("Latest values", [...known.values()], labels, now);
    if (tabs.shows("Entities")) parts.update(entities(known, labels, now));
    if (system) map.update([system], address, now);
    const title = root.querySelector("h1");
    if (title && system) setText(title, systemName(system));
  };

  let begun = false;
  const chrome = createChrome({ systems: [address], events: true, every_ms: 100 }, {
    frame(now, frame) {
      linked = true;
      state = now;
      control = withControl(control, frame, address);
      const found = state.systems.get(address);
      system = found ? { ...found, name: given ?? found.name } : undefined;
      labels = new Map(Object.entries(system?.entities ?? {}).map(([number, label]) => [Number(number), label ?? ""]));
      plots.live(frame.values);
      chrome.stop?.target({ address, name: system ? systemName(system) : (given ?? String(address)) });
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
      draw();
    },
    lost() {
      linked = false;
      draw();
    },
  });
  window.setInterval(draw, TABLES_MS);
}

/** The stretch of time in the address; else the last quarter of an hour. */
function fromQuery(query: URLSearchParams): Range {
  const number = (name: string): number => Number(query.get(name) ?? NaN);
  const [span, fromUs, toUs] = [number("span"), number("from"), number("to")];
  if (span >= 1) return { spanUs: span * 1e6 };
  if (fromUs >= 0 && fromUs < toUs) return { fromUs, toUs };
  return { spanUs: 900_000_000 };
}
