// The map: chart, tracks, vessels with heading and course, graticule, scale and cursor position. Needs no internet.

import OlMap from "ol/Map";
import View from "ol/View";
import { boundingExtent } from "ol/extent";
import { defaults as defaultInteractions, MouseWheelZoom } from "ol/interaction";
import { fromLonLat } from "ol/proj";
import type { ChartSet, System, TrackPoint } from "../api/types.gen";
import { setAttribute } from "../ui/dom";
import { systemName } from "../ui/format";
import { t } from "../words/words";
import { type ChartOnMap, createChart } from "./chart/chart";
import { type Clicks, createClicks } from "./clicks";
import { edges } from "./edges";
import { createFollow, type Follow } from "./follow";
import { controls, type Wheel, wheelOn } from "./frame";
import { Graticule } from "./graticule";
import { createGround } from "./ground";
import { createNoGo, type NoGoOnMap } from "./nogo";
import { createOverlays, type Overlays } from "./overlays";
import { createOwnPlace } from "./ownplace";
import { type Palette, readPalette } from "./palette";
import { createRings, type Rings } from "./rings";
import { createTools, type MapTools } from "./tools";
import { VesselsOnMap } from "./vessels";

/** Where the map is until something is known. */
const NOWHERE = fromLonLat([10.4, 63.44]);

export interface FleetMap {
  readonly overlays: Overlays;
  readonly tools: MapTools;
  readonly clicks: Clicks;
  readonly chart: Pick<ChartOnMap, "onChart">;
  readonly noGo: NoGoOnMap;
  /** For what a page draws by itself. */
  readonly ol: OlMap;
  /** What lies beneath it: the chart and the graticule. */
  readonly ground: OlMap;
  /** The colours in force. */
  palette(): Palette;
  /** `then` is called when the colours have changed. */
  onRepaint(then: () => void): void;
  update(systems: readonly System[], selected: number | undefined, nowUs: number): void;
  /** The track; with `untilUs` what comes after it is drawn as yet to come. */
  track(address: number, points: readonly TrackPoint[], untilUs?: number): void;
  /** Brings all systems into view. */
  showAll(): void;
  dispose(): void;
}

export interface MapNeeds {
  /** Called with the address of a vessel that is clicked. */
  readonly select?: (address: number) => void;
  /** Where it is one vessel's map. */
  readonly vessel?: number;
  /** Those with the first colours. */
  readonly first?: readonly number[];
  /** What brings all into view, where that is not vessels and their tracks. */
  readonly showAll?: () => void;
}

/** Draws into `root`. */
export function createMap(root: HTMLElement, needs: MapNeeds = {}): FleetMap {
  return new MapOfFleet(root, needs);
}

class MapOfFleet implements FleetMap {
  readonly ol: OlMap;
  readonly ground: OlMap;
  readonly overlays: Overlays;
  readonly tools: MapTools;
  readonly clicks: Clicks;
  readonly chart: ChartOnMap;
  readonly noGo: NoGoOnMap;
  private colours: Palette;
  private readonly graticule: Graticule;
  private readonly vessels: VesselsOnMap;
  private readonly wheel: Wheel;
  private readonly follow: Follow | undefined;
  private readonly rings: Rings | undefined;
  private readonly repainted: (() => void)[] = [];
  private readonly dark = matchMedia("(prefers-color-scheme: dark)");
  private readonly repaint = (): void => this.paint();
  private readonly chosen = new MutationObserver(this.repaint);
  private last: { systems: readonly System[]; selected: number | undefined; nowUs: number } = { systems: [], selected: undefined, nowUs: 0 };
  private seen = false;

