// Speeds of a plan as a person reads and types them: in knots or in metres per second, as they choose, where a plan has m/s.

import type { PlanSpeed, SpeedUnit } from "../api/types.gen";
import { toShown, toWire } from "../state/units";
import { make } from "../ui/dom";
import { t } from "../words/words";
import { choiceField, numberField } from "./fields";

/** What this browser's person chose. */
const KEY = "lutra.speeds";
const LEAST = 0.01;
const MOST = 1_000;

type Choice = SpeedUnit | "kn";

const UNITS: readonly (readonly [Choice, string])[] = [
  ["kn", "kn"],
  ["mps", "m/s"],
  ["rpm", "rpm"],
  ["percent", "%"],
];

export interface SpeedField {
  readonly label: string;
  readonly unitLabel: string;
  /** They find the fields again after the form was built again. */
  readonly key: string;
  readonly unitKey: string;
  readonly speed: PlanSpeed;
  told(speed: PlanSpeed): void;
}

export class SpeedView {
  private inKnots = localStorage.getItem(KEY) !== "mps";

  /** `redraw` is called when another unit is to be shown. */
  constructor(private readonly redraw: () => void) {}

  /** `3 kn`. */
  text(speed: PlanSpeed): string {
    const choice = this.choiceOf(speed);
    return `${this.shown(speed)} ${UNITS.find(([unit]) => unit === choice)?.[1] ?? ""}`;
  }

  /** The number, and beside it its unit. */
  fields({ label, unitLabel, key, unitKey, speed, told }: SpeedField): HTMLElement[] {
    const { unit } = speed;
    const value = numberField(label, key, Number(this.shown(speed)), LEAST, MOST, (typed) => told({ unit, value: this.choiceOf(speed) === "kn" ? toWire(typed, "m/s") : typed }));
    const choice = choiceField(unitLabel, unitKey, this.choiceOf(speed), UNITS, (next) => this.choose(next as Choice, speed, told));
    if (this.choiceOf(speed) === "kn") value.append(sameInWire(speed.value));
    return [value, choice];
  }

  private choose(next: Choice, speed: PlanSpeed, told: (speed: PlanSpeed) => void): void {
    const unit = next === "kn" ? "mps" : next;
    if (unit === "mps") {
      this.inKnots = next === "kn";
      localStorage.setItem(KEY, next);
    }
    if (unit !== speed.unit) told({ value: speed.value, unit });
    else this.redraw();
  }

  private choiceOf({ unit }: PlanSpeed): Choice {
    return unit === "mps" && this.inKnots ? "kn" : unit;
  }

  private shown(speed: PlanSpeed): string {
    return this.choiceOf(speed) === "kn" ? toShown(speed.value, "m/s") : String(speed.value);
  }
}

/** The same speed as the plan has it, for whoever compares it with a file or a vessel's own words. */
function sameInWire(mps: number): HTMLElement {
  return make("span", { class: "dim num same" }, t("= {value} m/s", { value: String(Number(mps.toPrecision(4))) }));
}
