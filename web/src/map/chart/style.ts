// How features of the chart's tiles are drawn, after S-52. Styles are made once for a palette and kept.

import type { FeatureLike } from "ol/Feature";
import type Geometry from "ol/geom/Geometry";
import Point from "ol/geom/Point";
import RenderFeature from "ol/render/Feature";
import { Fill, Stroke, Style, Text } from "ol/style";
import { type DepthLimits, isIsolated, isOverscale, safetyContour, type Shade, shadeOf, shownScale, soundingText, type Switch } from "../../state/chart";
import { type ChartColours, chartColours } from "./colours";
import { aidIcon, type Danger, dangerIcon, lightIcon, overscalePattern, soundingIcon } from "./symbols";
import { CANVAS_FONT } from "../palette";

/** From here on in names of aids and heights of bridges and cables are told, m/px. */
const AID_NAMES_TO = 6;
/** Buildings, towers and tanks; most stand on land, where the land decides. */
const STRUCTURES = ["LNDMRK", "BUISGL", "SILTNK", "CRANES", "FORSTC"];
const STRUCTURES_TO = 12;

export interface ChartStyles {
  /** Areas and lines. */
  base(feature: FeatureLike, resolution: number): Style | Style[] | undefined;
  /** Symbols and text. */
  points(feature: FeatureLike, resolution: number): Style | Style[] | undefined;
  /** Draws those that matter first, so that they keep their room. */
  order(one: FeatureLike, other: FeatureLike): number;
  limits(limits: DepthLimits): void;
  without(switches: ReadonlySet<Switch>): void;
  /** Where on earth: scales differ with it. */
  latitude(deg: number): void;
  /** Takes the colours of the palette in force. */
  repaint(): void;
  colours(): ChartColours;
  /** The contour drawn thick, m; undefined until one was seen. */
  safety_m(): number | undefined;
}

