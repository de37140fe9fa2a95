// What is wrong or odd about a plan, in the reader's language, by the codes and figures that the server sends. Pure.

import type { PlanTrouble } from "../api/types.gen";
import { t } from "../words/words";

type Figure = (name: string, decimals?: number) => string;

/** What a maneuver's numbers are called, and how people read them: the unit, and how much of it the plan's own one is. */
const QUANTITIES: Readonly<Record<string, readonly [name: string, unit: string, factor: number]>> = {
  radius: [t("radius"), "m", 1],
  width: [t("width"), "m", 1],
  length: [t("length"), "m", 1],
  step: [t("distance between rows"), "m", 1],
  bearing: [t("bearing"), "°", 180 / Math.PI],
  "cross angle": [t("cross angle"), "°", 180 / Math.PI],
  "curve offset": [t("curve offset"), "m", 1],
  alternation: [t("alternation"), "%", 100],
  range: [t("range of the swath"), "m", 1],
  aperture: [t("opening angle of the swath"), "°", 180 / Math.PI],
  overlap: [t("overlap"), "%", 100],
  "offset north": [t("offset to the north"), "m", 1],
  "offset east": [t("offset to the east"), "m", 1],
  "loiter radius": [t("radius of the circle"), "m", 1],
};

/** In words; what has no code of its own is said as the server said it. */
export function troubleText(trouble: PlanTrouble): string {
  const { code, text, about, values } = trouble;
  const figure: Figure = (name, decimals = 0) => (values[name] ?? NaN).toFixed(decimals);
  switch (code) {
    case "no-name":
      return t("The plan has no name");
    case "empty":
      return t("The plan has no maneuvers yet");
    case "too-many-maneuvers":
      return t("{count} maneuvers; {most} are allowed", { count: figure("count"), most: figure("most") });
    case "bad-name":
      return t("A maneuver needs a name other than _done_");
    case "name-twice":
      return t("This name is used twice");
    case "unreachable":
      return t("No transition leads to it");
    case "unsupported":
      return t("The vessel does not sail maneuvers of the kind {kind}", { kind: about ?? "" });
    case "too-deep":
      return t("A depth of {depth} m is asked for; {most} m is possible", { depth: figure("depth_m", 1), most: figure("most_m", 1) });
    case "no-place":
      return t("This is not a place: latitude −90 to 90°, longitude −180 to 180°");
    case "null-island":
      return t("The position is 0, 0: it was not filled in");
    case "outside-area":
      return t("It leaves the area of operation by {distance} m", { distance: figure("by_m") });
    case "speed":
      return t("This speed is not possible. Choose one above 0 and up to {mps} m/s, {rpm} rpm or {percent} %.", { mps: figure("mps", 2), rpm: figure("rpm"), percent: figure("percent") });
    case "range":
      return rangeText(trouble);
    case "too-many-points":
      return t("{count} points; {most} are allowed", { count: figure("count"), most: figure("most") });
    case "too-many-row-points":
      return t("Its rows have more than {most} points together: put more distance between rows, or divide the plan", { most: figure("most") });
    case "too-long":
      return t("The plan is too long for one message: divide it");
    case "circle-instead":
      return t("A circle is sailed in place of the shape");
    case "no-points":
      return t("Has no points and is done at once");
    case "never-reached":
      return t("It is never reached");
    case "transition-ignored":
      return t("The transition to {to} is ignored: the first one counts", { to: about ?? "" });
    case "never-ends":
      return t("The plan never ends by itself");
    default:
      return text;
  }
}

function rangeText({ about, values }: PlanTrouble): string {
  const [what, unit, factor] = QUANTITIES[about ?? ""] ?? [about ?? "", "", 1];
  const { value, least, most } = values;
  if (value === undefined || least === undefined || most === undefined) return t("{what} is not a number", { what });
  const said = (number: number): string => String(Number((number * factor).toPrecision(6)));
  return t("{what} {value} {unit} is not within {least} to {most} {unit}", { what, unit, value: said(value), least: said(least), most: said(most) });
}
