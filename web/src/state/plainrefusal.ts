// Why something was refused, where the chart has nothing to do with it. Pure.

import type { NoControl, RefusalReason } from "../api/types.gen";
import { t, worded } from "../words/words";

/** In the person's language; what the catalogue lacks is said as the server said it. */
export function plainRefusal({ text, control, says }: RefusalReason): string {
  return control ? controlText(control) : worded({ text, says });
}

function controlText(control: NoControl): string {
  switch (control.why) {
    case "free":
      return t("You do not have control of this vessel: take it first.");
    case "held":
      return t("You do not have control of this vessel: {by} has it.", { by: control.by });
    case "other_window":
      return t("Another of your windows has control of this vessel: take it here first.");
    case "expired":
      return t("Your control of this vessel expired: take it again.");
    case "nobody_waits":
      return t("Nobody waits for control of this vessel.");
    case "asked":
      return t("{by} has asked already and gets an answer within {n} s.", { by: control.by, n: control.within_s });
    case "reason_needed":
      return t("Say why you take over: {by} will see it.", { by: control.by });
    case "too_long":
      return t("This is longer than {n} characters.", { n: control.most });
  }
}
