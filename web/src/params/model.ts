// Parameters of a vessel as a person changes them: pure functions from what the vessel told and what was typed.

import type { EntityReport, ParameterAbout, ParameterReport, VesselParameters } from "../api/types.gen";
import { stageText } from "../state/orderwords";
import { isSame, limitShown, shownAs, toShown, toWire } from "../state/units";
import { t } from "../words/words";

/** What was typed and is not written yet, by entity and name, in the units that are shown. */
export type Edits = ReadonlyMap<string, string>;

/** What became of a value that was written. */
export interface Outcome {
  readonly kind: "pending" | "confirmed" | "refused" | "timed out";
  readonly text: string;
}

/** The same in words. */
export const OUTCOMES: Readonly<Record<Outcome["kind"], string>> = { confirmed: t("confirmed"), pending: t("pending"), refused: t("refused"), "timed out": t("timed out") };

/** Which rows are shown. */
export type Show = "all" | "edited" | "unsaved" | "changed";

export interface Row {
  readonly key: string;
  readonly entity: string;
  /** In the units of the vessel. */
  readonly told: ParameterReport;
  /** Its value in the units that are shown, and so what is saved and the default. */
  readonly shown: ShownParameter;
  /** What was typed; undefined for nothing. */
  readonly edit: string | undefined;
  /** What is wrong with that; empty for nothing. */
  readonly problem: string;
  /** Null where it cannot be told. */
  readonly unsaved: boolean | null;
  readonly changed: boolean | null;
}

/** A parameter as a person reads and types it. */
export interface ShownParameter {
  readonly value: string;
  readonly saved: string | null;
  readonly default: string;
  readonly unit: string;
  /** What is allowed, without the unit; empty where all is. */
  readonly range: string;
}

export function keyOf(entity: string, name: string): string {
  return `${entity}\n${name}`;
}

/** Whether two texts are the same value: numbers by their value, words without regard to capitals, lists item by item. */
export function same(one: string, other: string): boolean {
  const [ones, others] = [items(one), items(other)];
  return ones.length === others.length && ones.every((item, at) => sameItem(item, others[at] ?? ""));
}

function sameItem(one: string, other: string): boolean {
  const [a, b] = [numberOf(one), numberOf(other)];
  if (a === null || b === null) return one.toLowerCase() === other.toLowerCase();
  return isSame(a, b);
}

function items(text: string): string[] {
  return text.split(",").map((item) => item.trim());
}

/** A number as vessels read it: what JavaScript takes besides (nothing, hexadecimal, Infinity) is none. */
function numberOf(text: string): number | null {
  return /^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$/i.test(text) && Number.isFinite(Number(text)) ? Number(text) : null;
}

/** A value of a vessel in the unit that is shown; a text, and numbers of other units, as they are. */
export function shownText(text: string, about: Pick<ParameterAbout, "unit"> | null): string {
  return converted(text, about, (value, unit) => toShown(value, unit));
}

/** What was typed, as the vessel takes it; what was not changed stays as the vessel told it, to its last digit. */
export function wireText(typed: string, { told }: Pick<Row, "told">): string {
  if (typed.trim() === shownText(told.value, told.about)) return told.value;
  return converted(typed.trim(), told.about, (value, unit) => String(toWire(value, unit)));
}

function converted(text: string, about: Pick<ParameterAbout, "unit"> | null, each: (value: number, unit: string) => string): string {
  if (!about || shownAs(about.unit).factor === 1) return text;
  const values = items(text).map(numberOf);
  return values.every((value) => value !== null) ? values.map((value) => each(value, about.unit)).join(", ") : text;
}

function shownParameter({ value, saved, about }: ParameterReport): ShownParameter {
  return {
    value: shownText(value, about),
    saved: saved === null ? null : shownText(saved, about),
    default: about ? shownText(about.default, about) : "",
    unit: about ? shownAs(about.unit).unit : "",
    range: about ? rangeText(about, "") : "",
  };
}

