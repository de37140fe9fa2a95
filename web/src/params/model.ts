// Parameters of a vessel as a person changes them: pure functions from what the vessel told and what was typed.

import type { EntityTold, ParameterAbout, ParameterTold, VesselParameters } from "../api/types.gen";

/** How near two numbers are that are one: vessels round what they tell to nine decimals. */
const NEAR = 1e-9;

/** What was typed and is not written yet, by entity and name. */
export type Edits = ReadonlyMap<string, string>;

/** What became of a value that was written. */
export interface Outcome {
  readonly kind: "pending" | "confirmed" | "refused" | "timed out";
  readonly text: string;
}

/** Which rows are shown. */
export type Show = "all" | "edited" | "unsaved" | "changed";

export interface Row {
  readonly key: string;
  readonly entity: string;
  readonly told: ParameterTold;
  /** What was typed; undefined for nothing. */
  readonly edit: string | undefined;
  /** What is wrong with that; empty for nothing. */
  readonly problem: string;
  /** Null where it cannot be told. */
  readonly unsaved: boolean | null;
  readonly changed: boolean | null;
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
  return Math.abs(a - b) <= NEAR * Math.max(1, Math.abs(a));
}

function items(text: string): string[] {
  return text.split(",").map((item) => item.trim());
}

/** A number as vessels read it: what JavaScript takes besides (nothing, hexadecimal, Infinity) is none. */
function numberOf(text: string): number | null {
  return /^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$/i.test(text) && Number.isFinite(Number(text)) ? Number(text) : null;
}

/** What is wrong with a text as this parameter's value, and what is allowed; empty for nothing. */
export function problemOf(text: string, about: ParameterAbout | null): string {
  if (!text.trim()) return "A value is missing.";
  if (/[\p{Cc}]/u.test(text)) return "Line ends and other control characters are no part of a value.";
  if (text.length > 1_000) return "A value has 1000 letters at most.";
  if (!about || about.items === null) return "";
  const given = items(text);
  if (given.length !== about.items) {
    return about.items === 1 ? "One number is needed, with a point before its decimals." : `${about.items} numbers are needed, with commas between; these are ${given.length}.`;
  }
  for (const item of given) {
    const value = numberOf(item);
    if (value === null) return `“${item}” is no number.`;
    if ((about.min !== null && value < about.min) || (about.max !== null && value > about.max)) return `${item} is not within ${rangeOf(about)}.`;
  }
  return "";
}

/** What is allowed, in words; empty where all is. */
export function rangeOf({ min, max, unit }: Pick<ParameterAbout, "min" | "max" | "unit">): string {
  const of = unit ? ` ${unit}` : "";
  if (min === null && max === null) return "";
  if (min === null) return `up to ${max}${of}`;
  return max === null ? `${min}${of} and more` : `${min} to ${max}${of}`;
}

/** All parameters with what was typed. */
export function rowsOf(told: VesselParameters, edits: Edits): Row[] {
  return told.entities.flatMap(({ entity, parameters }: EntityTold) =>
    parameters.map((one) => {
      const key = keyOf(entity, one.name);
      const edit = edits.get(key);
      return {
        key,
        entity,
        told: one,
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
export function changeText({ told, edit }: Row): string {
  const unit = told.about?.unit ? ` ${told.about.unit}` : "";
  return `${told.name}: ${told.value} → ${edit ?? told.value}${unit}`;
}

/** What became of one written value, by the order's end and by what the vessel tells afterwards. */
export function outcomeOf(wanted: string, readBack: ParameterTold | undefined, stage: string, words: string): Outcome {
  if (readBack && same(readBack.value, wanted)) return { kind: "confirmed", text: `The vessel reports ${readBack.value}.` };
  const now = readBack ? ` The vessel reports ${readBack.value}.` : " The vessel did not report its value afterwards.";
  if (stage === "refused") return { kind: "refused", text: `${words}${now}` };
  if (stage === "effect seen") return { kind: readBack ? "refused" : "timed out", text: `It was accepted, but the value did not change.${now}` };
  return { kind: "timed out", text: `${words || stage}.${now}` };
}