/** `changed` is called when something that was drawn before is drawn otherwise now. */
export function createStyles(changed: () => void): ChartStyles {
  let colours = chartColours();
  let limits: DepthLimits = { navigable_m: 1, autonomous_m: 5 };
  let left: ReadonlySet<Switch> = new Set();
  let latitude = 0;
  let kept = new Map<string, Style | Style[]>();
  const contours = new Set<number>();
  let safety: number | undefined;

  const once = <T extends Style | Style[]>(key: string, made: () => T): T => {
    const known = kept.get(key) as T | undefined;
    if (known) return known;
    const style = made();
    kept.set(key, style);
    return style;
  };
  const filled = (key: string, color: string, zIndex: number): Style => once(key, () => new Style({ fill: new Fill({ color }), zIndex }));
  const bars = (): Style => once("bars", () => new Style({ fill: new Fill({ color: overscalePattern(colours) ?? "transparent" }), zIndex: 4 }));
  const line = (key: string, color: string, width: number, zIndex: number, lineDash?: number[]): Style =>
    once(key, () => new Style({ stroke: new Stroke({ color, width, ...(lineDash ? { lineDash } : {}) }), zIndex }));

  const shades = (shade: Shade): string =>
    ({ drying: colours.drying, "very-shallow": colours.veryShallow, shallow: colours.shallow, safe: colours.safe, deep: colours.deep, unknown: colours.veryShallow })[shade];
  const over = (feature: FeatureLike, resolution: number): boolean => isOverscale(number(feature.get("scale")), shownScale(resolution, latitude));
  const barred = (style: Style, feature: FeatureLike, resolution: number): Style | Style[] =>
    over(feature, resolution) ? once(`barred ${style.getZIndex()} ${String(style.getFill()?.getColor())}`, () => [style, bars()]) : style;

  const contour = (depth: number | undefined): Style => {
    if (depth !== undefined && !contours.has(depth)) {
      contours.add(depth);
      const next = safetyContour(contours, limits);
      if (next !== safety) {
        safety = next;
        changed();
      }
    }
    if (depth !== undefined && depth === safety) return line("safety", colours.safety, 2.5, 7);
    return line("contour", colours.contour, 1, 5);
  };

  const area = (feature: FeatureLike): Style | Style[] => {
    const cls = String(feature.get("cls"));
    const caution = /^(RESARE|CTNARE|PRCARE|TSE|ISTZNE)/.test(cls);
    return once(`area ${caution}`, () => {
      const edge = new Style({ stroke: new Stroke({ color: caution ? colours.caution : colours.area, width: caution ? 2 : 1.2, lineDash: caution ? [9, 5] : [5, 5] }), zIndex: 8 });
      return caution ? [new Style({ fill: new Fill({ color: `${colours.cautionFaint}2A` }), zIndex: 3 }), edge] : [edge];
    });
  };

  const dangerArea = (feature: FeatureLike): Style => {
    const farm = feature.get("cls") === "MARCUL";
    return once(`danger-area ${farm}`, () => new Style({
      fill: new Fill({ color: farm ? `${colours.cautionFaint}40` : `${colours.veryShallow}99` }),
      stroke: new Stroke({ color: farm ? colours.danger : colours.outline, width: 1.5, lineDash: farm ? [6, 3] : [2, 4] }),
      zIndex: 6,
    }));
  };

  /** Bridges are solid, whatever hangs over the water is dashed. */
  const overhead = (feature: FeatureLike): Style | Style[] => {
    const bridge = feature.get("cls") === "BRIDGE";
    return once(`overhead ${bridge}`, () =>
      bridge
        ? [new Style({ stroke: new Stroke({ color: colours.outline, width: 6 }), fill: new Fill({ color: `${colours.land}99` }), zIndex: 9 }), new Style({ stroke: new Stroke({ color: colours.land, width: 3 }), zIndex: 10 })]
        : [new Style({ stroke: new Stroke({ color: colours.halo, width: 4 }), zIndex: 9 }), new Style({ stroke: new Stroke({ color: colours.caution, width: 1.8, lineDash: [10, 5] }), zIndex: 10 })]);
  };
  const height = (feature: FeatureLike): Style => {
    const clearance = number(feature.get("clearance_m"));
    const text = clearance === undefined ? "height unknown" : `${clearance} m high`;
    return once(`height ${text}`, () => new Style({ geometry: middle, zIndex: 3, text: label(text, { size: 11, weight: "600", dy: -10, over: true }) }));
  };

  /** What symbol a danger has: the magenta one in otherwise safe water only. */
  const dangerOf = (feature: FeatureLike): Danger => {
    const cls = String(feature.get("cls"));
    const [depth, watlev] = [number(feature.get("depth_m")), number(feature.get("watlev"))];
    if (cls === "MARCUL" || cls === "FSHFAC") return "farm";
    if (cls === "LNDARE") return "islet";
    if (isStructure(feature)) return "structure";
    if (!["OBSTRN", "UWTROC", "WRECKS"].includes(cls)) return "pile";
    const showing = watlev === 1 || watlev === 2 || (depth !== undefined && depth < 0 && cls === "WRECKS");
    if (cls === "WRECKS" && showing) return "wreck-showing";
    if (cls === "UWTROC" && (watlev === 4 || watlev === 5 || (depth !== undefined && depth <= 0))) return "rock-awash";
    if (isIsolated(depth, watlev, number(feature.get("around_m")), limits)) return "isolated";
    return cls === "WRECKS" ? "wreck" : cls === "UWTROC" ? "rock" : "obstruction";
  };

  const label = (text: string, options: { size: number; weight?: string; dx?: number; dy?: number; color?: string; align?: CanvasTextAlign; over?: boolean }): Text =>
    new Text({
      text,
      font: `${options.weight ?? "400"} ${options.size}px ${CANVAS_FONT}`,
      offsetX: options.dx ?? 0,
      offsetY: options.dy ?? 0,
      textAlign: options.align ?? "center",
      overflow: options.over ?? false,
      fill: new Fill({ color: options.color ?? colours.text }),
      stroke: new Stroke({ color: colours.halo, width: 2.5 }),
    });

  const sounding = (depth: number): Style => {
    const bold = depth <= limits.autonomous_m;
    const text = soundingText(depth);
    return once(`sounding ${bold} ${text}`, () =>
      new Style({ image: soundingIcon(text, bold ? `700 13px ${CANVAS_FONT}` : `12px ${CANVAS_FONT}`, bold ? colours.soundingShallow : colours.sounding) }));
  };

  const danger = (feature: FeatureLike): Style => {
    const [kind, depth] = [dangerOf(feature), number(feature.get("depth_m"))];
    const text = depth === undefined ? "" : soundingText(depth);
    return once(`danger ${kind} ${text}`, () => new Style({ geometry: middle, image: dangerIcon(kind, colours), zIndex: 3, ...(text ? { text: label(text, { size: 12, weight: "700", dx: 11, dy: -9, color: colours.soundingShallow, align: "left" }) } : {}) }));
  };

  const aid = (feature: FeatureLike, resolution: number): Style => {
    const [cls, shape, colour] = [String(feature.get("cls")), feature.get("shape") as unknown, feature.get("colour") as unknown];
    if (cls === "LIGHTS") return once(`light ${String(colour)}`, () => new Style({ image: lightIcon(colour, colours), zIndex: 1 }));
    const name = resolution < AID_NAMES_TO && !left.has("names") ? String(feature.get("name") ?? "") : "";
    return once(`aid ${cls} ${String(shape)} ${String(colour)} ${name}`, () =>
      new Style({ image: aidIcon(cls, shape, colour, colours), zIndex: 2, ...(name ? { text: label(name, { size: 11, dx: 9, dy: 9, align: "left" }) } : {}) }));
  };

  return {
    base(feature, resolution) {
      switch (feature.get("layer")) {
        case "water": {
          const shade = feature.get("cls") === "UNSARE" ? "unknown" : shadeOf(number(feature.get("drval1")), limits);
          return barred(filled(`water ${shade}`, shades(shade), 1), feature, resolution);
        }
        case "land":
          return barred(once("land", () => new Style({ fill: new Fill({ color: colours.land }), zIndex: 2 })), feature, resolution);
        case "contour":
          return contour(number(feature.get("valdco")));
        case "coast":
          return line("coast", colours.coast, 1.8, 6);
        case "overhead":
          return overhead(feature);
        case "area":
          return left.has("areas") ? undefined : area(feature);
        case "danger":
          if (isStructure(feature)) return isPoint(feature) || isHidden(feature, resolution) ? undefined : once("structure", () => new Style({ fill: new Fill({ color: colours.land }), stroke: new Stroke({ color: colours.outline, width: 1 }), zIndex: 6 }));
          return isPoint(feature) ? undefined : dangerArea(feature);
        default:
          return undefined;
      }
    },
    points(feature, resolution) {
      switch (feature.get("layer")) {
        case "sounding": {
          const depth = number(feature.get("depth_m"));
          return left.has("soundings") || depth === undefined ? undefined : sounding(depth);
        }
        case "overhead":
          return resolution < AID_NAMES_TO ? height(feature) : undefined;
        case "danger":
          if (isHidden(feature, resolution)) return undefined;
          // An area shows its kind by its edge; a symbol in the middle of it belongs to farms only.
          return isPoint(feature) || feature.get("cls") === "MARCUL" ? danger(feature) : undefined;
        case "aid":
          return left.has("aids") ? undefined : aid(feature, resolution);
        case "name": {
          if (left.has("names")) return undefined;
          const text = String(feature.get("text") ?? feature.get("name") ?? "");
          return once(`name ${text}`, () => new Style({ text: label(text, { size: 13, weight: "italic 600", over: true }) }));
        }
        default:
          return undefined;
      }
    },
    order(one, other) {
      return weight(one) - weight(other);
    },
    limits(next) {
      if (next.navigable_m === limits.navigable_m && next.autonomous_m === limits.autonomous_m) return;
      limits = next;
      safety = safetyContour(contours, limits);
      kept = new Map();
      changed();
    },
    without(switches) {
      left = switches;
      changed();
    },
    latitude(deg) {
      latitude = deg;
    },
    repaint() {
      colours = chartColours();
      kept = new Map();
      changed();
    },
    colours: () => colours,
    safety_m: () => safety,
  };
}