/** What is wrong with a text as this parameter's value, and what is allowed; empty for nothing. */
export function problemOf(text: string, about: ParameterAbout | null): string {
  if (!text.trim()) return t("A value is missing.");
  if (/[\p{Cc}]/u.test(text)) return t("A value must not contain line breaks or other control characters.");
  if (text.length > 1_000) return t("A value has at most 1000 characters.");
  if (!about || about.items === null) return "";
  const given = items(text);
  if (given.length !== about.items) {
    return about.items === 1 ? t("One number is needed, with a point before its decimals.") : t("{n} numbers are needed, with commas between; these are {given}.", { n: about.items, given: given.length });
  }
  for (const item of given) {
    const value = numberOf(item);
    if (value === null) return t("“{item}” is not a number.", { item });
    const wire = toWire(value, about.unit);
    const [tooLittle, tooMuch] = [about.min !== null && wire < about.min && !isSame(wire, about.min), about.max !== null && wire > about.max && !isSame(wire, about.max)];
    if (tooLittle || tooMuch) return t("{item} is not within {range}.", { item, range: rangeOf(about) });
  }
  return "";
}

/** What is allowed, in words and in the unit that is shown; empty where all is. */
export function rangeOf(about: Pick<ParameterAbout, "min" | "max" | "unit">): string {
  const { unit } = shownAs(about.unit);
  return rangeText(about, unit ? ` ${unit}` : "");
}

function rangeText({ min, max, unit }: Pick<ParameterAbout, "min" | "max" | "unit">, of: string): string {
  const [least, most] = [min === null ? "" : limitShown(min, unit, "least"), max === null ? "" : limitShown(max, unit, "most")];
  if (min === null) return max === null ? "" : t("up to {most}", { most: `${most}${of}` });
  return max === null ? t("{least} and more", { least: `${least}${of}` }) : t("{least} to {most}", { least, most: `${most}${of}` });
}

/** All parameters with what was typed. */
export function rowsOf(told: VesselParameters, edits: Edits): Row[] {
  return told.entities.flatMap(({ entity, parameters }: EntityReport) =>
    parameters.map((one) => {
      const key = keyOf(entity, one.name);
      const edit = edits.get(key);
      return {
        key,
        entity,
        told: one,
        shown: shownParameter(one),
        edit,
        problem: edit === undefined ? "" : problemOf(edit, one.about),
        unsaved: one.saved === null ? null : !same(one.saved, one.value),
        changed: one.about === null ? null : !same(one.about.default, one.value),
      };
    }),
  );
}

/** Whether a row is among those that are looked for. */
export function isShown(row: Row, show: Show, words: string): boolean {
  if (show === "edited" && row.edit === undefined) return false;
  if (show === "unsaved" && !row.unsaved) return false;
  if (show === "changed" && !row.changed) return false;
  const text = `${row.entity} ${row.told.name} ${row.told.about?.doc ?? ""}`.toLowerCase();
  return words.toLowerCase().split(/\s+/).every((word) => text.includes(word));
}

/** With another text in one parameter; what the vessel has already is no edit. */
export function withEdit(edits: Edits, key: string, text: string, value: string): Edits {
  const next = new Map(edits);
  if (text === value) next.delete(key);
  else next.set(key, text);
  return next;
}

/** What will be written, by entity, with what it is before. Nothing of what has a problem, or is gone from the vessel. */
export function changesOf(rows: readonly Row[]): Map<string, Row[]> {
  const all = new Map<string, Row[]>();
  for (const row of rows) if (row.edit !== undefined && !row.problem) all.set(row.entity, [...(all.get(row.entity) ?? []), row]);
  return all;
}

/** A change in words. */
export function changeText({ told, shown, edit }: Row): string {
  const unit = shown.unit ? ` ${shown.unit}` : "";
  return `${told.name}: ${shown.value} → ${edit?.trim() ?? shown.value}${unit}`;
}

/** What became of one written value, in the vessel's units, by the order's end and by what the vessel tells afterwards. */
export function outcomeOf(wanted: string, readBack: ParameterReport | undefined, stage: string, words: string): Outcome {
  const reports = readBack ? t("The vessel reports {value}.", { value: shownText(readBack.value, readBack.about) }) : "";
  if (readBack && same(readBack.value, wanted)) return { kind: "confirmed", text: reports };
  const now = readBack ? ` ${reports}` : ` ${t("The vessel did not report its value afterwards.")}`;
  if (stage === "refused") return { kind: "refused", text: `${words}${now}` };
  if (stage === "effect seen") return { kind: readBack ? "refused" : "timed out", text: `${t("It was accepted, but the value did not change.")}${now}` };
  return { kind: "timed out", text: `${words || stageText(stage)}.${now}` };
}
