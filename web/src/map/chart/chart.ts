// The chart on a map: layers, what they leave out, what is told about the chart and about the place under the pointer.

import type OlMap from "ol/Map";
import { toLonLat } from "ol/proj";
import { getJson, reason } from "../../api/http";
import type { ChartSet } from "../../api/types.gen";
import { createReader } from "../../params/reading";
import { type DepthLimits, drawnLimits, guarded, isOverscale, keptSwitches, MOST_SAFETY_M, ownLimits, shownScale, type Switch, SWITCHES } from "../../state/chart";
import { GUARD_ENTITY } from "../../state/teleop";
import { make, setAttribute, setText } from "../../ui/dom";
import type { Clicks } from "../clicks";
import { over } from "../layers";
import type { MapTools } from "../tools";
import { chartAt, depthWords } from "./api";
import { createLayers } from "./layers";
import { createQuery } from "./query";
import { createStyles } from "./style";

/** The depth under the pointer is asked for at most so often, ms. */
const DEPTH_MS = 120;
/** Whether the chart set is another one is asked so often, ms. */
const AGAIN_MS = 60_000;
/** A vessel that has not told its limits yet is asked again this much later, and twice as much each time, ms. */
const OWN_AGAIN_MS = 5_000;
/** After tiles did not come the server is asked again this much later, and twice as much each time, ms. */
const LOST_MS = 3_000;
/** Objects this near to a click are told, px. */
const NEAR_PX = 14;
/** Charts that are listed by name. */
const MOST_CELLS = 12;
/** Farther than this nobody meant, m. */
const FARTHEST_M = 2_000;
const KEY = "lutra.chart.without";
/** The safety depth that was chosen for a vessel, or for the maps that show several. */
const SAFETY_KEY = "lutra.chart.safety.";

export interface ChartOnMap {
  /** `then` is called with the chart set, again whenever it is another one. */
  onChart(then: (chart: ChartSet) => void): void;
  repaint(): void;
  dispose(): void;
}

