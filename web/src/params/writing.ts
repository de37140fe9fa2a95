// Writing parameters to a vessel and reading them back, after a second step where that may change how it moves.

import { reason } from "../api/http";
import type { Command } from "../api/types.gen";
import type { Orders } from "../control/orders";
import { setText } from "../ui/dom";
import type { ParameterView } from "./view";
import { changesOf, changeText, type Outcome, outcomeOf, OUTCOMES, type Row, wireText } from "./model";
import type { Reader } from "./reading";
import { stepText } from "../state/orderwords";
import { t, tn } from "../words/words";

/** What would be written, by entity. */
type Changes = ReturnType<typeof changesOf>;

/** Shows what would be written, in words; a second step where it changes at once how a vessel moves. */
export function askWrite(view: ParameterView, orders: Orders, reader: Reader): void {
  const wrong = view.rows.find((row) => row.problem);
  if (wrong) {
    view.form.fail(t("{name} of {entity}: {problem}", { name: wrong.told.name, entity: wrong.entity, problem: wrong.problem }));
    view.table.focus(wrong.key);
    return;
  }
  const changes = changesOf(view.rows);
  const wanted = [...changes.values()].flat();
  if (!wanted.length) return;
  view.form.fail("");
  const cautions = new Set(wanted.flatMap(({ told: { about } }) => (about ? (about.caution ?? []) : t("its meaning is unknown to Lutra"))));
  const go = (): void => void writeAll(view, orders, reader, changes);
  if (!cautions.size && !view.moves) return go();
  const name = view.name();
  const lines = [view.moves ? t("Vessel: {name}, which may be under way", { name }) : t("Vessel: {name}", { name }), ...wanted.map((row) => `${row.entity}, ${changeText(row)}`), ...[...cautions].map((why) => t("Take care: {why}.", { why }))];
  view.confirm.ask(tn(wanted.length, "Write 1 parameter to {name}?", "Write {n} parameters to {name}?", { name }), lines, t("Write to vessel"), go);
}

/** Writes what was asked about, whatever was typed since. */
async function writeAll(view: ParameterView, orders: Orders, reader: Reader, changes: Changes): Promise<void> {
  if (view.busy) return;
  view.begin(t("Writing to {name} …", { name: view.name() }));
  const counts = new Map<Outcome["kind"], number>();
  for (const [entity, changed] of changes) {
    for (const row of changed) view.outcomes.set(row.key, { kind: "pending", text: "" });
    view.draw();
    for (const [of, outcome] of await writeOne(view, orders, reader, entity, changed)) {
      view.outcomes.set(of, outcome);
      counts.set(outcome.kind, (counts.get(outcome.kind) ?? 0) + 1);
      if (outcome.kind !== "confirmed") continue;
      const next = new Map(view.edits);
      next.delete(of);
      view.edits = next;
    }
    view.draw();
  }
  setText(view.form.said, t("Written: {values}.", { values: [...counts].map(([kind, count]) => `${count} ${OUTCOMES[kind]}`).join(", ") }));
  view.end();
}

/** Writes what was changed of one entity and reads it back; what became of each. */
async function writeOne(view: ParameterView, orders: Orders, reader: Reader, entity: string, changed: readonly Row[]): Promise<Map<string, Outcome>> {
  const all = (outcome: (row: Row) => Outcome): Map<string, Outcome> => new Map(changed.map((row) => [row.key, outcome(row)]));
  const values = changed.map((row) => ({ name: row.told.name, value: wireText(row.edit ?? "", row) }));
  let command: Command;
  try {
    command = await orders.settle({ kind: "parameters.set", entity, values });
  } catch (error) {
    return all(() => ({ kind: "refused", text: t("Not written: {reason}", { reason: reason(error) }) }));
  }
  const last = command.steps.at(-1);
  try {
    const { told: now, silent } = await reader.read([entity]);
    view.told = now;
    const back = silent.length ? undefined : now.entities.find((one) => one.entity === entity)?.parameters;
    return all((row) => outcomeOf(wireText(row.edit ?? "", row), back?.find((one) => one.name === row.told.name), last?.stage ?? "", last ? stepText(last) : ""));
  } catch (error) {
    return all(() => ({ kind: "timed out", text: t("Not read back: {reason}", { reason: reason(error) }) }));
  }
}
