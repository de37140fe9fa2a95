// Units: what vessels, plans and the wire measure in, and in what people read and type it. All forms and all texts convert
// here, so that what is typed is what is shown.

/** A minute of latitude an hour, in m/s. */
export const KNOT_MPS = 1_852 / 3_600;
/** Degrees in a radian. */
export const DEG = 180 / Math.PI;

/** How a unit of the wire is shown: `value * factor` in `unit`. */
export interface Shown {
  readonly unit: string;
  readonly factor: number;
}

/** As they are shown where a person reads and types single values. What is not listed is shown as it is. */
const SHOWN: Readonly<Record<string, Shown>> = {
  rad: { unit: "°", factor: DEG },
  "rad/s": { unit: "°/s", factor: DEG },
  "m/s": { unit: "kn", factor: 1 / KNOT_MPS },
};

/** Decimals that people type at most. */
const MOST_DECIMALS = 6;
/** Digits of a value that has no short form in the unit that is shown. */
const DIGITS = 4;
/** Two values nearer than this are one: vessels round what they tell to nine decimals. */
const NEAR = 1e-9;
/** Parts of a degree that are kept: a centimetre. */
const PER_DEGREE = 1e7;

/** Unit and factor by which a unit of the wire is shown. */
export function shownAs(unit: string): Shown {
  return (Object.hasOwn(SHOWN, unit) ? SHOWN[unit] : undefined) ?? { unit, factor: 1 };
}

/** Whether two values are one for a vessel: it tells nine decimals, and plans carry numbers of single precision. */
export function isSame(one: number, other: number): boolean {
  return isNear(one, other) || Math.fround(one) === Math.fround(other);
}

function isNear(one: number, other: number): boolean {
  return Math.abs(one - other) <= NEAR * Math.max(1, Math.abs(one));
}

/** A value in the unit of the wire, of what was typed in the one that is shown; without the dust that a product leaves behind. */
export function toWire(typed: number, unit: string): number {
  const { factor } = shownAs(unit);
  return factor === 1 ? typed : Number((typed / factor).toPrecision(12));
}

/**
 * A value as it is typed and shown: what somebody typed comes back as it was typed, whatever became of its last digits on the
 * way; what has no short form in this unit has four digits.
 */
export function toShown(value: number, unit: string): string {
  const { factor } = shownAs(unit);
  if (factor === 1) return String(value);
  const shown = value * factor;
  for (let decimals = 0; decimals <= MOST_DECIMALS; decimals++) {
    const text = String(Number(shown.toFixed(decimals)));
    const back = toWire(Number(text), unit);
    if (isNear(back, value) || (decimals < DIGITS && Math.fround(back) === Math.fround(value))) return text;
  }
  return String(Number(shown.toPrecision(DIGITS)));
}

/** A least or greatest value as it is shown: rounded so that the text itself is allowed. */
export function limitShown(limit: number, unit: string, side: "least" | "most"): string {
  const text = toShown(limit, unit);
  const back = toWire(Number(text), unit);
  if (side === "least" ? back >= limit : back <= limit) return text;
  if (isNear(back, limit)) return text;
  const step = 10 ** (Math.floor(Math.log10(Math.abs(Number(text)))) + 1 - DIGITS);
  return String(Number((Number(text) + (side === "least" ? step : -step)).toPrecision(DIGITS)));
}

/** A number that a person typed; NaN for what is none. */
export function readNumber(text: string): number {
  return Number(text.trim().replace(",", ".").replace("−", "-") || NaN);
}

/** Whole seconds as minutes, in as few digits as tell the second. */
export function minutesShown(seconds: number): string {
  for (let decimals = 0; decimals < MOST_DECIMALS; decimals++) {
    const text = String(Number((seconds / 60).toFixed(decimals)));
    if (Math.round(Number(text) * 60) === seconds) return text;
  }
  return String(seconds / 60);
}

/** Minutes, as `12`, `1.5` or `1:30`, as whole seconds; NaN for what is none. */
export function minutesRead(text: string): number {
  const parts = /^(\d+):([0-5]\d)$/.exec(text.trim());
  return parts ? Number(parts[1]) * 60 + Number(parts[2]) : Math.round(readNumber(text) * 60);
}

/** Reads an angle as people type it: decimal degrees, or degrees, minutes and seconds, with sign or hemisphere. */
export function readAngle(text: string, axis: "lat" | "lon"): number | undefined {
  const [positive, negative, most] = axis === "lat" ? ["N", "S", 90] as const : ["E", "W", 180] as const;
  let rest = text.trim().toUpperCase().replace(/[−–]/g, "-").replace(/(\d),(\d)/g, "$1.$2");
  let sign = 1;
  const letter = /^[NSEW]|[NSEW]$/.exec(rest)?.[0];
  if (letter) {
    if (letter !== positive && letter !== negative) return undefined;
    sign = letter === negative ? -1 : 1;
    rest = (rest.startsWith(letter) ? rest.slice(1) : rest.slice(0, -1)).trim();
    if (rest.startsWith("-")) return undefined;
  }
  if (rest.startsWith("-")) [sign, rest] = [-1, rest.slice(1)];
  const parts = rest.replace(/[°º'′’"″:]/g, " ").trim().split(/\s+/);
  if (parts.length > 3 || !parts.every((part) => /^\d+(\.\d*)?$/.test(part))) return undefined;
  const [degrees = NaN, minutes = 0, seconds = 0] = parts.map(Number);
  const whole = parts.slice(0, -1).every((part) => /^\d+$/.test(part));
  const deg = degrees + minutes / 60 + seconds / 3_600;
  if (!whole || minutes >= 60 || seconds >= 60 || !(deg <= most)) return undefined;
  return sign * Math.round(deg * PER_DEGREE) / PER_DEGREE;
}

/** Writes an angle: decimal degrees, or degrees and minutes to a fifth of a metre. */
export function writeAngle(deg: number, axis: "lat" | "lon", minutes: boolean): string {
  if (!minutes) return deg.toFixed(7);
  const parts = Math.round(Math.abs(deg) * 600_000);
  const whole = String(Math.floor(parts / 600_000)).padStart(axis === "lat" ? 2 : 3, "0");
  const rest = ((parts % 600_000) / 10_000).toFixed(4).padStart(7, "0");
  const hemisphere = axis === "lat" ? (deg < 0 ? "S" : "N") : deg < 0 ? "W" : "E";
  return `${whole}° ${rest}′ ${hemisphere}`;
}
