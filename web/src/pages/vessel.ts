// One vessel: map, instruments, plots and tables over one stretch of time and one cursor. What is known stands in stores
// (`vessel/`): the present, the history, the time that is told of; here they are put together and drawn.

import { Refusal } from "../api/http";
import type { LiveFrame } from "../api/types.gen";
import { createMap, type FleetMap } from "../map/map";
import { createMeasure } from "../map/measure";
import { isLive, type Source, written } from "../plot/model";
import { createTimeBar, type TimeBar } from "../plot/timebar";
import { createUnderWay, type UnderWay } from "../plan/underway";
import { createAsker } from "../replay/asker";
import { type Bar, createBar } from "../replay/bar";
import { type Beside, createBeside } from "../replay/beside";
import { fromAddress, STEP_US, toAddress } from "../replay/clock";
import { agesCountTo, labelsThen, nameThen, systemThen, valuesThen } from "../replay/then";
import { controlLine, partOf } from "../state/control";
import { asSeen, type FleetState } from "../state/fleet";
import { linkLoss } from "../state/linkloss";
import { readiness } from "../state/readiness";
import { guardOf } from "../state/guard";
import { placeAt } from "../state/track";
import { entities, type Labels, type Values, vitals, withHeard } from "../state/vitals";
import { windowKey } from "../state/window";
import { type Chrome, createChrome } from "../ui/chrome";
import { setAttribute, setText } from "../ui/dom";
import { position, utc } from "../ui/format";
import { createTabs, type Tabs } from "../ui/tabs";
import { createTiles, type Tiles } from "../ui/tiles";
import { type Boxes, createBoxes, type Tab, TAB_WORDS, TIMED } from "../vessel/boxes";
import { PageHistory } from "../vessel/history";
import { createPanels, type Panels, type Rights } from "../vessel/panels";
import { PagePresent } from "../vessel/present";
import { PageTime, SPAN_US } from "../vessel/time";
import { t } from "../words/words";

/** Instruments, tables and plots are redrawn so often, ms: figures that change faster are not read. */
const TABLES_MS = 500;
/** Whoever drags has the address changed only in the end, ms. */
const SETTLE_MS = 200;
/** A vessel that was last heard longer ago than this is looked at as it was, µs. */
const OLD_US = 3.6e9;
/** What is plotted when nobody has chosen. */
const FIRST: readonly (readonly [string, string])[] = [["Rpm", "value"], ["EstimatedState", "u"], ["FuelLevel", "value"]];

export function startVessel(root: HTMLElement): void {
  new VesselPage(root);
}

/** What is told of one time. */
interface Told {
  readonly us: number | null;
  readonly values: Values;
  readonly labels: Labels;
  /** To which time ages count, µs. */
  readonly asOf: number;
}

class VesselPage {
  private readonly query = new URLSearchParams(location.search);
  private readonly present: PagePresent;
  private readonly time: PageTime;
  private readonly history: PageHistory;
  private readonly boxes: Boxes;
  private readonly beside: Beside;
  private readonly map: FleetMap;
  private readonly tiles: Tiles;
  private readonly bar: Bar;
  private readonly timeBar: TimeBar;
  private readonly panels: Panels;
  private readonly underWay: UnderWay;
  private readonly tabs: Tabs;
  private readonly chrome: Chrome;
  private readonly rights: Rights;
  private readonly asker;
  private then: { readonly at: unknown; readonly values: Values; readonly labels: Labels; readonly us: number } | undefined;
  private tab = "";
  /** What is plotted; undefined until the plots say so. */
  private chosen: readonly Source[] | undefined;
  /** Whether a picture is asked for, and whether all the rest is to be drawn with it. */
  private due = false;
  private whole = false;
  private begun = false;
  private dragged: number | undefined;