/** Draws the chart onto `map` and its words over `box`, for `vessel` where the map is one vessel's. `mark` shows the place that is told of. */
export function createChart(map: OlMap, box: HTMLElement, { tools, clicks }: { readonly tools: MapTools; readonly clicks: Clicks }, mark: (place: { lat_deg: number; lon_deg: number } | null) => void, vessel?: number): ChartOnMap {
  const left = keptSwitches(localStorage.getItem(KEY));
  let restyled = (): void => undefined;
  const styles = createStyles(() => restyled());
  // Whether something in view may have to be told anew once all is drawn.
  let due = true;
  const layers = createLayers(map, styles, () => (due = true), () => lost());
  restyled = layers.changed;
  styles.without(left);
  let chart: ChartSet | undefined;
  const safetyKey = `${SAFETY_KEY}${vessel ?? "all"}`;
  // What the vessel's own guard goes by, once it has told.
  let own: DepthLimits | undefined;
  const limits = (of: ChartSet): DepthLimits => drawnLimits(guarded(of, own), localStorage.getItem(safetyKey));
  const learnt: ((chart: ChartSet) => void)[] = [];

  // What is told.
  const [depth, note] = [tools.line("chart-depth"), tools.line("chart-note")];
  depth.removeAttribute("role");
  const credit = make("p", { class: "chart-credit", hidden: "" });
  const query = createQuery(() => {
    mark(null);
    if (query.root.contains(document.activeElement)) here.focus();
  });

  // What may be left out.
  const options = make("div", { class: "chart-options", id: "chart-options", hidden: "" });
  const open = tools.button("chart", "Chart", "What is shown of it, its safety depth, its cells");
  const here = tools.button("query", "What is here", "At the middle of the map; a click on the map tells of its place");
  setAttribute(open, "aria-expanded", "false");
  setAttribute(open, "aria-controls", "chart-options");
  for (const tool of [open, here]) tool.hidden = true;
  tools.panel(options);
  open.addEventListener("click", () => {
    options.hidden = !options.hidden;
    open.setAttribute("aria-expanded", String(!options.hidden));
  });
  here.addEventListener("click", () => void ask(map.getView().getCenter() ?? [0, 0], true));
  const switches = SWITCHES.map(([name, label]) => {
    const input = make("input", { type: "checkbox" });
    input.checked = !left.has(name);
    input.addEventListener("change", () => leave(name, !input.checked));
    return make("label", { class: "inline" }, input, label);
  });
  const always = make("input", { type: "checkbox", disabled: "" });
  always.checked = true;
  const safety = make("input", { type: "number", step: "0.5", max: String(MOST_SAFETY_M), class: "chart-safety" });
  safety.addEventListener("change", () => {
    if (!chart) return;
    localStorage.setItem(safetyKey, safety.value);
    drawSafety(chart);
  });
  const cells = make("ul", { class: "chart-cells" });
  const legend = make("ul", { class: "chart-legend", "aria-label": "Shades" });
  options.append(make("fieldset", {}, make("legend", {}, "Shown"), make("label", { class: "inline" }, always, "Depths, land and dangers (always)"), ...switches), make("label", {}, vessel === undefined ? "Safety depth of the shades, m" : "Safety depth of this vessel's shades, m", safety), legend, make("h3", {}, "Charts"), cells);
  const drawSafety = (of: ChartSet): void => {
    const { autonomous_m: safe } = limits(of);
    safety.min = String(guarded(of, own).autonomous_m);
    safety.value = String(safe);
    styles.limits(limits(of));
    drawCredit(of);
    drawLegend();
  };
  const leave = (name: Switch, out: boolean): void => {
    if (out) left.add(name);
    else left.delete(name);
    localStorage.setItem(KEY, [...left].join());
    styles.without(left);
  };
  box.append(credit, query.root);

  const drawLegend = (): void => {
    if (!chart) return;
    const { autonomous_m: safe, navigable_m: least } = limits(chart);
    const colours = styles.colours();
    const entries: readonly (readonly [string, string])[] = [
      [colours.land, "land"],
      [colours.drying, "dries"],
      [colours.veryShallow, `less than ${least} m, or unknown`],
      [colours.shallow, `${least} to ${safe} m: ${safe > guarded(chart, own).autonomous_m ? "less than the safety depth chosen here" : "only under an operator's hand"}`],
      [colours.safe, `from ${safe} m`],
      [colours.deep, `from ${Math.max(20, 2 * safe)} m`],
    ];
    legend.replaceChildren(
      ...entries.map(([colour, text]) => {
        const swatch = make("i", { class: "chart-swatch" });
        swatch.style.background = colour;
        return make("li", {}, swatch, text);
      }),
    );
  };

  const hatch = (): void => {
    const root = map.getTargetElement();
    if (!root) return;
    const { noData, noDataLine } = styles.colours();
    root.style.background = chart?.set ? `repeating-linear-gradient(45deg, ${noData} 0 14px, ${noDataLine} 14px 15px)` : "";
  };

  // Until tiles that did not come are asked for again.
  let patience = LOST_MS;
  let waiting: number | undefined;

  /** What must be said of the chart in view. */
  const tell = (): void => {
    if (!chart) return;
    if (chart.set === null) {
      show(note, chart.trouble ? `The chart cannot be used: ${chart.trouble}` : "No chart: depths are not known and nothing is checked against them. Import one on the server: lutra-server chart import FOLDER");
      return;
    }
    const center = map.getView().getCenter() ?? [0, 0];
    const scale = layers.scaleAt(center);
    const [, lat = 0] = toLonLat(center);
    const shown = shownScale(map.getView().getResolution() ?? 1, lat);
    const says = scale === undefined ? (waiting === undefined ? "No chart here" : "The chart does not come from the server; trying again …") : isOverscale(scale, shown) ? `Overscale × ${(scale / shown).toFixed(0)}: chart 1 : ${scale.toLocaleString("en")}` : "";
    show(note, says);
  };
  const moved = (): void => {
    const [, lat = 0] = toLonLat(map.getView().getCenter() ?? [0, 0]);
    styles.latitude(lat);
    due = true;
  };
  map.on("moveend", moved);
  // Before all tiles are there, nobody knows that something is missing.
  map.on("rendercomplete", () => {
    if (due) tell();
    due = false;
  });

  /** Whether the server answered. */
  const learn = async (): Promise<boolean> => {
    try {
      const next = await getJson<ChartSet>("/api/v1/chart");
      const first = chart?.set !== next.set || chart === undefined;
      chart = next;
      styles.limits(limits(next));
      for (const then of learnt) then(next);
      if (first) {
        layers.show(next);
        box.toggleAttribute("data-chart", next.set !== null);
        for (const tool of [open, here]) tool.hidden = next.set === null;
        drawSafety(next);
        hatch();
        moved();
        if (next.set === null) tell();
      }
      return true;
    } catch (error) {
      if (!chart) show(note, `No chart: ${reason(error)}`);
      return false;
    }
  };
  // Tiles that did not come: the set may be another one by now, or the server was away.
  const lost = (): void => {
    if (waiting !== undefined) return;
    due = true;
    waiting = window.setTimeout(async () => {
      waiting = undefined;
      patience = Math.min(AGAIN_MS, 2 * patience);
      const before = chart?.set;
      if (!(await learn())) return lost();
      if (chart?.set === before) layers.again();
    }, patience);
  };
  const drawCredit = (of: ChartSet): void => {
    const torn = of.cells.filter(({ whole }) => whole === false).map(({ name }) => name);
    const warned = [...(of.not_for_navigation ? ["NOT FOR NAVIGATION"] : []), ...(torn.length ? [`GAPS OR OVERLAPS IN ${torn.join(", ")}`] : [])];
    credit.replaceChildren(...warned.flatMap((words) => [make("strong", {}, words), " · "]), `depths in m below chart datum · safety depth ${limits(of).autonomous_m} m${own && limits(of).autonomous_m === own.autonomous_m && own.autonomous_m > of.autonomous_m ? ", the vessel's own" : ""}`);
    credit.hidden = of.set === null;
    cells.replaceChildren(...of.cells.slice(0, MOST_CELLS).map((cell) => make("li", {}, `${cell.name} ed. ${cell.edition}.${cell.update}, issued ${cell.issued}, 1 : ${cell.scale.toLocaleString("en")}. ${cell.comment}`)), ...(of.cells.length > MOST_CELLS ? [make("li", {}, `and ${of.cells.length - MOST_CELLS} more`)] : []));
  };

  // The depth under the pointer: one question at a time, always for where the pointer is by then.
  let wanted: number[] | undefined;
  let asking = false;
  const follow = async (): Promise<void> => {
    if (asking) return;
    asking = true;
    while (wanted) {
      const place = wanted;
      wanted = undefined;
      const [lon = 0, lat = 0] = toLonLat(place);
      try {
        const answer = await chartAt(lat, lon, 0, vessel);
        if (pointed) show(depth, depthWords(answer.depth));
      } catch {
        show(depth, "");
      }
      await new Promise((done) => setTimeout(done, DEPTH_MS));
    }
    asking = false;
  };
  let pointed = false;
  map.on("pointermove", (event) => {
    if (!chart?.set || event.dragging) return;
    pointed = true;
    wanted = event.coordinate;
    void follow();
  });
  map.getViewport()?.addEventListener("pointerleave", () => {
    pointed = false;
    wanted = undefined;
    show(depth, "");
  });

  let asked = new AbortController();
  const ask = async (coordinate: readonly number[], byKey: boolean): Promise<void> => {
    if (!chart?.set) return;
    asked.abort();
    asked = new AbortController();
    const { signal } = asked;
    const [lon = 0, lat = 0] = toLonLat([...coordinate]);
    const metres = NEAR_PX * (map.getView().getResolution() ?? 1) * Math.cos((lat * Math.PI) / 180);
    try {
      const near = await chartAt(lat, lon, Math.min(FARTHEST_M, metres), vessel, signal);
      mark({ lat_deg: lat, lon_deg: lon });
      query.show(lat, lon, near, byKey);
    } catch (error) {
      if (!signal.aborted) query.fail(reason(error));
    }
  };
  clicks.claim("place", (event) => {
    // What lies there but wants no click is no place of the chart either.
    if (map.hasFeatureAtPixel(event.pixel, { hitTolerance: 8, layerFilter: (layer) => (layer.getZIndex() ?? 0) >= 0 && layer.getZIndex() !== over("rings") })) return false;
    void ask(event.coordinate, false);
    return true;
  });

  // What the vessel has told anybody does; it is asked only where it has told nobody. One that has no such guard, is not
  // heard or may not be asked has the limits of the server.
  const reader = vessel === undefined ? undefined : createReader(`/api/v1/vessels/${vessel}`);
  let untold: number | undefined;
  let soon = OWN_AGAIN_MS;
  const learnOwn = async (from: NonNullable<typeof reader>): Promise<void> => {
    const told = await from.known().then(async (known) => ownLimits(known) ?? ownLimits((await from.read([GUARD_ENTITY])).told)).catch(() => undefined);
    if (told && (told.navigable_m !== own?.navigable_m || told.autonomous_m !== own.autonomous_m)) {
      own = told;
      if (chart) drawSafety(chart);
    }
    if (gone) return;
    untold = window.setTimeout(() => void learnOwn(from), own ? AGAIN_MS : soon);
    soon = Math.min(AGAIN_MS, 2 * soon);
  };
  let gone = false;
  if (reader) void learnOwn(reader);
  void learn();
  const again = window.setInterval(() => void learn(), AGAIN_MS);
  return {
    onChart(then) {
      learnt.push(then);
      if (chart) then(chart);
    },
    repaint() {
      styles.repaint();
      drawLegend();
      hatch();
    },
    dispose() {
      window.clearInterval(again);
      window.clearTimeout(waiting);
      gone = true;
      window.clearTimeout(untold);
      asked.abort();
    },
  };
}

function show(element: HTMLElement, text: string): void {
  setText(element, text);
  setAttribute(element, "hidden", text ? null : "");
}
