// What can be plotted of a vessel: the fields that were recorded or are heard, with their units and how often they come.

import type { Series, Update } from "../api/types.gen";
import { quantity } from "../state/quantities";
import type { Choice } from "./chooser";
import { parsed, shownUnit, type Source, written } from "./model";

/** Kinds of fields that are no numbers. */
const NO_NUMBERS = ["text", "raw", "nested"];
/** How often a field comes of which nobody knows it, s. */
const USUAL_S = 10;

export class Fields {
  private series = new Map<string, Series>();
  private readonly heard = new Map<string, { unit: string; period_s: number | null }>();

  /** `entity` gives the name of an entity of the vessel. */
  constructor(private readonly entity: (number: number) => string) {}

  /** What was recorded. */
  recorded(series: readonly Series[]): void {
    this.series = new Map(series.map((one) => [`${one.message}.${one.entity}`, one]));
  }

  /** A number that is heard. */
  hear({ abbrev, entity, period_s }: Update, field: string, unit: string): void {
    this.heard.set(written({ message: abbrev, entity, field }), { unit, period_s });
  }

  /** The unit as it is reported; empty where it is not known. */
  unit(source: Source): string {
    return this.of(source)?.fields.find((field) => field.name === source.field)?.unit ?? this.heard.get(written(source))?.unit ?? "";
  }

  /** How often the field comes, µs. */
  periodUs(source: Source): number {
    return (this.heard.get(written(source))?.period_s ?? this.of(source)?.period_s ?? USUAL_S) * 1e6;
  }

  /** All of them, by the alphabet. */
  choices(): Choice[] {
    const found = new Map<string, Choice>();
    const put = (source: Source, unit: string): void => {
      const entity = this.entity(source.entity);
      const label = `${source.message} ${entity} ${source.field}`;
      found.set(written(source), { source, label, quantity: quantity(source.message, source.field), entity, unit: shownUnit(unit).unit });
    };
    for (const [key, { unit }] of this.heard) {
      const source = parsed(key);
      if (source) put(source, unit);
    }
    for (const one of this.series.values()) {
      for (const field of one.fields) {
        if (!NO_NUMBERS.includes(field.kind)) put({ message: one.message, entity: one.entity, field: field.name }, field.unit);
      }
    }
    return [...found.values()].sort((one, other) => one.label.localeCompare(other.label));
  }

  private of({ message, entity }: Source): Series | undefined {
    return this.series.get(`${message}.${entity}`);
  }
}
