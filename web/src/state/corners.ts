// The corners of an area that is drawn: by clicks, by drags and as text, with a way back. Pure, but for the signals.

import { signal } from "@preact/signals";
import type { PlanPlace } from "../api/types.gen";
import { t } from "../words/words";

/** Corners of one area. */
export const MOST_CORNERS = 200;
/** Steps that can be taken back. */
const MOST_STEPS = 100;

export class Corners {
  readonly now = signal<readonly PlanPlace[]>([]);
  private readonly before = signal<readonly (readonly PlanPlace[])[]>([]);
  private dragged = false;
  /** What is typed and not yet taken; nothing while the text is that of the corners. */
  readonly typed = signal<string | undefined>(undefined);
  /** What is wrong with what is typed. */
  readonly wrong = signal("");

  /** Begins with these; nothing can be taken back. */
  begin(corners: readonly PlanPlace[]): void {
    [this.before.value, this.dragged] = [[], false];
    this.show(corners);
  }

  /** One step; further corners than may be are left out. */
  set(next: readonly PlanPlace[]): void {
    this.before.value = [...this.before.value, this.now.value].slice(-MOST_STEPS);
    this.show(next.slice(0, MOST_CORNERS));
  }

  /** The text is that of the corners again: what stands there is never other than what is sent. */
  private show(corners: readonly PlanPlace[]): void {
    [this.now.value, this.typed.value, this.wrong.value] = [corners, undefined, ""];
  }

  /** Takes what is typed, if something is; false where it is no corners: they stay, and so does the text. */
  take(): boolean {
    const { value: text } = this.typed;
    if (text === undefined) return true;
    const found = cornersOfText(text);
    if ("wrong" in found) {
      this.wrong.value = found.wrong;
      return false;
    }
    if (textOfCorners(found.corners) === textOfCorners(this.now.value)) this.show(this.now.value);
    else this.set(found.corners);
    return true;
  }

  add(corner: PlanPlace): void {
    if (this.now.value.length < MOST_CORNERS) this.set([...this.now.value, corner]);
  }

  /** A corner on one of the sides, of which the last one leads back to the first corner; which it is now. Without room it is none. */
  insert(side: number, corner: PlanPlace): number {
    if (this.now.value.length >= MOST_CORNERS) return -1;
    this.set(this.now.value.toSpliced(side + 1, 0, corner));
    this.dragged = true;
    return side + 1;
  }

  /** A corner is being dragged; from its first move to `done` it is one step. */
  move(index: number, corner: PlanPlace, done: boolean): void {
    if (this.now.value[index]) {
      if (!this.dragged) this.set(this.now.value);
      this.show(this.now.value.with(index, corner));
    }
    this.dragged = !done;
  }

  undo(): void {
    const last = this.before.value.at(-1);
    if (!last) return;
    this.before.value = this.before.value.slice(0, -1);
    this.show(last);
  }

  /** Whether there is something to take back. */
  get changed(): boolean {
    return this.before.value.length > 0;
  }
}

/** A line for each corner, degrees with as many decimals as a metre needs. */
export function textOfCorners(corners: readonly PlanPlace[]): string {
  return corners.map(({ lat_deg, lon_deg }) => `${degrees(lat_deg)}, ${degrees(lon_deg)}`).join("\n");
}

/** Seven decimals are a centimetre. */
function degrees(value: number): string {
  return value.toFixed(7).replace(/0{1,2}$/, "");
}

/** One of degrees, minutes and seconds, with a letter or a sign for the side. */
const ANGLE = String.raw`([-−]?\d+(?:\.\d+)?)\s*°?\s*(?:(\d+(?:\.\d+)?)\s*['′]\s*(?:(\d+(?:\.\d+)?)\s*["″]\s*)?)?`;
const LINE = new RegExp(String.raw`^${ANGLE}([NS])?\s*[,;\s]\s*${ANGLE}([EWØV])?$`, "iu");

/** Corners as somebody wrote or pasted them: a line for each, latitude before longitude; what is wrong, if something is. */
export function cornersOfText(text: string): { readonly corners: readonly PlanPlace[] } | { readonly wrong: string } {
  const corners: PlanPlace[] = [];
  for (const [at, line] of text.split("\n").entries()) {
    if (!line.trim()) continue;
    const found = placeOfLine(line.trim());
    if (!found) return { wrong: t("Line {number} is not a place: write latitude and longitude, as 63.4455, 10.344 or 63°26.73'N 010°20.64'E.", { number: at + 1 }) };
    corners.push(found);
  }
  // What is copied from files often ends where it began.
  const [first, last] = [corners[0], corners.at(-1)];
  if (corners.length > 3 && first && last && first.lat_deg === last.lat_deg && first.lon_deg === last.lon_deg) corners.pop();
  if (corners.length > MOST_CORNERS) return { wrong: t("These are {n} corners, at most {most} are taken.", { n: corners.length, most: MOST_CORNERS }) };
  return { corners };
}

function placeOfLine(line: string): PlanPlace | undefined {
  const [, latDeg, latMin, latSec, north, lonDeg, lonMin, lonSec, east] = LINE.exec(line) ?? [];
  const [lat_deg, lon_deg] = [angle(latDeg, latMin, latSec, /s/i.test(north ?? "")), angle(lonDeg, lonMin, lonSec, /[wv]/i.test(east ?? ""))];
  if (lat_deg === undefined || lon_deg === undefined || Math.abs(lat_deg) > 90 || Math.abs(lon_deg) > 180) return undefined;
  return { lat_deg, lon_deg };
}

function angle(whole: string | undefined, minutes = "0", seconds = "0", other: boolean): number | undefined {
  if (whole === undefined) return undefined;
  const negative = /^[-−]/.test(whole);
  const [deg, min, sec] = [Number(whole.replace(/^[-−]/, "")), Number(minutes), Number(seconds)];
  // A sign and a letter together mean nothing; with minutes degrees are whole.
  if ((negative && other) || min >= 60 || sec >= 60 || (Number(minutes) !== 0 && !Number.isInteger(deg)) || (sec !== 0 && !Number.isInteger(min))) return undefined;
  return (deg + min / 60 + sec / 3600) * (negative || other ? -1 : 1);
}
