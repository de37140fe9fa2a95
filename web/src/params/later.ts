// The table of parameters, loaded when it is first opened: few who look at a vessel open it.

import { make } from "../ui/dom";
import { later, t } from "../words/words";
import { reloadOffer } from "../ui/reload";
import type { ParameterNeeds, ParameterPanel } from "./parameters";

export function createParametersLater(root: HTMLElement, needs: ParameterNeeds): ParameterPanel {
  const waiting = make("p", { role: "status" }, t("Reading …"));
  let panel: ParameterPanel | undefined;
  let isAsked = false;
  const load = (): void => {
    isAsked = true;
    root.append(waiting);
    later(() => import("./parameters")).then(
      ({ createParameters }) => {
        waiting.remove();
        panel = createParameters(root, needs);
      },
      () => waiting.replaceWith(reloadOffer()),
    );
  };
  return {
    update: (...state) => {
      const [, , , , shown] = state;
      if (!isAsked && shown) load();
      panel?.update(...state);
    },
    heard: (frame) => panel?.heard(frame),
  };
}
