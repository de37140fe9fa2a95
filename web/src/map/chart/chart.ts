// The chart on a map: layers, what they leave out, what is told about the chart and about the place under the pointer.

import type OlMap from "ol/Map";
import { toLonLat } from "ol/proj";
import { getJson, reason } from "../../api/http";
import type { ChartSet } from "../../api/types.gen";
import { isOverscale, shownScale } from "../../state/chart";
import { make, setAttribute, setText } from "../../ui/dom";
import { count, t } from "../../words/words";
import type { Clicks } from "../clicks";
import { over } from "../layers";
import type { MapTools } from "../tools";
import { chartAt } from "./api";
import { type ChartLayers, createLayers } from "./layers";
import { ChartOptions } from "./options";
import { OwnLimits } from "./own";
import { createQuery, type QueryPanel } from "./query";
import { type ChartStyles, createStyles } from "./style";
import { DepthUnderPointer } from "./under";

/** Whether the chart set is another one is asked so often, ms. */
const AGAIN_MS = 60_000;
/** After tiles did not come the server is asked again this much later, and twice as much each time, ms. */
const LOST_MS = 3_000;
/** Tiles that are on their way for longer are spoken of, ms: on a good line each move of the map would flash words. */
const LOADING_MS = 700;
/** Objects this near to a click are told, px. */
const NEAR_PX = 14;
/** Farther than this nobody meant, m. */
const FARTHEST_M = 2_000;

export interface ChartOnMap {
  /** `then` is called with the chart set, each time that it was asked for. */
  onChart(then: (chart: ChartSet) => void): void;
  repaint(): void;
  dispose(): void;
}

/** What of a map the chart takes part in. */
export interface ChartPlace {
  readonly ol: OlMap;
  /** Beneath it, where the chart is drawn. */
  readonly ground: OlMap;
  readonly tools: MapTools;
  readonly clicks: Clicks;
}

type Mark = (place: { lat_deg: number; lon_deg: number } | null) => void;

/** Draws the chart beneath a map and its words over `box`, for `vessel` where the map is one vessel's. `mark` shows the place that is told of. */
export function createChart(place: ChartPlace, box: HTMLElement, mark: Mark, vessel?: number): ChartOnMap {
  return new Chart(place, box, mark, vessel);
}

class Chart implements ChartOnMap {
  private chart: ChartSet | undefined;
  private readonly learnt: ((chart: ChartSet) => void)[] = [];
  private readonly styles: ChartStyles;
  private readonly layers: ChartLayers;
  private readonly options: ChartOptions;
  private readonly query: QueryPanel;
  /** Tells what is in the middle of the map. */
  private readonly here: HTMLButtonElement;
  private readonly note: HTMLElement;
  private readonly credit = make("p", { class: "chart-credit", hidden: "" });
  private readonly own: OwnLimits | undefined;
  private readonly again: number;
  /** Whether something in view may have to be told again once all is drawn. */
  private due = true;
  /** Whether the map was drawn since other tiles were wanted: what it finished before says nothing of them. */
  private drawn = false;
  /** Until tiles that did not come are asked for again. */
  private patience = LOST_MS;
  private waiting: number | undefined;
  /** Until tiles that are still on their way are spoken of. */
  private loading: number | undefined;
  private asked = new AbortController();

  private readonly map: OlMap;
  private readonly ground: OlMap;

