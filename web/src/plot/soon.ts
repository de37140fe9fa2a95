// The plots, loaded after the rest of the page: on a slow link the map and STOP come first.

import { make } from "../ui/dom";
import { reloadOffer } from "../ui/reload";
import { soon, t } from "../words/words";
import type { PlotPanel, Plots } from "./plots";

/** What is asked of the plots before they are here is done when they are; what is live then comes again by itself. */
export function createPlotsSoon(...[root, ...needs]: ConstructorParameters<typeof Plots>): PlotPanel {
  const waiting = make("p", { role: "status" }, t("Reading …"));
  root.append(waiting);
  let panel: PlotPanel | undefined;
  let asked: ((plots: PlotPanel) => void)[] = [];
  const ask = (question: (plots: PlotPanel) => void): void => {
    if (panel) question(panel);
    else asked.push(question);
  };
  soon(() => import("./plots")).then(
    ({ Plots }) => {
      waiting.remove();
      panel = new Plots(root, ...needs);
      for (const question of asked) question(panel);
      asked = [];
    },
    () => waiting.replaceWith(reloadOffer()),
  );
  return {
    range: (range) => ask((plots) => plots.range(range)),
    add: (source) => ask((plots) => plots.add(source)),
    catalogue: (series, gaps) => ask((plots) => plots.catalogue(series, gaps)),
    beside: (companions) => ask((plots) => plots.beside(companions)),
    live: (values) => panel?.live(values),
    goOn: (nowUs) => panel?.goOn(nowUs),
    cursor: (us) => panel?.cursor(us),
  };
}