/** Less comes first: names of waters, then the shallowest soundings. */
function weight(feature: FeatureLike): number {
  const layer: unknown = feature.get("layer");
  if (layer === "sounding") return number(feature.get("depth_m")) ?? 0;
  return layer === "name" ? -1_000 : 0;
}

/** Where the symbol of a feature is: of an area, within it; of a line, halfway. */
function middle(feature: FeatureLike): Geometry | RenderFeature | undefined {
  const geometry = feature.getGeometry();
  if (!(geometry instanceof RenderFeature) || isPoint(feature)) return geometry;
  if (geometry.getType().endsWith("LineString")) return new Point(geometry.getFlatMidpoint().slice(0, 2));
  return new Point(geometry.getFlatInteriorPoint().slice(0, 2));
}

function isStructure(feature: FeatureLike): boolean {
  return STRUCTURES.includes(String(feature.get("cls")));
}

/** Those in the water are shown at every scale. */
function isHidden(feature: FeatureLike, resolution: number): boolean {
  return isStructure(feature) && resolution > STRUCTURES_TO && number(feature.get("around_m")) === undefined;
}

function isPoint(feature: FeatureLike): boolean {
  return ["Point", "MultiPoint"].includes(feature.getGeometry()?.getType() ?? "");
}

function number(value: unknown): number | undefined {
  return typeof value === "number" && Number.isFinite(value) ? value : undefined;
}