  constructor(private readonly root: HTMLElement) {
    const { dataset } = root;
    const address = Number(dataset["address"]);
    this.present = new PagePresent(address, dataset["name"] || null);
    this.rights = { me: dataset["me"] ?? "", operator: dataset["operator"] !== undefined, researcher: dataset["researcher"] !== undefined };
    this.boxes = createBoxes(root, address, this.present.given);
    this.time = this.makeTime();
    this.history = this.makeHistory(address);
    // What is looked at stays; the page starts over with those who are in its address.
    this.beside = createBeside(this.boxes.beside, address, JSON.parse(dataset["names"] ?? "{}") as Record<string, string>, this.query, (addresses) => this.goWith(addresses));
    this.map = createMap(this.boxes.map, { vessel: address, first: this.beside.colours });
    this.tiles = createTiles(this.boxes.tiles, this.boxes.head);
    createMeasure(this.map);
    this.asker = createAsker(address, () => this.draw());
    this.bar = this.makeBar();
    this.timeBar = this.makeTimeBar();
    this.panels = this.makePanels();
    this.underWay = createUnderWay(this.boxes.mapFrame, this.map, address);
    this.tabs = createTabs(this.boxes.side, t("Of this vessel"), Object.entries(this.boxes.panels), TAB_WORDS, (name) => this.opened(name));
    this.tabs.open(Object.keys(this.boxes.panels).find((name) => name === this.query.get("tab")) ?? "Plots");
    this.listen();
    this.chrome = createChrome({ systems: [address, ...this.beside.addresses], events: true, every_ms: 100 }, {
      frame: (fleet, frame) => this.frame(fleet, frame),
      lost: () => {
        this.present.linked = false;
        this.draw();
      },
    });
    // STOP waits for no frame.
    this.chrome.stop?.target({ address, name: this.present.name });
    window.setInterval(() => this.chrome.draw("instruments", () => this.draw()), TABLES_MS);
  }

  // Made once.

  private makeTime(): PageTime {
    return new PageTime({
      nowUs: () => this.present.nowUs(),
      pointed: () => this.point(),
      ranged: (fit) => {
        this.panels.plots.range(this.time.range);
        this.whole = true;
        this.point();
        this.history.soon(fit);
      },
      played: () => this.draw(),
      remember: (now) => this.rememberSoon(now),
    }, fromAddress(this.query, SPAN_US));
  }

  private makeHistory(address: number): PageHistory {
    return new PageHistory(`/api/v1/vessels/${address}`, address, {
      nowUs: () => this.present.nowUs(),
      range: () => this.time.range,
      tracked: (fit) => {
        if (this.time.play) this.point();
        else this.map.track(address, this.history.track);
        this.drawPlace();
        if (!isLive(this.time.range) && fit) this.map.showAll();
      },
      tables: (stretch, goesOn, signal) =>
        Promise.all([
          this.beside.ask(this.time.range, this.present.nowUs(), signal),
          this.panels.logBook.show(stretch, goesOn, signal),
          goesOn ? this.panels.tags.follow(stretch, signal) : this.panels.tags.show(stretch, false, signal),
        ]),
      follow: (stretch, signal) => this.panels.tags.follow(stretch, signal),
      done: (fit, signal) => {
        if (!this.beside.addresses.length || isLive(this.time.range) || !fit || signal.aborted) return;
        this.drawPlace();
        this.map.showAll();
      },
    });
  }

  private makeBar(): Bar {
    const { time, boxes } = this;
    const bar = createBar(boxes.replay, {
      enter() {
        time.enter();
        bar.focus();
      },
      live() {
        time.live();
        boxes.time.querySelector("select")?.focus();
      },
      toggle: () => time.toggle(),
      seek: (us) => time.seek(us),
      step: (byUs) => time.step(byUs),
      speed: (speed) => time.speed(speed),
    });
    return bar;
  }

