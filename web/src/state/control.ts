// Who commands a vessel and what became of orders, as the browser knows it: pure functions from frames to state.

import type { Command, Lease, LiveFrame } from "../api/types.gen";
import { t } from "../words/words";

/** What happened to control last, by the server's words. */
const CHANGES: Readonly<Record<string, string>> = {
  granted: t("granted"),
  requested: t("requested"),
  "handed over": t("handed over"),
  "granted without an answer": t("granted without an answer"),
  declined: t("declined"),
  withdrawn: t("withdrawn"),
  released: t("released"),
  expired: t("expired"),
  "taken over": t("taken over"),
};

/** Commands that are shown. */
const SHOWN = 30;

export interface ControlState {
  readonly lease: Lease | undefined;
  /** The newest first. */
  readonly commands: readonly Command[];
}

export const NO_CONTROL: ControlState = { lease: undefined, commands: [] };

/** The state of one vessel after a frame. */
export function withControl(state: ControlState, frame: LiveFrame, vessel: number): ControlState {
  const before = frame.snapshot ? NO_CONTROL : state;
  const lease = frame.leases.find((one) => one.vessel === vessel) ?? before.lease;
  const further = frame.commands.filter((one) => one.vessel === vessel);
  if (!further.length) return lease === before.lease ? before : { ...before, lease };
  const byId = new Map([...before.commands, ...further].map((one) => [one.id, one]));
  const commands = [...byId.values()].sort((one, other) => other.id - one.id).slice(0, SHOWN);
  return { lease, commands };
}

/** The same of all vessels of which anything was told. */
export function withControls(known: ReadonlyMap<number, ControlState>, frame: LiveFrame): ReadonlyMap<number, ControlState> {
  const told = new Set([...frame.leases, ...frame.commands].map(({ vessel }) => vessel));
  if (!frame.snapshot && !told.size) return known;
  const next = new Map(frame.snapshot ? [] : known);
  for (const vessel of told) next.set(vessel, withControl(next.get(vessel) ?? NO_CONTROL, { ...frame, snapshot: false }, vessel));
  return next;
}

/** What somebody is to a vessel's control: they have it here, in another window, wait for it, or none of these. */
export type Part = "here" | "elsewhere" | "waiting" | "other" | "free";

export function partOf(lease: Lease | undefined, name: string, key: string): Part {
  const { holder, waiting } = lease ?? {};
  if (!holder) return "free";
  if (holder.name === name) return holder.window === key ? "here" : "elsewhere";
  return waiting?.name === name ? "waiting" : "other";
}

/** Who has control, in words that change only when that does. */
export function whoHas(lease: Lease | undefined, part: Part): string {
  const { holder, last } = lease ?? {};
  if (part === "here") return t("You have control of this vessel.");
  if (part === "elsewhere") return t("You have control in another window.");
  const ended = last && !holder && last.change !== "granted" ? ` ${t("Last: {change} ({who}).", { change: CHANGES[last.change] ?? last.change, who: last.who })}` : "";
  if (!holder) return `${t("Nobody has control of this vessel.")}${ended}`;
  const told = last?.change === "taken over" && last.from ? ` ${t("Taken over from {from}: {reason}.", { from: last.from, reason: last.reason })}` : "";
  return `${t("{name} has control.", { name: holder.name })}${told}`;
}

/** Control that ends within this is told, s: it lasts a minute and is renewed each ten seconds. */
const SOON_S = 30;

/** In how many seconds control ends; undefined while that is not soon. */
export function endsSoon_s(lease: Lease | undefined, nowUs: number): number | undefined {
  if (!lease?.holder) return undefined;
  const left = Math.max(0, Math.round((lease.holder.until_us - nowUs) / 1e6));
  return left <= SOON_S ? left : undefined;
}

/** Who has control, in a few words. */
export function controlLine(lease: Lease | undefined, part: Part, linked: boolean): string {
  if (!linked) return t("In control: not known");
  if (part === "here") return t("In control: you");
  if (part === "elsewhere") return t("In control: you, in another window");
  return t("In control: {name}", { name: lease?.holder?.name ?? t("nobody") });
}

/** Distance (m) and bearing (rad) on a sphere, for what a person reads before they confirm. */
export function legTo(from: { lat_deg: number; lon_deg: number }, to: readonly [number, number]): { distance_m: number; bearing_rad: number } {
  const rad = Math.PI / 180;
  const [lat1, lat2, east] = [from.lat_deg * rad, to[0] * rad, (to[1] - from.lon_deg) * rad];
  const y = Math.sin(east) * Math.cos(lat2);
  const x = Math.cos(lat1) * Math.sin(lat2) - Math.sin(lat1) * Math.cos(lat2) * Math.cos(east);
  const half = Math.sin((lat2 - lat1) / 2) ** 2 + Math.cos(lat1) * Math.cos(lat2) * Math.sin(east / 2) ** 2;
  return { distance_m: 2 * 6_371_000 * Math.asin(Math.min(1, Math.sqrt(half))), bearing_rad: Math.atan2(y, x) };
}
