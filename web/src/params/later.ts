// The table of parameters, loaded when it is first opened: few who look at a vessel open it.

import { reason } from "../api/http";
import { make, setText } from "../ui/dom";
import { later, t } from "../words/words";
import type { ParameterNeeds, ParameterPanel } from "./panel";

/** It is tried again after so long, ms. */
const AGAIN_MS = 5_000;

export function createParametersLater(root: HTMLElement, needs: ParameterNeeds): ParameterPanel {
  const told = make("p", { role: "status" });
  root.append(told);
  let panel: ParameterPanel | undefined;
  let nextMs = 0;
  const load = (): void => {
    const now = performance.now();
    if (now < nextMs) return;
    nextMs = Infinity;
    setText(told, t("Reading …"));
    later(() => import("./panel")).then(
      ({ createParameters }) => {
        told.remove();
        panel = createParameters(root, needs);
      },
      (error: unknown) => {
        setText(told, reason(error));
        nextMs = performance.now() + AGAIN_MS;
      },
    );
  };
  return {
    update: (...state) => {
      const [, , , , shown] = state;
      if (!panel && shown) load();
      panel?.update(...state);
    },
    heard: (frame) => panel?.heard(frame),
  };
}