  private makeTimeBar(): TimeBar {
    const { time, boxes } = this;
    const made = createTimeBar(boxes.time, {
      pan: (part) => time.pan(part),
      scale: (factor) => time.scale(factor),
      choose: (next) => time.choose(next),
      all: () => {
        const whole = this.history.whole();
        if (whole) time.choose(whole);
      },
    });
    boxes.time.querySelector("form")?.before(boxes.beside);
    return made;
  }

  private makePanels(): Panels {
    const { boxes, map, present, history, time, rights } = this;
    return createPanels({
      boxes,
      map,
      present,
      history,
      time,
      rights,
      plots: this.query.get("plots") ?? "",
      open: (tab) => this.tabs.open(tab),
      attention: () => this.chrome.attention(),
      plotted: (sources) => {
        this.chosen = sources;
        this.remember();
      },
    });
  }

  private listen(): void {
    const { map, time } = this;
    this.root.addEventListener("keydown", (event) => this.key(event));
    map.overlays.followPointer(() => this.history.track, (place) => time.hover(place?.time_us ?? null));
    map.overlays.onTrack((place) => time.pick(place.time_us));
    map.overlays.onTags((group) => {
      this.panels.tags.only(group);
      this.tabs.open("Tags");
    });
  }

  private key(event: KeyboardEvent): void {
    // Where keys mean something else, they mean that.
    const busy = event.target instanceof Element && event.target.closest("input, select, textarea, button, a, summary, .map, .canvas, [role=tab]");
    if (!this.time.play || event.defaultPrevented || event.ctrlKey || event.altKey || event.metaKey) return;
    if (event.key === " " && !(busy && !busy.matches(".map, .canvas"))) this.time.toggle();
    else if (!busy && (event.key === "ArrowLeft" || event.key === "ArrowRight")) this.time.step((event.key === "ArrowLeft" ? -1 : 1) * STEP_US * (event.shiftKey ? 10 : 1));
    else return;
    event.preventDefault();
  }

  private opened(name: string): void {
    this.tab = name;
    this.drawTimeBar();
    if (!this.present.fleet.serverUs) return;
    this.draw();
    this.remember();
  }

  // What comes.

  private frame(fleet: FleetState, frame: LiveFrame): void {
    const { present, history, panels } = this;
    const { address } = present;
    present.frame(fleet, frame);
    panels.plots.live(frame.values);
    panels.parameters.heard(frame);
    panels.tags.frame(frame, address, history.stretch());
    panels.logBook.frame(frame, address, history.stretch());
    history.behind.frame(frame);
    this.chrome.stop?.target({ address, name: present.name });
    if (present.system?.fix && history.grew(present.system.fix)) this.map.track(address, history.track);
    if (this.begun) return;
    this.begun = true;
    panels.plots.range(this.time.range);
    void this.learn();
    void history.ask();
    void history.watchLink();
    this.point();
    this.draw();
  }

  private async learn(): Promise<void> {
    const { history, panels } = this;
    try {
      await history.learn();
      this.then = undefined;
      setAttribute(this.boxes.nothing, "hidden", history.catalogue.length || this.present.values.size ? "" : null);
      this.lookBack();
      panels.plots.catalogue(history.catalogue, history.silences);
      if (this.beside.addresses.length) panels.plots.beside(await this.beside.learn());
    } catch (error) {
      // A vessel that the server does not know.
      if (error instanceof Refusal && error.status === 404) setAttribute(this.boxes.nothing, "hidden", null);
      panels.plots.catalogue([], []);
    }
    if (this.query.has("plots")) return;
    for (const [message, field] of FIRST) for (const source of history.sources(message, field, this.present.values.values())) panels.plots.add(source);
  }

  /** A vessel of which there is only an old log is looked at as it was. */
  private lookBack(): void {
    const last = this.history.lastUs();
    const isOld = last > 0 && this.present.nowUs() - last > OLD_US && this.present.system?.liveness !== "live";
    const isAsked = this.query.has("span") || this.query.has("t") || !isLive(this.time.range);
    if (isOld && !isAsked) this.time.choose({ fromUs: Math.max(0, last - OLD_US), toUs: last + 1_000_000 });
  }

