// A grid of currents from a CSV file, as routes are asked for in it. The server checks the grid; here its lines are read.

import type { SeaRouteCurrentGrid } from "../api/types.gen";
import { t } from "../words/words";

/** Bytes of a file that is read, and crossings that a question takes. */
export const MOST_BYTES = 8 * 2 ** 20;
const MOST_CROSSINGS = 100_000;
const COLUMNS = ["time", "lat", "lon", "east_mps", "north_mps"] as const;

export interface CurrentsOfFile {
  readonly grid?: SeaRouteCurrentGrid;
  /** Why it is no grid; empty where it is one. */
  readonly wrong: string;
}

interface Row {
  readonly at: readonly [number, number, number];
  readonly flow: readonly [number | null, number | null];
}

/** Reads lines of time, latitude, longitude and the current to the east and north. A line that is missing is a current that is not known. */
export function currentsOfCsv(text: string): CurrentsOfFile {
  const [heading = "", ...lines] = text.replace(/^\uFEFF/, "").split(/\r?\n/);
  const names = heading.split(",").map((name) => name.trim().toLowerCase());
  const missing = COLUMNS.find((name) => !names.includes(name));
  if (missing) return { wrong: t("Line 1: there is no column {name}. Begin the file with {columns}.", { name: missing, columns: COLUMNS.join(",") }) };
  const rows: Row[] = [];
  for (const [index, line] of lines.entries()) {
    if (!line.trim()) continue;
    const row = rowOf(line, names);
    if (!row) return { wrong: t("Line {line}: write time, degrees and m/s, such as 2026-11-21T06:00:00Z,63.4,10.3,0.2,-0.1.", { line: index + 2 }) };
    rows.push(row);
  }
  return gridOf(rows);
}

function rowOf(line: string, names: readonly string[]): Row | undefined {
  const cells = line.split(",").map((cell) => cell.trim());
  const [time = "", lat = "", lon = "", east = "", north = ""] = COLUMNS.map((name) => cells[names.indexOf(name)] ?? "");
  // Without an offset it is UTC.
  const ms = Date.parse(/(Z|[+-]\d\d:?\d\d)$/i.test(time) ? time : `${time.replace(" ", "T")}Z`);
  const [lat_deg, lon_deg] = [degrees(lat), degrees(lon)];
  const speeds = [east, north].map((speed) => (speed === "" || /^nan$/i.test(speed) ? null : Number(speed)));
  const good = [ms, lat_deg, lon_deg].every(Number.isFinite) && speeds.every((speed) => speed === null || Number.isFinite(speed));
  return good ? { at: [ms * 1000, lat_deg, lon_deg], flow: [speeds[0] ?? null, speeds[1] ?? null] } : undefined;
}

function degrees(text: string): number {
  return text === "" ? Number.NaN : Number(text);
}

function gridOf(rows: readonly Row[]): CurrentsOfFile {
  const axis = (which: 0 | 1 | 2): number[] => [...new Set(rows.map(({ at }) => at[which]))].sort((one, other) => one - other);
  const [times_us, lats_deg, lons_deg] = [axis(0), axis(1), axis(2)];
  const count = times_us.length * lats_deg.length * lons_deg.length;
  if (lats_deg.length < 2 || lons_deg.length < 2) return { wrong: t("A grid has two latitudes and two longitudes or more.") };
  if (count > MOST_CROSSINGS) return { wrong: t("The file makes {count} crossings of times, latitudes and longitudes; up to {most} are taken. Cut it to the area and the time of the route.", { count, most: MOST_CROSSINGS }) };
  const place = (values: readonly number[]): Map<number, number> => new Map(values.map((value, index) => [value, index]));
  const [steps, lats, lons] = [place(times_us), place(lats_deg), place(lons_deg)];
  const east_mps = new Array<number | null>(count).fill(null);
  const north_mps = new Array<number | null>(count).fill(null);
  for (const { at: [time, lat, lon], flow: [east, north] } of rows) {
    const at = ((steps.get(time) ?? 0) * lats_deg.length + (lats.get(lat) ?? 0)) * lons_deg.length + (lons.get(lon) ?? 0);
    [east_mps[at], north_mps[at]] = [east, north];
  }
  return { grid: { times_us, lats_deg, lons_deg, east_mps, north_mps }, wrong: "" };
}
