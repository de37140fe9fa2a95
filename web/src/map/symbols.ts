// How a vessel and its track are drawn: a dark and a light edge, so that they stand out on any chart.

import { Circle, Fill, RegularShape, Stroke, Style, Text } from "ol/style";
import type { System } from "../api/types.gen";
import { tagSeries } from "../state/tags";
import { systemName } from "../ui/format";
import { t } from "../words/words";
import { CANVAS_FONT, type Palette, seriesColour } from "./palette";

/** What stands behind the name of a vessel that is not heard. */
const NOT_HEARD: Readonly<Record<string, string>> = { stale: t("stale"), lost: t("lost") };

/** Layers whose names make room for each other: those of a layer above go first. */
export const NAMES = "names";

/** How a vessel looks: a hull that points where the vessel does, hollow when its position is old. */
export interface VesselStyle {
  readonly styles: Style[];
  /** Points it; where the heading is not known it is a circle. */
  turn(heading_rad: number): void;
}

export function vesselStyle(system: System, palette: Palette, selected: boolean): VesselStyle {
  const colour = seriesColour(palette, system.address);
  const old = system.liveness === "stale" || system.liveness === "lost";
  const fill = new Fill({ color: old ? "rgba(0, 0, 0, 0)" : colour });
  const circle = (system.fix?.heading_rad ?? null) === null;
  const label = new Text({
    text: vesselLabel(system),
    declutterMode: "obstacle",
    font: `600 13px ${CANVAS_FONT}`,
    offsetY: 22,
    fill: new Fill({ color: palette.ink }),
    stroke: new Stroke({ color: palette.halo, width: 4 }),
  });
  const halo = new Stroke({ color: palette.halo, width: 5 });
  const edge = new Stroke({ color: old ? colour : palette.ink, width: old ? 2.5 : 1.5 });
  const hulls = [halo, edge].map((stroke) =>
    circle ? new Circle({ radius: 7, fill, stroke, declutterMode: "obstacle" }) : new RegularShape({ points: 3, radius: 12, scale: [0.72, 1.15], rotateWithView: true, fill, stroke, declutterMode: "obstacle" }),
  );
  const styles = [...hulls.map((image) => new Style({ image })), new Style({ text: label })];
  if (selected) {
    styles.unshift(new Style({ image: new Circle({ radius: 19, stroke: new Stroke({ color: palette.ink, width: 2, lineDash: [5, 4] }), declutterMode: "none" }) }));
  }
  return {
    styles,
    turn(heading_rad) {
      for (const hull of hulls) hull.setRotation(heading_rad);
    },
  };
}

/** Its name, and how it is heard where that is not as it should be. */
export function vesselLabel(system: Pick<System, "address" | "name" | "liveness">): string {
  const told = NOT_HEARD[system.liveness];
  return told ? `${systemName(system)} (${told})` : systemName(system);
}

/** Where the vessel will be in a minute if it goes on like this. */
export function courseStyle(address: number, palette: Palette): Style[] {
  return [
    new Style({ stroke: new Stroke({ color: palette.halo, width: 5 }) }),
    new Style({ stroke: new Stroke({ color: seriesColour(palette, address), width: 2, lineDash: [6, 4] }) }),
  ];
}

/** The style of a track. */
export function trackStyle(address: number, palette: Palette): Style[] {
  return [
    new Style({ stroke: new Stroke({ color: palette.halo, width: 4 }) }),
    new Style({ stroke: new Stroke({ color: seriesColour(palette, address), width: 2 }) }),
  ];
}

/** Where an old vessel can be by now. */
export function ringStyle(address: number, palette: Palette): Style[] {
  return [
    new Style({ stroke: new Stroke({ color: palette.halo, width: 5 }) }),
    new Style({ stroke: new Stroke({ color: seriesColour(palette, address), width: 2, lineDash: [2, 6] }) }),
  ];
}

/** The place that a cursor in a plot or table points to. */
export function cursorStyle(palette: Palette): Style[] {
  const image = (colour: string, width: number): Circle => new Circle({ radius: 8, stroke: new Stroke({ color: colour, width }) });
  return [new Style({ image: image(palette.halo, 6) }), new Style({ image: image(palette.ink, 2.5) })];
}

/** The way that a replay has yet to come. */
export function aheadStyle(address: number, palette: Palette): Style[] {
  return [new Style({ stroke: new Stroke({ color: palette.halo, width: 3 }) }), new Style({ stroke: new Stroke({ color: seriesColour(palette, address), width: 1.25, lineDash: [3, 5] }) })];
}

/** A colour that stays with a tag. */
export function tagColour(palette: Palette, tag: number): string {
  return palette.series[tagSeries(tag)] ?? palette.ink;
}

/** Tags that were heard hereabouts: edged in the tag's colour where it is one tag, else in ink. */
export function tagsStyle(count: number, tag: number | undefined, palette: Palette): Style[] {
  const size = Math.min(18, 8 + Math.log2(count) * 2);
  const text = new Text({ text: count > 1 ? String(count) : "", font: `600 12px ${CANVAS_FONT}`, fill: new Fill({ color: palette.ink }) });
  const image = new RegularShape({
    points: 4,
    radius: size + 3,
    angle: 0,
    fill: new Fill({ color: palette.halo }),
    stroke: new Stroke({ color: tag === undefined ? palette.ink : tagColour(palette, tag), width: tag === undefined ? 2 : 4 }),
  });
  return [new Style({ image, text })];
}