  // What the address tells.

  private rememberSoon(now: boolean): void {
    window.clearTimeout(this.dragged);
    if (now) this.remember();
    else this.dragged = window.setTimeout(() => this.remember(), SETTLE_MS);
  }

  private remember(): void {
    const next = toAddress({ range: this.time.range, play: this.time.play });
    const plots = this.chosen ? this.chosen.map(written).join(",") : this.query.get("plots");
    if (plots) next.set("plots", plots);
    if (this.tab !== "Plots") next.set("tab", this.tab);
    if (this.beside.addresses.length) next.set("with", this.beside.addresses.join(","));
    history.replaceState(null, "", `${location.pathname}?${next}`);
  }

  private goWith(addresses: readonly number[]): void {
    this.remember();
    const next = new URLSearchParams(location.search);
    if (addresses.length) next.set("with", addresses.join(","));
    else next.delete("with");
    location.assign(`${location.pathname}?${next}`);
  }

  // Drawing.

  /** Brings everything that depends on the cursor's time up to date, once for each picture. */
  private point(): void {
    if (this.due) return;
    this.due = true;
    requestAnimationFrame(() => this.chrome.draw("cursor", () => this.drawPicture()));
  }

  private drawPicture(): void {
    const { time } = this;
    this.due = false;
    if (this.whole) this.draw();
    this.whole = false;
    const us = time.atUs;
    this.asker.want(us);
    // The plot that is pointed to has its cursor by itself, and has told the others.
    if (!time.byPlot || time.hoverUs === null || time.play?.playing) this.panels.plots.cursor(us);
    this.drawHere(us);
    this.drawPlace();
    this.drawBar();
  }

  /** What was known at the time that is told of; undefined for the present, and until the history has answered. */
  private asItWas(): VesselPage["then"] {
    const at = this.time.atUs === null ? undefined : this.asker.known();
    if (!at) return undefined;
    if (this.then?.at !== at) this.then = { at, values: valuesThen(at), labels: labelsThen(this.history.named, at.time_us), us: at.time_us };
    return this.then;
  }

  private told(): Told {
    const us = this.time.atUs;
    const now = this.present.nowUs();
    if (us === null) return { us, values: this.present.values, labels: this.present.labels, asOf: now };
    const then = this.asItWas();
    return { us, values: then?.values ?? new Map(), labels: then?.labels ?? this.present.labels, asOf: agesCountTo(us, then?.us ?? us, this.time.play) };
  }

  private draw(): void {
    const { present, boxes, panels } = this;
    const [now, told] = [present.nowUs(), this.told()];
    panels.control.update(present.control, present.system, now, guardOf(present.values, present.labels, now));
    // The track may have come, or gone on, since the pointer came to rest.
    if (told.us !== null) this.drawHere(told.us);
    this.drawHead(told);
    this.drawTimeBar();
    this.timeBar.update(this.time.range, now);
    this.drawBar();
    this.drawPast(told.us);
    this.drawTab(told, now);
    this.drawPlace();
    if (!present.system) return;
    setText(boxes.title, present.name);
    this.beside.name(present.name);
  }

  /** Instruments, who has control, and the plan under way. */
  private drawHead({ us, values, labels, asOf }: Told): void {
    const { present, boxes, panels, time } = this;
    const newest = Math.max(...[...values.values()].map((one) => one.time_us));
    const past = us === null ? undefined : values.size ? (asOf - newest) / 1e6 : null;
    const read = vitals(values, labels, asOf);
    const readings = us === null ? withHeard(read, present.heard, asOf) : read;
    this.tiles.update(present.system, readings, this.history.link, asOf, us === null ? present.linked : true, past, us === null ? this.underWay.legs() : undefined);
    const { lease } = present.control;
    setText(boxes.who, controlLine(lease, partOf(lease, this.rights.me, windowKey()), present.linked));
    this.underWay.update(readings, us === null);
    // Where it is not known that the vessel rests, it may be under way.
    const moves = us !== null || readings.mode.old || readings.mode.word !== "SERVICE";
    panels.parameters.update(present.control, present.system, present.nowUs(), moves, time.play === null && this.shows("Parameters"));
  }

