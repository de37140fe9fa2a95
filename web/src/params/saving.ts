// Saving the parameters that a vessel has now for its next start, and seeing whether it did.

import { reason } from "../api/http";
import type { Orders } from "../control/orders";
import { setText } from "../ui/dom";
import type { ParameterView } from "./view";
import type { Reader } from "./reading";
import { stageInFull } from "../state/orderwords";
import { t } from "../words/words";

/** A vessel that has not saved by then did not save. */
const SAVED_WITHIN_MS = 10_000;
const READ_EACH_MS = 500;

/** Shows what the vessel would save; the second step saves it. */
export function askSave(view: ParameterView, orders: Orders, reader: Reader): void {
  const found = view.unsaved();
  const lines = [...found].flatMap(([entity, of]) => of.filter((row) => row.unsaved || view.outcomes.has(row.key)).map((row) => `${entity}, ${row.told.name}: ${row.shown.saved ?? "?"} → ${row.shown.value}${row.shown.unit ? ` ${row.shown.unit}` : ""}`));
  const name = view.name();
  view.confirm.ask(t("Save parameters to {name}?", { name }), [t("{name} will have these values at its next start:", { name }), ...lines], t("Save"), () => void saveAll(view, orders, reader, [...found.keys()]));
}

async function saveAll(view: ParameterView, orders: Orders, reader: Reader, entities: readonly string[]): Promise<void> {
  if (view.busy) return;
  view.begin(t("Saving to {name} …", { name: view.name() }));
  const { said, fail } = view.form;
  try {
    for (const entity of entities) {
      const last = (await orders.settle({ kind: "parameters.save", entity })).steps.at(-1);
      if (last?.stage !== "received" && last?.stage !== "effect seen") throw new Error(`${entity}: ${last ? stageInFull(last) : t("not sent")}`);
    }
    const { left, tells } = await untilSaved(view, reader, entities);
    setText(said, !tells ? t("Sent. This vessel does not report what it saved.") : left.size ? "" : t("Saved: the vessel reports these values for its next start."));
    if (tells && left.size) fail(t("Not saved: {parts}. The vessel's log book says why.", { parts: [...left.keys()].join(", ") }));
  } catch (error) {
    setText(said, "");
    fail(error instanceof Error && error.constructor === Error ? t("Not saved: {message}", { message: error.message }) : t("Not saved: {reason}", { reason: reason(error) }));
  }
  view.end();
}

/** Reads again until the vessel reports that all is saved: its disk may take some seconds. What is left, and whether it tells. */
async function untilSaved(view: ParameterView, reader: Reader, entities: readonly string[]): Promise<{ left: ReturnType<ParameterView["unsaved"]>; tells: boolean }> {
  for (const end = performance.now() + SAVED_WITHIN_MS; ; await new Promise((done) => setTimeout(done, READ_EACH_MS))) {
    view.take((await reader.read(entities)).told);
    const left = view.unsaved();
    const tells = view.rows.some((row) => row.unsaved !== null);
    if (!tells || !left.size || performance.now() > end) return { left, tells };
  }
}
