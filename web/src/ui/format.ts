// The one place where numbers become text. Fixed decimals, so that nothing jumps.

import type { Field, Fix } from "../api/types.gen";
import { named } from "../state/foreign";
import { DEG, KNOT_MPS } from "../state/units";
import { t } from "../words/words";

/** A heading or course: three digits and T for true. */
export function bearing(rad: number | null): string {
  if (rad === null) return "—";
  const deg = Math.round((((rad * DEG) % 360) + 360) % 360) % 360;
  return `${String(deg).padStart(3, "0")}° T`;
}

/** A speed in knots. */
export function knots(mps: number | null): string {
  return mps === null ? "—" : `${(mps / KNOT_MPS).toFixed(1)} kn`;
}

/** A distance in metres and nautical miles. */
export function distance(m: number): string {
  return `${m < 100 ? m.toFixed(1) : m < 10_000 ? m.toFixed(0) : `${(m / 1_000).toFixed(2)} k`}${m < 10_000 ? " " : ""}m (${(m / 1_852).toFixed(m < 18_520 ? 3 : 1)} nmi)`;
}

/** A tag, by its protocol and number. */
export function tagName(one: { protocol: number | null; protocol_name: string | null; tag_id: number }): string {
  return `${one.protocol_name ?? one.protocol ?? "?"}-${one.tag_id}`;
}

/** Its serial number, behind its maker where a file said that: makers give the same numbers. */
export function receiverName(one: { serial_no: number; maker: string | null }): string {
  return one.maker ? `${one.maker} ${one.serial_no}` : String(one.serial_no);
}

/** Degrees and decimal minutes with their hemisphere. */
export function latitude(deg: number): string {
  return minutes(deg, 2, deg < 0 ? "S" : "N");
}

/** Degrees and decimal minutes with their hemisphere. */
export function longitude(deg: number): string {
  return minutes(deg, 3, deg < 0 ? "W" : "E");
}

/** A position, WGS-84. */
export function position(fix: Pick<Fix, "lat_deg" | "lon_deg">): string {
  return `${latitude(fix.lat_deg)} ${longitude(fix.lon_deg)}`;
}

function minutes(deg: number, digits: number, hemisphere: string): string {
  // In thousandths of a minute first, so that 59.9996 does not become 60.000.
  const thousandths = Math.round(Math.abs(deg) * 60_000);
  const whole = Math.floor(thousandths / 60_000);
  const rest = ((thousandths % 60_000) / 1_000).toFixed(3).padStart(6, "0");
  return `${String(whole).padStart(digits, "0")}° ${rest}′ ${hemisphere}`;
}

/** How long ago, in the largest unit that says enough. */
export function age(seconds: number): string {
  if (seconds < 9.95) return `${seconds.toFixed(1)} s`;
  if (seconds < 120) return `${Math.round(seconds)} s`;
  if (seconds < 7_200) return `${Math.floor(seconds / 60)} min`;
  if (seconds < 172_800) return `${Math.floor(seconds / 3_600)} h`;
  return `${Math.floor(seconds / 86_400)} d`;
}

/** A value with the unit that is shown beside it. Angles are shown in degrees. */
export function field(field: Field): { text: string; unit: string } {
  const { value, unit, meaning } = field;
  if (meaning !== null) return { text: meaning, unit: "" };
  if (value === null) return { text: t("no number"), unit };
  if (typeof value === "string") return { text: short(value), unit };
  if (typeof value !== "number") return { text: short(JSON.stringify(value)), unit };
  if (unit === "rad") return { text: number(value * DEG, isPosition(field.name) ? 6 : 1), unit: "°" };
  if (unit === "rad/s") return { text: number(value * DEG, 2), unit: "°/s" };
  return { text: Number.isInteger(value) ? String(value) : number(value, 3), unit };
}

function isPosition(name: string): boolean {
  return /(^|_)(lat|lon)$/.test(name);
}

function number(value: number, decimals: number): string {
  const size = Math.abs(value);
  const text = size !== 0 && (size < 10 ** -decimals || size >= 1e12) ? value.toExponential(2) : value.toFixed(decimals);
  return text.replace("-", "−");
}

function short(text: string): string {
  return text.length > 120 ? `${text.slice(0, 119)}…` : text;
}

/** A time, UTC: `2026-06-01 12:00:00Z`, and with `day` left out where that is clear. */
export function utc(us: number, day = true): string {
  const iso = new Date(us / 1_000).toISOString();
  return `${day ? `${iso.slice(0, 10)} ` : ""}${iso.slice(11, 19)}Z`;
}

/** Whether this is no vessel but the server itself, which tells about its links under an address of its own. */
export function isShore(system: { transports: readonly string[] }): boolean {
  return system.transports.length > 0 && system.transports.every((transport) => transport === "shore");
}

/** An IMC address as people write it. */
export function hexAddress(address: number): string {
  return `0x${address.toString(16).toUpperCase().padStart(4, "0")}`;
}

/** A system's name, or its address where nobody has named it. */
export function systemName(system: { address: number; name: string | null }): string {
  return named(system.name ?? "") || t("unknown {address}", { address: hexAddress(system.address) });
}

/**
 * Systems as people call them: by the name they were given, else by what they announce. A name that several have is told
 * with the address: nobody stops another's vessel by its name.
 */
export function asCalled<S extends { address: number; name: string | null }>(systems: readonly S[], given: Readonly<Record<string, string>>): S[] {
  const called = systems.map((system) => ({ ...system, name: systemName({ ...system, name: given[String(system.address)] ?? system.name }) }));
  const counts = new Map<string, number>();
  for (const { name } of called) counts.set(name, (counts.get(name) ?? 0) + 1);
  return called.map((system) => ((counts.get(system.name) ?? 0) > 1 ? { ...system, name: `${system.name} (${hexAddress(system.address)})` } : system));
}
