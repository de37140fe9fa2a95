// What the Parameters tab knows and shows: what the vessel told, what was typed, what became of it. Reading, writing and
// saving work on it, one of them at a time.

import { reason } from "../api/http";
import type { System, VesselParameters } from "../api/types.gen";
import { setAttribute, setText } from "../ui/dom";
import { type Confirm, createConfirm } from "../control/confirm";
import { type Form, type FormActs, createForm } from "./form";
import { type Edits, isShown, type Outcome, type Row, rowsOf, type Show, withEdit } from "./model";
import type { Reader } from "./reading";
import { createTable, type ParameterTable } from "./table";
import { t } from "../words/words";

export class ParameterView {
  told: VesselParameters | undefined;
  edits: Edits;
  rows: readonly Row[] = [];
  readonly outcomes = new Map<string, Outcome>();
  /** Whether something is read, written or saved. */
  busy = false;
  inControl = false;
  /** Whether the vessel is under way, or nobody knows. */
  moves = true;
  system: System | undefined;
  /** What was found out about the last reading, for the place where nothing is shown. */
  silence = "";
  readonly form: Form;
  readonly confirm: Confirm;
  readonly table: ParameterTable;
  /** Where what was typed outlives a reload of the page. */
  private readonly kept: string;

  constructor(
    root: HTMLElement,
    address: number,
    readonly may: boolean,
    readonly name: () => string,
    private readonly reader: Reader,
    acts: FormActs,
  ) {
    this.kept = `lutra-parameters-shown-${address}`;
    this.edits = keptEdits(this.kept);
    this.form = createForm(root, may, acts);
    this.confirm = createConfirm(this.form.confirmBox);
    this.table = createTable(this.form.tableBox, (key, text) => this.typed(key, text));
    this.form.find.addEventListener("input", () => this.draw());
    this.form.choice.addEventListener("change", () => this.draw());
    this.enable();
  }

  /** Whether the vessel is heard. */
  get live(): boolean {
    return this.system?.liveness === "live" || this.system?.liveness === "late";
  }

  take(next: VesselParameters): void {
    this.told = next;
    this.draw();
  }

  /** Takes what the server knows, without asking the vessel. */
  async look(): Promise<void> {
    try {
      this.take(await this.reader.known());
    } catch (error) {
      this.form.fail(reason(error));
    }
  }

  begin(text: string): void {
    this.busy = true;
    this.form.fail("");
    setText(this.form.said, text);
    this.enable();
  }

  end(): void {
    this.busy = false;
    this.draw();
  }

  forget(): void {
    this.edits = new Map();
    this.outcomes.clear();
    this.draw();
  }

  /** What differs from what is saved, by entity. */
  unsaved(): Map<string, Row[]> {
    const found = new Map<string, Row[]>();
    for (const row of this.rows) if (row.unsaved !== false && row.told.about?.live !== false) found.set(row.entity, [...(found.get(row.entity) ?? []), row]);
    // Of a vessel that does not tell what is saved only those entities are saved that were written from here.
    for (const [entity, of] of found) if (of.every((row) => row.unsaved === null && this.outcomes.get(row.key)?.kind !== "confirmed")) found.delete(entity);
    return found;
  }

  enable(): void {
    const { write, save, forget, again } = this.form;
    const count = [...this.edits].filter(([of]) => this.rows.some((row) => row.key === of)).length;
    setText(write, count ? t("Write {count}", { count }) : t("Write"));
    const why = this.busy ? t("Wait.") : !this.inControl ? t("Take control first.") : "";
    write.disabled = why !== "" || !count;
    write.title = why || (count ? "" : t("Change a value first."));
    save.disabled = why !== "" || !this.unsaved().size;
    save.title = why || (this.unsaved().size ? "" : t("All values are saved."));
    forget.disabled = this.busy || !count;
    again.disabled = this.busy;
  }

  draw(): void {
    const { told, form } = this;
    sessionStorage.setItem(this.kept, JSON.stringify([...this.edits]));
    if (!told) return this.enable();
    this.rows = rowsOf(told, this.edits);
    this.table.fill(told, this.rows);
    const shown = new Set(this.rows.filter((row) => isShown(row, form.choice.value as Show, form.find.value.trim())).map((row) => row.key));
    this.table.update(this.rows, shown, this.outcomes, this.may);
    const nothing = this.nothing(shown.size);
    setText(form.empty, nothing);
    setAttribute(form.empty, "hidden", nothing ? null : "");
    this.enable();
  }

  /** What is said where no row is shown; empty where one is. */
  private nothing(shown: number): string {
    if (this.rows.length) return shown ? "" : t("No matching parameters.");
    return this.silence || (this.live ? t("Nothing was read yet: press “Read from vessel”.") : t("{name} is not heard, and nothing is known of its parameters. They can be read when it is back.", { name: this.name() }));
  }

  private typed(key: string, text: string | null): void {
    const row = this.rows.find((one) => one.key === key);
    if (!row) return;
    this.outcomes.delete(key);
    this.edits = withEdit(this.edits, key, text ?? row.shown.value, row.shown.value);
    this.draw();
  }
}

function keptEdits(kept: string): Edits {
  try {
    return new Map(JSON.parse(sessionStorage.getItem(kept) ?? "[]") as [string, string][]);
  } catch {
    return new Map();
  }
}
