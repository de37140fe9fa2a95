// The Parameters tab: read from the vessel, change, write with read-back, save for its next start.

import { reason } from "../api/http";
import type { Command, LiveFrame, System, VesselParameters } from "../api/types.gen";
import { createConfirm } from "../control/confirm";
import { createOrders, windowKey } from "../control/orders";
import { type ControlState, partOf, whoHas } from "../state/control";
import { make, setAttribute, setText } from "../ui/dom";
import { age } from "../ui/format";
import { changesOf, changeText, type Edits, isShown, type Outcome, outcomeOf, type Row, rowsOf, type Show, withEdit } from "./model";
import { createReader } from "./reading";
import { createTable } from "./table";

/** Changes that others make are looked at so long after they were heard, ms. */
const SETTLE_MS = 500;

export interface ParameterNeeds {
  readonly address: number;
  readonly me: string;
  /** Whether the person may command this vessel. */
  readonly may: boolean;
  name(): string;
  /** Leads to where control is taken. */
  openControl(): void;
}

export interface ParameterPanel {
  /** `moves`: whether the vessel is under way, or nobody knows. */
  update(control: ControlState, system: System | undefined, nowUs: number, moves: boolean, shown: boolean): void;
  heard(frame: LiveFrame): void;
}

export function createParameters(root: HTMLElement, { address, me, may, name, openControl }: ParameterNeeds): ParameterPanel {
  const path = `/api/v1/vessels/${address}`;
  const kept = `lutra-parameters-${address}`;
  const [key, reader] = [windowKey(), createReader(path)];
  const orders = createOrders(address, key);
  const button = (text: string, act: () => void, kind = ""): HTMLButtonElement => {
    const made = make("button", { type: "button", ...(kind ? { class: kind } : {}) }, text);
    made.addEventListener("click", act);
    return made;
  };
  const find = make("input", { type: "search", placeholder: "name or meaning" });
  const choice = make("select", {}, ...([["all", "all"], ["edited", "changed here"], ["unsaved", "differs from saved"], ["changed", "differs from default"]] as const).map(([value, text]) => make("option", { value }, text)));
  const again = button("Read from vessel", () => void read());
  const write = button("Write", () => ask(), "main");
  const forget = button("Forget changes", () => {
    edits = new Map();
    outcomes.clear();
    draw();
  });
  const save = button("Save to vessel …", () => askSave());
  const lead = button("Control …", openControl);
  const trouble = make("p", { class: "note bad", role: "alert", hidden: "" });
  const said = make("p", { class: "heard", role: "status" });
  const who = make("p", { class: "dim" });
  const confirmBox = make("div");
  const empty = make("p", { class: "empty" }, "Loading …");
  const tableBox = make("div", { class: "param-list" });
  const changes = may ? [write, forget, save] : [];
  root.append(make("div", { class: "control params-box" }, make("div", { class: "row" }, make("label", {}, "Find ", find), make("label", {}, "Show ", choice), again, ...changes), who, trouble, confirmBox, said, empty, tableBox));
  const confirm = createConfirm(confirmBox);
  const table = createTable(tableBox, (of, text) => {
    const row = rows.find((one) => one.key === of);
    if (!row) return;
    outcomes.delete(of);
    edits = withEdit(edits, of, text ?? row.told.value, row.told.value);
    draw();
  });

  let told: VesselParameters | undefined;
  let edits: Edits = readKept();
  let rows: readonly Row[] = [];
  const outcomes = new Map<string, Outcome>();
  let [busy, begun, inControl, moves] = [false, false, false, true];
  let system: System | undefined;
  let settle: number | undefined;
  /** What was found out about the last reading, for the place where nothing is shown. */
  let silence = "";

  function readKept(): Edits {
    try {
      return new Map(JSON.parse(sessionStorage.getItem(kept) ?? "[]") as [string, string][]);
    } catch {
      return new Map();
    }
  }
  const live = (): boolean => system?.liveness === "live" || system?.liveness === "late";
  const fail = (text: string): void => {
    setText(trouble, text);
    setAttribute(trouble, "hidden", text ? null : "");
  };
  const take = (next: VesselParameters): void => {
    told = next;
    draw();
  };
  const look = async (): Promise<void> => {
    try {
      take(await reader.known());
    } catch (error) {
      fail(reason(error));
    }
  };
  const read = async (): Promise<void> => {
    if (busy) return;
    begin(`Asking ${name()} for its parameters …`);
    try {
      const { told: now, silent, reached } = await reader.read();
      const answered = now.entities.length > 0 && !now.recorded;
      silence = !reached ? `${name()} has no connection at present.` : answered ? "" : `${name()} did not answer. See whether it is heard (Link, above) and ask again; some programs report no parameters at all.`;
      setText(said, silence || (silent.length ? `Read. ${silent.length === 1 ? "1 part" : `${silent.length} parts`} of the vessel reported none.` : "Read."));
      take(now);
    } catch (error) {
      setText(said, "");
      fail(reason(error));
      await look();
    }
    end();
  };
  const begin = (text: string): void => {
    busy = true;
    fail("");
    setText(said, text);
    enable();
  };
  const end = (): void => {
    busy = false;
    draw();
  };

  /** What would be written, in words; a second step where it changes at once how a vessel moves. */
  const ask = (): void => {
    const wrong = rows.find((row) => row.problem);
    if (wrong) {
      fail(`${wrong.told.name} of ${wrong.entity}: ${wrong.problem}`);
      table.focus(wrong.key);
      return;
    }
    const changes = changesOf(rows);
    const wanted = [...changes.values()].flat();
    if (!wanted.length) return;
    fail("");
    const cautions = new Set(wanted.flatMap(({ told: { about } }) => (about ? (about.caution ?? []) : "its meaning is not known here")));
    if (!cautions.size && !moves) return void writeAll(changes);
    const lines = [`Vessel: ${name()}${moves ? ", which may be under way" : ""}`, ...wanted.map((row) => `${row.entity}, ${changeText(row)}`), ...[...cautions].map((why) => `Take care: ${why}.`)];
    confirm.ask(`Write ${wanted.length === 1 ? "1 parameter" : `${wanted.length} parameters`} to ${name()}?`, lines, "Write to vessel", () => void writeAll(changes));
  };
  /** Writes what was asked about, whatever was typed since. */
  const writeAll = async (changes: ReturnType<typeof changesOf>): Promise<void> => {
    if (busy) return;
    begin(`Writing to ${name()} …`);
    const counts = new Map<Outcome["kind"], number>();
    for (const [entity, changed] of changes) {
      for (const row of changed) outcomes.set(row.key, { kind: "pending", text: "" });
      draw();
      for (const [of, outcome] of await writeOne(entity, changed)) {
        outcomes.set(of, outcome);
        counts.set(outcome.kind, (counts.get(outcome.kind) ?? 0) + 1);
        if (outcome.kind !== "confirmed") continue;
        const next = new Map(edits);
        next.delete(of);
        edits = next;
      }
      draw();
    }
    setText(said, `Written: ${[...counts].map(([kind, count]) => `${count} ${kind}`).join(", ")}.`);
    end();
  };
  /** Writes what was changed of one entity and reads it back; what became of each. */
  const writeOne = async (entity: string, changed: readonly Row[]): Promise<Map<string, Outcome>> => {
    const all = (outcome: (row: Row) => Outcome): Map<string, Outcome> => new Map(changed.map((row) => [row.key, outcome(row)]));
    const values = changed.map((row) => ({ name: row.told.name, value: (row.edit ?? "").trim() }));
    let command: Command;
    try {
      command = await orders.settle({ kind: "parameters.set", entity, values });
    } catch (error) {
      return all(() => ({ kind: "refused", text: `Not written: ${reason(error)}` }));
    }
    const last = command.steps.at(-1);
    try {
      const { told: now, silent } = await reader.read([entity]);
      told = now;
      const back = silent.length ? undefined : now.entities.find((one) => one.entity === entity)?.parameters;
      return all((row) => outcomeOf((row.edit ?? "").trim(), back?.find((one) => one.name === row.told.name), last?.stage ?? "", last?.text ?? ""));
    } catch (error) {
      return all(() => ({ kind: "timed out", text: `Not read back: ${reason(error)}` }));
    }
  };

  const unsaved = (): Map<string, Row[]> => {
    const found = new Map<string, Row[]>();
    for (const row of rows) if (row.unsaved !== false && row.told.about?.live !== false) found.set(row.entity, [...(found.get(row.entity) ?? []), row]);
    // Of a vessel that does not tell what is saved only those entities are saved that were written from here.
    for (const [entity, of] of found) if (of.every((row) => row.unsaved === null && outcomes.get(row.key)?.kind !== "confirmed")) found.delete(entity);
    return found;
  };
  const askSave = (): void => {
    const found = unsaved();
    const lines = [...found].flatMap(([entity, of]) => of.filter((row) => row.unsaved || outcomes.has(row.key)).map((row) => `${entity}, ${row.told.name}: ${row.told.saved ?? "?"} → ${row.told.value}`));
    confirm.ask(`Save parameters to ${name()}?`, [`${name()} will have these values at its next start:`, ...lines], "Save", () => void saveAll([...found.keys()]));
  };
  const saveAll = async (entities: readonly string[]): Promise<void> => {
    if (busy) return;
    begin(`Saving to ${name()} …`);
    try {
      for (const entity of entities) {
        const last = (await orders.settle({ kind: "parameters.save", entity })).steps.at(-1);
        if (last?.stage !== "received" && last?.stage !== "effect seen") throw new Error(`${entity}: ${last?.stage ?? "not sent"} ${last?.text ?? ""}`);
      }
      const { told: now } = await reader.read(entities);
      take(now);
      const left = unsaved();
      const tells = rows.some((row) => row.unsaved !== null);
      setText(said, !tells ? "Sent. This vessel does not tell what it saved." : left.size ? "" : "Saved: the vessel tells that its next start has these values.");
      if (tells && left.size) fail(`Not saved: ${[...left.keys()].join(", ")}. The vessel's log book says why.`);
    } catch (error) {
      setText(said, "");
      fail(error instanceof Error && error.constructor === Error ? `Not saved: ${error.message}` : `Not saved: ${reason(error)}`);
    }
    end();
  };

  const enable = (): void => {
    const count = [...edits].filter(([of]) => rows.some((row) => row.key === of)).length;
    setText(write, count ? `Write ${count}` : "Write");
    const why = busy ? "Wait." : !inControl ? "Take control first." : "";
    write.disabled = why !== "" || !count;
    write.title = why || (count ? "" : "Change a value first.");
    save.disabled = why !== "" || !unsaved().size;
    save.title = why || (unsaved().size ? "" : "Nothing differs from what is saved.");
    forget.disabled = busy || !count;
    again.disabled = busy;
  };
  const draw = (): void => {
    sessionStorage.setItem(kept, JSON.stringify([...edits]));
    if (!told) return enable();
    rows = rowsOf(told, edits);
    table.fill(told, rows);
    const shown = new Set(rows.filter((row) => isShown(row, choice.value as Show, find.value.trim())).map((row) => row.key));
    table.update(rows, shown, outcomes, may);
    const nothing = rows.length ? (shown.size ? "" : "Nothing here is like that.") : silence || (live() ? "Nothing was read yet: press “Read from vessel”." : `${name()} is not heard, and nothing is known of its parameters. They can be read when it is back.`);
    setText(empty, nothing);
    setAttribute(empty, "hidden", nothing ? null : "");
    enable();
  };
  find.addEventListener("input", draw);
  choice.addEventListener("change", draw);
  enable();

  return {
    update(control, now, nowUs, underWay, shown) {
      [system, moves] = [now, underWay];
      const part = partOf(control.lease, me, key);
      const before = inControl;
      inControl = part === "here";
      if (before && !inControl) confirm.close();
      if (before !== inControl) enable();
      if (!shown) return;
      if (!begun && now) {
        begun = true;
        void look().then(() => (live() ? read() : draw()));
      }
      const [oldest] = [...(told?.entities ?? [])].map((one) => one.time_us).sort((one, other) => one - other);
      const old = told && oldest !== undefined && !live() ? ` ${name()} is not heard: these are its last known values${told.recorded ? " from the history" : ""}, ${age(Math.max(0, (nowUs - oldest) / 1e6))} old.` : "";
      const control_ = may ? (inControl ? "You have control: changes can be written." : `${whoHas(control.lease, part)} Writing takes control.`) : "Writing takes the role operator.";
      const words = `${control_}${old}`;
      if (who.firstChild?.textContent !== words) who.replaceChildren(words, ...(may && !inControl ? [" ", lead] : []));
      setAttribute(who, "data-old", old ? "" : null);
      if (told) table.ages(told, nowUs);
    },
    heard({ events }) {
      if (!begun || busy || !events.some((one) => one.system === address && one.abbrev === "EntityParameters")) return;
      window.clearTimeout(settle);
      settle = window.setTimeout(() => void (busy || look()), SETTLE_MS);
    },
  };
}