  constructor({ ol: map, ground, tools, clicks }: ChartPlace, private readonly box: HTMLElement, private readonly mark: Mark, private readonly vessel: number | undefined) {
    [this.map, this.ground] = [map, ground];
    let restyled = (): void => undefined;
    this.styles = createStyles(() => restyled());
    this.layers = createLayers(ground, this.styles, () => (this.due = true), () => this.lost());
    restyled = this.layers.changed;
    const depth = tools.line("chart-depth");
    this.note = tools.line("chart-note");
    depth.removeAttribute("role");
    this.options = new ChartOptions(tools, vessel, { own: () => this.own?.limits, without: (left) => this.styles.without(left), chosen: () => this.drawSafety() });
    this.here = tools.button("query", t("What is here"), t("At the middle of the map; click the map for another place"));
    this.query = createQuery(() => {
      mark(null);
      if (this.query.root.contains(document.activeElement)) this.here.focus();
    });
    for (const tool of [this.options.tool, this.here]) tool.hidden = true;
    box.append(this.credit, this.query.root);
    new DepthUnderPointer(map, vessel, () => this.chart?.set != null, (words) => show(depth, words));
    this.listen(clicks);
    this.own = vessel === undefined ? undefined : new OwnLimits(vessel, () => this.drawSafety());
    void this.learn();
    this.again = window.setInterval(() => void this.learn(), AGAIN_MS);
  }

  onChart(then: (chart: ChartSet) => void): void {
    this.learnt.push(then);
    if (this.chart) then(this.chart);
  }

  repaint(): void {
    this.styles.repaint();
    if (this.chart) this.options.drawLegend(this.chart, this.styles.colours());
    this.hatch();
  }

  dispose(): void {
    window.clearInterval(this.again);
    window.clearTimeout(this.waiting);
    window.clearTimeout(this.loading);
    this.own?.dispose();
    this.asked.abort();
  }

  private listen(clicks: Clicks): void {
    const { map, ground } = this;
    this.here.addEventListener("click", () => void this.ask(map.getView().getCenter() ?? [0, 0], true));
    ground.on("moveend", () => this.moved());
    // Before all tiles are there, nobody knows that something is missing.
    ground.on("rendercomplete", () => {
      if (!this.drawn) return;
      if (this.due) this.tell();
      this.due = false;
    });
    clicks.claim("place", (event) => {
      // What lies there but wants no click is not a place of the chart either.
      if (map.hasFeatureAtPixel(event.pixel, { hitTolerance: 8, layerFilter: (layer) => (layer.getZIndex() ?? 0) >= 0 && ![over("rings"), over("nogo")].includes(layer.getZIndex() ?? 0) })) return false;
      void this.ask(event.coordinate, false);
      return true;
    });
  }

  private moved(): void {
    const [, lat = 0] = toLonLat(this.map.getView().getCenter() ?? [0, 0]);
    this.styles.latitude(lat);
    this.due = true;
    this.doubt();
  }

  /** What was said of another place or zoom does not stand over this one while its tiles are on their way. */
  private doubt(): void {
    window.clearTimeout(this.loading);
    if (!this.chart?.set || this.waiting !== undefined) return;
    if (this.layers.scaleAt(this.map.getView().getCenter() ?? [0, 0]) !== undefined) return this.tell();
    show(this.note, "");
    this.loading = window.setTimeout(() => this.due && show(this.note, t("Loading the chart …")), LOADING_MS);
  }

  /** What must be said of the chart in view. */
  private tell(): void {
    const { chart, map } = this;
    window.clearTimeout(this.loading);
    if (!chart) return;
    if (chart.set === null) {
      show(this.note, chart.trouble ? t("The chart cannot be used: {trouble}", { trouble: chart.trouble }) : t("No chart: depths are not known and nothing is checked against them. Import one on the server: lutra-server chart import FOLDER"));
      return;
    }
    const center = map.getView().getCenter() ?? [0, 0];
    const scale = this.layers.scaleAt(center);
    this.styles.finest(this.layers.finest());
    const [, lat = 0] = toLonLat(center);
    const shown = shownScale(map.getView().getResolution() ?? 1, lat);
    const none = this.waiting === undefined ? t("No chart here") : t("The chart does not come from the server; trying again …");
    const coarse = scale !== undefined && isOverscale(scale, shown) ? t("Overscale × {times}: chart 1 : {scale}", { times: (scale / shown).toFixed(0), scale: count(scale) }) : "";
    show(this.note, scale === undefined ? none : coarse);
  }

