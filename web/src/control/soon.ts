// The Control tab, loaded after the rest of the page: on a slow link the map and STOP come first.

import { make } from "../ui/dom";
import { reloadOffer } from "../ui/reload";
import { soon, t } from "../words/words";
import type { ControlNeeds, ControlPanel } from "./panel";

type Updated = Pick<ControlPanel, "update">;

/** The newest state that came before the tab is here is kept for it. */
export function createControlSoon(root: HTMLElement, needs: ControlNeeds): Updated {
  const waiting = make("p", { role: "status" }, t("Reading …"));
  root.append(waiting);
  let panel: Updated | undefined;
  let last: Parameters<Updated["update"]> | undefined;
  soon(() => import("./panel")).then(
    ({ createControl }) => {
      waiting.remove();
      panel = createControl(root, needs);
      if (last) panel.update(...last);
    },
    () => waiting.replaceWith(reloadOffer()),
  );
  return {
    update(...now) {
      last = now;
      panel?.update(...now);
    },
  };
}
