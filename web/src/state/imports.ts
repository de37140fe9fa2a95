// How an import of a log stands, in words: pure.

import type { ImportState } from "../api/types.gen";
import { t } from "../words/words";

export const IMPORT_STATES: Readonly<Record<ImportState, string>> = { running: t("running"), done: t("done"), failed: t("failed"), cancelled: t("cancelled") };
