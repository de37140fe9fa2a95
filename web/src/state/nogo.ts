// No-go areas: what somebody types and draws, as the server takes it. Pure.

import type { NoGoArea, NoGoAreaRequest, PlanPlace } from "../api/types.gen";
import { t } from "../words/words";
import { crosses } from "./avoided";
import { MOST_CORNERS } from "./corners";
import type { Wrong } from "./notes";

/** An area as it stands in its form and on the map. */
export interface AreaDraft {
  readonly name: string;
  readonly reason: string;
}

export const EMPTY_AREA: AreaDraft = { name: "", reason: "" };

export function areaWrong({ name }: AreaDraft, corners: readonly PlanPlace[]): Wrong | undefined {
  if (corners.length < 3) return { field: "corners", text: t("An area has three corners or more: click them on the map.") };
  if (crosses(corners)) return { field: "corners", text: t("Two sides of the area cross: remove corners and draw it without.") };
  if (!name.trim()) return { field: "name", text: t("Give it a name.") };
  return undefined;
}

/** A draft without anything wrong, as the server takes it. */
export function areaAsk({ name, reason }: AreaDraft, corners: readonly PlanPlace[]): NoGoAreaRequest {
  return { name: name.trim(), reason: reason.trim(), corners: corners.map(({ lat_deg, lon_deg }) => [lat_deg, lon_deg]) };
}

export function cornersOf({ area }: Pick<NoGoArea, "area">): PlanPlace[] {
  return area.corners.map(([lat_deg, lon_deg]) => ({ lat_deg, lon_deg }));
}

/** Letters of a name. */
const MOST_LETTERS = 80;
/** What files call an area by. */
const NAMES = ["name", "navn", "OBJNAM", "title", "id"] as const;

export interface AreasOfFile {
  readonly areas: readonly NoGoAreaRequest[];
  /** Why it cannot be brought in; empty where it can. */
  readonly wrong: string;
}

/** The polygons of a GeoJSON file, each as an area; `called` names those that have no name of their own. */
export function areasOfGeoJson(text: string, called: string): AreasOfFile {
  try {
    const areas = polygons(JSON.parse(text) as Geo, called).map(areaOf);
    return { areas, wrong: areas.length ? "" : t("There are no polygons in the file.") };
  } catch (error) {
    return { areas: [], wrong: error instanceof NoArea ? error.message : t("The file is not valid GeoJSON.") };
  }
}

/** Why a polygon is no area, in words. */
class NoArea extends Error {}

function areaOf({ name: long, rings }: Named, at: number): NoGoAreaRequest {
  const name = [...long.replace(/\s+/g, " ").trim()].slice(0, MOST_LETTERS).join("");
  const no = (what: string): NoArea => new NoArea(t("Polygon {number}: {what}", { number: at + 1, what }));
  const [outer, ...holes] = rings;
  if (holes.length) throw no(t("it has holes, which cannot be closed: divide it"));
  if (!outer?.every(isPosition)) throw no(t("a corner does not have longitude and latitude in degrees"));
  const [first, last] = [outer[0], outer.at(-1)];
  if (!first || !last || first[0] !== last[0] || first[1] !== last[1]) throw no(t("its last corner is not its first"));
  const corners = outer.slice(0, -1).map(([lon_deg, lat_deg]) => ({ lat_deg, lon_deg }));
  if (corners.length > MOST_CORNERS) throw no(t("it has {n} corners, at most {most}: simplify it", { n: corners.length, most: MOST_CORNERS }));
  const trouble = areaWrong({ name, reason: "" }, corners);
  if (trouble) throw no(trouble.text);
  return areaAsk({ name, reason: "" }, corners);
}

interface Named {
  readonly name: string;
  readonly rings: readonly (readonly unknown[])[];
}

/** As much of GeoJSON (RFC 7946) as areas need; nothing of it is believed. */
interface Geo {
  readonly type?: unknown;
  readonly features?: readonly Geo[];
  readonly geometries?: readonly Geo[];
  readonly geometry?: Geo | null;
  readonly properties?: Readonly<Record<string, unknown>> | null;
  readonly coordinates?: readonly (readonly (readonly unknown[])[])[];
}

function polygons(geo: Geo, name: string): Named[] {
  const all = (list: readonly Geo[] = []): Named[] => list.flatMap((one, at) => polygons(one, list.length > 1 ? `${name} ${at + 1}` : name));
  switch (geo.type) {
    case "FeatureCollection":
      return all(geo.features);
    case "GeometryCollection":
      return all(geo.geometries);
    case "Feature": {
      const own = NAMES.map((key) => geo.properties?.[key]).find((value) => (typeof value === "string" && value.trim()) || typeof value === "number");
      return geo.geometry ? polygons(geo.geometry, own === undefined ? name : String(own).slice(0, MOST_LETTERS - 6)) : [];
    }
    case "Polygon":
      return [{ name, rings: (geo.coordinates ?? []) as Named["rings"] }];
    case "MultiPolygon":
      return (geo.coordinates ?? []).map((rings, at, list) => ({ name: list.length > 1 ? `${name} ${at + 1}` : name, rings: rings as Named["rings"] }));
    default:
      return [];
  }
}

function isPosition(value: unknown): value is readonly [number, number] {
  const [lon, lat] = Array.isArray(value) ? (value as unknown[]) : [];
  return typeof lon === "number" && typeof lat === "number" && Math.abs(lon) <= 180 && Math.abs(lat) <= 90;
}