  constructor(private readonly root: HTMLElement, private readonly needs: MapNeeds) {
    const { select, vessel } = needs;
    this.colours = readPalette(needs.first ?? []);
    const palette = (): Palette => this.colours;
    this.wheel = wheelOn(root);
    // Course up near north is not pulled to north.
    const view = new View({ center: NOWHERE, zoom: 12, maxZoom: 22, minZoom: 2, constrainRotation: false });
    const map = new OlMap({
      target: root,
      interactions: defaultInteractions({ mouseWheelZoom: false }).extend([new MouseWheelZoom({ condition: this.wheel.isOwn })]),
      controls: controls(() => (this.follow ? this.follow.northUp() : map.getView().setRotation(0))),
      view,
    });
    [this.ol, this.ground] = [map, createGround(root, view)];
    this.graticule = new Graticule(palette);
    this.ground.addLayer(this.graticule);
    this.vessels = new VesselsOnMap(map, palette);
    const box = root.parentElement ?? root;
    [this.tools, this.clicks] = [createTools(box), createClicks(map)];
    if (select) this.listen(select);
    this.overlays = createOverlays(map, this.clicks, palette);
    this.chart = createChart(this, box, (place) => this.overlays.cursor(place), vessel);
    this.chart.onChart(({ bounds }) => this.leadTo(bounds));
    this.noGo = createNoGo(map, palette);
    // The chart is another one whenever an area was closed or lifted; it is asked for once a minute.
    this.chart.onChart(() => void this.noGo.learn());
    this.tools.button("all", t("Show all")).addEventListener("click", () => (needs.showAll ? needs.showAll() : this.showAll()));
    // Where no vessel is chosen there is none to go with.
    const around = select || vessel !== undefined;
    this.follow = around ? createFollow(map, this.tools) : undefined;
    this.rings = around ? createRings(map, this.tools, palette) : undefined;
    createOwnPlace(this, () => this.compared());
    this.dark.addEventListener("change", this.repaint);
    this.chosen.observe(document.documentElement, { attributeFilter: ["data-palette"] });
  }

  palette(): Palette {
    return this.colours;
  }

  onRepaint(then: () => void): void {
    this.repainted.push(then);
  }

  update(systems: readonly System[], selected: number | undefined, nowUs: number): void {
    this.last = { systems, selected, nowUs };
    setAttribute(this.root, "data-old", systems.filter(({ fix, liveness }) => fix && (liveness === "stale" || liveness === "lost")).map(({ address }) => address).join(" ") || null);
    this.vessels.update(systems, selected, nowUs);
    const chosen = systems.find(({ address }) => address === selected)?.fix ?? undefined;
    this.follow?.update(chosen);
    this.rings?.update(chosen);
    if (this.seen || !systems.some((system) => system.fix)) return;
    this.seen = true;
    this.showAll();
  }

  track(address: number, points: readonly TrackPoint[], untilUs?: number): void {
    this.vessels.track(address, points, untilUs);
  }

  showAll(): void {
    const vessels = this.last.systems.flatMap((system) => (system.fix ? [fromLonLat([system.fix.lon_deg, system.fix.lat_deg])] : []));
    const places = [...vessels, ...this.vessels.trackCoordinates()];
    if (places.length) this.ol.getView().fit(boundingExtent(places), { padding: edges(this.root.clientWidth), maxZoom: 16, duration: 0 });
  }

  dispose(): void {
    this.chart.dispose();
    this.wheel.dispose();
    this.dark.removeEventListener("change", this.repaint);
    this.chosen.disconnect();
    this.ground.getTargetElement()?.remove();
    for (const one of [this.ol, this.ground]) one.setTarget(undefined);
  }

  private listen(select: (address: number) => void): void {
    this.clicks.claim("vessel", ({ pixel }) => {
      const hit = this.ol.forEachFeatureAtPixel(pixel, (feature) => feature.get("address") as number | undefined, { hitTolerance: 8 });
      if (hit !== undefined) select(hit);
      return hit !== undefined;
    });
  }

  /** While nobody has led the map anywhere yet, the chart is a better place than none. */
  private leadTo(bounds: ChartSet["bounds"]): void {
    if (!bounds || String(this.ol.getView().getCenter()) !== String(NOWHERE)) return;
    const corners = [[bounds.west_deg, bounds.south_deg], [bounds.east_deg, bounds.north_deg]].map((corner) => fromLonLat(corner));
    this.ol.getView().fit(boundingExtent(corners), { padding: [20, 20, 20, 20], duration: 0 });
  }

  /** The vessel that the page is about, or that is chosen: the person's own place is compared with it. */
  private compared(): { name: string; lat_deg: number; lon_deg: number } | undefined {
    const system = this.last.systems.find(({ address }) => address === this.last.selected);
    return system?.fix ? { name: systemName(system), lat_deg: system.fix.lat_deg, lon_deg: system.fix.lon_deg } : undefined;
  }

  private paint(): void {
    this.colours = readPalette(this.needs.first ?? []);
    this.graticule.changed();
    this.vessels.repaint();
    this.update(this.last.systems, this.last.selected, this.last.nowUs);
    this.overlays.repaint();
    this.noGo.repaint();
    this.rings?.repaint();
    this.chart.repaint();
    for (const then of this.repainted) then();
  }
}
