// Why people should look twice at a detection, in words.

import type { DetectionFlag, FlagCode } from "../api/types.gen";
import { t } from "../words/words";

/** What a flag is called. */
export function flagWord(code: FlagCode): string {
  switch (code) {
    case "unconfirmed": return t("unconfirmed");
    case "clock_not_set": return t("clock not set");
    case "clock_lost": return t("clock lost");
    case "clock_off": return t("clock off");
    case "no_place": return t("no place");
    case "old_place": return t("old place");
    case "lines_lost": return t("lines lost before");
  }
}

/** Why a detection has it. */
export function flagReason({ code, figure }: DetectionFlag): string {
  const n = Math.round(figure ?? 0);
  switch (code) {
    case "unconfirmed": return t("No other detection of this tag by this receiver within {n} s, 30 ping intervals: perhaps a false one.", { n });
    case "clock_not_set": return t("The receiver's clock was never set: the time is the vessel's.");
    case "clock_lost": return t("The receiver's clock was lost: the time is the vessel's.");
    case "clock_off": return t("The receiver's clock is {n} s off the vessel's.", { n });
    case "no_place": return t("The vessel did not know where it was.");
    case "old_place": return t("The nearest measured position is {n} s away.", { n });
    case "lines_lost": return t("{n} lines of the receiver were lost right before.", { n });
  }
}