  /** Whether the server answered. */
  private async learn(): Promise<boolean> {
    try {
      const next = await getJson<ChartSet>("/api/v1/chart");
      const first = this.chart?.set !== next.set || this.chart === undefined;
      this.chart = next;
      this.styles.limits(this.options.limits(next));
      for (const then of this.learnt) then(next);
      if (first) this.begin(next);
      return true;
    } catch (error) {
      if (!this.chart) show(this.note, t("No chart: {reason}", { reason: reason(error) }));
      return false;
    }
  }

  /** Draws another chart set than before. */
  private begin(next: ChartSet): void {
    this.layers.show(next);
    this.redraw();
    this.box.toggleAttribute("data-chart", next.set !== null);
    for (const tool of [this.options.tool, this.here]) tool.hidden = next.set === null;
    this.drawSafety();
    this.hatch();
    this.moved();
    if (next.set === null) this.tell();
  }

  /** Tiles that did not come: the set may be another one by now, or the server was away. */
  private lost(): void {
    if (this.waiting !== undefined) return;
    this.due = true;
    this.waiting = window.setTimeout(async () => {
      this.waiting = undefined;
      this.patience = Math.min(AGAIN_MS, 2 * this.patience);
      const before = this.chart?.set;
      if (!(await this.learn())) return this.lost();
      if (this.chart?.set !== before) return;
      this.layers.again();
      this.redraw();
    }, this.patience);
  }

  /** Other tiles are wanted from the next picture on. */
  private redraw(): void {
    this.drawn = false;
    this.ground.once("postrender", () => (this.drawn = true));
    this.ground.render();
  }

  private drawSafety(): void {
    const { chart, options, styles } = this;
    if (!chart) return;
    styles.limits(options.limits(chart));
    this.drawCredit(chart);
    options.draw(chart, styles.colours());
  }

  private drawCredit(of: ChartSet): void {
    const torn = of.cells.filter(({ whole }) => whole === false).map(({ name }) => name);
    const warned = [...(of.not_for_navigation ? [t("NOT FOR NAVIGATION")] : []), ...(torn.length ? [t("GAPS OR OVERLAPS IN {torn}", { torn: torn.join(", ") })] : [])];
    const [own, depth] = [this.own?.limits, this.options.limits(of).autonomous_m];
    const isOwn = own && depth === own.autonomous_m && own.autonomous_m > of.autonomous_m;
    this.credit.replaceChildren(...warned.flatMap((words) => [make("strong", {}, words), " · "]), isOwn ? t("depths in m below chart datum · safety depth {depth} m, the vessel's own", { depth }) : t("depths in m below chart datum · safety depth {depth} m", { depth }));
    this.credit.hidden = of.set === null;
  }

  private hatch(): void {
    const root = this.map.getTargetElement();
    if (!root) return;
    const { noData, noDataLine } = this.styles.colours();
    root.style.background = this.chart?.set ? `repeating-linear-gradient(45deg, ${noData} 0 14px, ${noDataLine} 14px 15px)` : "";
  }

  /** Asks what is charted at a place. */
  private async ask(coordinate: readonly number[], byKey: boolean): Promise<void> {
    if (!this.chart?.set) return;
    this.asked.abort();
    this.asked = new AbortController();
    const { signal } = this.asked;
    const [lon = 0, lat = 0] = toLonLat([...coordinate]);
    const metres = NEAR_PX * (this.map.getView().getResolution() ?? 1) * Math.cos((lat * Math.PI) / 180);
    try {
      const near = await chartAt(lat, lon, Math.min(FARTHEST_M, metres), this.vessel, signal);
      this.mark({ lat_deg: lat, lon_deg: lon });
      this.query.show(lat, lon, near, byKey);
    } catch (error) {
      if (!signal.aborted) this.query.fail(reason(error));
    }
  }
}

function show(element: HTMLElement, text: string): void {
  setText(element, text);
  setAttribute(element, "hidden", text ? null : "");
}
