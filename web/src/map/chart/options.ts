// What may be left out of the chart, its safety depth, its shades in words, and the charts that it is made of.

import type { ChartSet } from "../../api/types.gen";
import { type DepthLimits, drawnLimits, guarded, keptSwitches, MOST_SAFETY_M, type Switch, SWITCHES } from "../../state/chart";
import { make } from "../../ui/dom";
import { count, t } from "../../words/words";
import type { MapTools } from "../tools";
import type { ChartColours } from "./colours";

/** Charts that are listed by name. */
const MOST_CELLS = 12;
const KEY = "lutra.chart.without";
/** The safety depth that was chosen for a vessel, or for the maps that show several. */
const SAFETY_KEY = "lutra.chart.safety.";

export interface OptionsHandlers {
  /** What the vessel's own guard goes by, where it has told. */
  own(): DepthLimits | undefined;
  without(switches: ReadonlySet<Switch>): void;
  /** Another safety depth was chosen. */
  chosen(): void;
}

export class ChartOptions {
  /** Opens it; hidden where there is no chart. */
  readonly tool: HTMLButtonElement;
  private readonly left = keptSwitches(localStorage.getItem(KEY));
  private readonly safetyKey: string;
  private readonly safety = make("input", { type: "number", step: "0.5", max: String(MOST_SAFETY_M), class: "chart-safety" });
  private readonly cells = make("ul", { class: "chart-cells" });
  private readonly legend = make("ul", { class: "chart-legend", "aria-label": t("Shades") });

  constructor(tools: MapTools, vessel: number | undefined, private readonly on: OptionsHandlers) {
    this.safetyKey = `${SAFETY_KEY}${vessel ?? "all"}`;
    const root = make("div", { class: "chart-options", id: "chart-options", hidden: "" });
    this.tool = tools.button("chart", t("Chart"), t("What is shown of it, its safety depth, its cells"));
    this.tool.setAttribute("aria-expanded", "false");
    this.tool.setAttribute("aria-controls", root.id);
    this.tool.addEventListener("click", () => {
      root.hidden = !root.hidden;
      this.tool.setAttribute("aria-expanded", String(!root.hidden));
    });
    this.safety.addEventListener("change", () => {
      localStorage.setItem(this.safetyKey, this.safety.value);
      on.chosen();
    });
    const always = make("input", { type: "checkbox", disabled: "" });
    always.checked = true;
    const shown = make("fieldset", {}, make("legend", {}, t("Shown")), make("label", { class: "inline" }, always, t("Depths, land and dangers (always)")), ...SWITCHES.map(([name, label]) => this.switchOf(name, label)));
    root.append(shown, make("label", {}, vessel === undefined ? t("Safety depth of the shades, m") : t("Safety depth of this vessel's shades, m"), this.safety), this.legend, make("h3", {}, t("Charts")), this.cells);
    tools.panel(root);
    on.without(this.left);
  }

  /** The limits that are drawn. */
  limits(of: ChartSet): DepthLimits {
    return drawnLimits(guarded(of, this.on.own()), localStorage.getItem(this.safetyKey));
  }

  draw(of: ChartSet, colours: ChartColours): void {
    this.safety.min = String(guarded(of, this.on.own()).autonomous_m);
    this.safety.value = String(this.limits(of).autonomous_m);
    this.drawLegend(of, colours);
    const more = of.cells.length > MOST_CELLS ? [make("li", {}, t("and {n} more", { n: of.cells.length - MOST_CELLS }))] : [];
    this.cells.replaceChildren(...of.cells.slice(0, MOST_CELLS).map((cell) => make("li", {}, t("{name} ed. {edition}.{update}, issued {issued}, 1 : {scale}. {comment}", { name: cell.name, edition: cell.edition, update: cell.update, issued: cell.issued, scale: count(cell.scale), comment: cell.comment }))), ...more);
  }

  drawLegend(of: ChartSet, colours: ChartColours): void {
    const { autonomous_m: safe, navigable_m: least } = this.limits(of);
    const entries: readonly (readonly [string, string])[] = [
      [colours.land, t("land")],
      [colours.drying, t("dries")],
      [colours.veryShallow, t("less than {least} m, or unknown", { least })],
      [colours.shallow, safe > guarded(of, this.on.own()).autonomous_m ? t("{least} to {most} m: less than the safety depth chosen here", { least, most: safe }) : t("{least} to {most} m: only under an operator's hand", { least, most: safe })],
      [colours.safe, t("from {least} m", { least: safe })],
      [colours.deep, t("from {least} m", { least: Math.max(20, 2 * safe) })],
    ];
    this.legend.replaceChildren(
      ...entries.map(([colour, text]) => {
        const swatch = make("i", { class: "chart-swatch" });
        swatch.style.background = colour;
        return make("li", {}, swatch, text);
      }),
    );
  }

  private switchOf(name: Switch, label: string): HTMLElement {
    const input = make("input", { type: "checkbox" });
    input.checked = !this.left.has(name);
    input.addEventListener("change", () => {
      if (input.checked) this.left.delete(name);
      else this.left.add(name);
      localStorage.setItem(KEY, [...this.left].join());
      this.on.without(this.left);
    });
    return make("label", { class: "inline" }, input, label);
  }
}