  /** Whoever looks at the past commands nothing. */
  private drawPast(us: number | null): void {
    const { boxes } = this;
    const play = this.time.play !== null;
    setAttribute(this.root, "data-time", play ? "replay" : us === null ? "live" : "cursor");
    setAttribute(boxes.fromPast, "hidden", play ? null : "");
    boxes.control.inert = play;
    boxes.panels.Parameters.inert = play;
    // With nothing in it that takes the focus, keys could not scroll it.
    setAttribute(boxes.panels.Control, "tabindex", play ? "0" : null);
  }

  /** The tab that is open; what is closed is not drawn. */
  private drawTab({ us, values, labels, asOf }: Told, now: number): void {
    const { present, panels, time } = this;
    // What the vessel will do without its link is about the present, whatever is looked at.
    if (this.shows("Link loss")) {
      panels.loss.update(present.system, linkLoss(present.values, present.labels), present.control.commands, now, present.linked);
      panels.links(this.history.link, present.linked);
    }
    if (this.shows("Plots")) {
      panels.plots.goOn(now);
      if (time.hoverUs === null) panels.plots.cursor(us);
    }
    if (this.shows("Values")) panels.values.update(us === null ? t("Latest values") : t("Values as of {time}", { time: utc(asOf) }), [...values.values()], labels, asOf);
    if (this.shows("Entities")) {
      const parts = entities(values, labels, asOf);
      // It is a question of the present.
      panels.readiness(us === null ? readiness(parts, this.history.link) : null);
      panels.parts.update(parts);
    }
    if (this.shows("Log book")) panels.logBook.cursor(us);
    if (this.shows("Tags")) panels.tags.cursor(us);
  }

  private shows(tab: Tab): boolean {
    return this.tabs.shows(tab);
  }

  /** The time bar is there where time is chosen. */
  private drawTimeBar(): void {
    setAttribute(this.boxes.time, "hidden", this.time.play || TIMED.includes(this.tab) ? null : "");
  }

  private drawBar(): void {
    const { time, present } = this;
    this.bar.update(time.range, time.play, time.hoverUs, present.nowUs(), present.isHeard, time.atUs === null ? "" : this.asker.trouble());
  }

  /** Where the vessel was at the time that is pointed to, if at any. */
  private drawHere(us: number | null): void {
    const place = us === null ? undefined : placeAt(this.history.track, us, this.history.silences);
    // Where the replayed vessel itself is drawn, a mark would only hide it.
    this.map.overlays.cursor(us === this.time.play?.atUs ? null : (place ?? null));
    setText(this.boxes.here, us === null ? "" : `${utc(us)}${place ? `  ${position(place)}` : `  ${t("no place known then")}`}`);
  }

  /** The vessel on the map: where it was then, or where it is. */
  private drawPlace(): void {
    const { present, history, map } = this;
    const { address, given, system, fleet } = present;
    const { play } = this.time;
    const others = this.beside.draw(map, play, fleet.systems);
    if (play) {
      const then = this.asItWas();
      const known: Values = then?.values ?? new Map();
      const place = placeAt(history.track, play.atUs, history.silences);
      map.track(address, history.track, play.atUs);
      map.update([systemThen(address, given ?? system?.name ?? nameThen(known), known, place, play.atUs, agesCountTo(play.atUs, then?.us ?? play.atUs, play)), ...others], address, play.atUs);
    } else if (system) map.update([system, ...others].map((one) => asSeen(one, fleet.values.get(one.address), present.nowUs(), present.linked)), address, present.nowUs());
  }
}
