// How features of the chart's tiles are drawn, after S-52. Styles are made once for a palette and kept.

import type { FeatureLike } from "ol/Feature";
import type Geometry from "ol/geom/Geometry";
import Point from "ol/geom/Point";
import RenderFeature from "ol/render/Feature";
import { Fill, Stroke, Style, Text } from "ol/style";
import { type DepthLimits, isBarred, isIsolated, safetyContour, type Shade, shadeOf, shownScale, soundingText, type Switch } from "../../state/chart";
import { type ChartColours, chartColours } from "./colours";
import { aidIcon, type Danger, dangerIcon, lightIcon, overscalePattern, soundingIcon } from "./symbols";
import { CANVAS_FONT } from "../palette";
import { t } from "../../words/words";

/** From here on in names of aids and heights of bridges and cables are told, m/px. */
const AID_NAMES_TO = 6;
/** Deeper than any sounding, m. */
const DEEPEST_M = 20_000;
/** Along a contour its depth is told again after so much, px. */
const CONTOUR_DEPTH_EVERY_PX = 420;
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
  /** The scale of the best chart in the picture: what is coarser is barred. */
  finest(scale: number | undefined): void;
  /** Takes the colours of the palette in force. */
  repaint(): void;
  colours(): ChartColours;
  /** The contour drawn thick, m; undefined until one was seen. */
  safety_m(): number | undefined;
}

/** `changed` is called when something that was drawn before is drawn otherwise now. */
export function createStyles(changed: () => void): ChartStyles {
  return new Styles(changed);
}

interface LabelLook {
  readonly size: number;
  readonly weight?: string;
  readonly dx?: number;
  readonly dy?: number;
  readonly color?: string;
  readonly align?: CanvasTextAlign;
  readonly over?: boolean;
}

class Styles implements ChartStyles {
  private now: ChartColours = chartColours();
  private by: DepthLimits = { navigable_m: 1, autonomous_m: 5 };
  private left: ReadonlySet<Switch> = new Set();
  private latitudeDeg = 0;
  private best: number | undefined;
  private kept = new Map<string, Style | Style[]>();
  private readonly contours = new Set<number>();
  private safety: number | undefined;

  constructor(private readonly changed: () => void) {}

  base(feature: FeatureLike, resolution: number): Style | Style[] | undefined {
    const { now } = this;
    switch (feature.get("layer")) {
      case "water": {
        const shade = feature.get("cls") === "UNSARE" ? "unknown" : shadeOf(number(feature.get("drval1")), this.by);
        return this.barred(this.filled(`water ${shade}`, this.shade(shade), 1), feature, resolution);
      }
      case "land":
        return this.barred(this.filled("land", now.land, 2), feature, resolution);
      case "contour":
        return this.contour(number(feature.get("valdco")));
      case "coast":
        return this.line("coast", now.coast, 1.8, 6);
      case "overhead":
        return this.overhead(feature);
      case "area":
        return this.left.has("areas") ? undefined : this.area(feature);
      case "danger":
        return this.dangerArea(feature, resolution);
      default:
        return undefined;
    }
  }

  points(feature: FeatureLike, resolution: number): Style | Style[] | undefined {
    const { left } = this;
    switch (feature.get("layer")) {
      case "sounding": {
        const depth = number(feature.get("depth_m"));
        return left.has("soundings") || depth === undefined ? undefined : this.sounding(depth);
      }
      case "contour": {
        const depth = number(feature.get("valdco"));
        return left.has("contours") || depth === undefined ? undefined : this.contourDepth(depth);
      }
      case "overhead":
        return resolution < AID_NAMES_TO ? this.height(feature) : undefined;
      case "danger":
        if (isHidden(feature, resolution)) return undefined;
        // An area shows its kind by its edge; a symbol in the middle of it belongs to farms only.
        return isPoint(feature) || feature.get("cls") === "MARCUL" ? this.danger(feature) : undefined;
      case "aid":
        return left.has("aids") ? undefined : this.aid(feature, resolution);
      case "name":
        return left.has("names") ? undefined : this.name(String(feature.get("text") ?? feature.get("name") ?? ""));
      default:
        return undefined;
    }
  }

  order(one: FeatureLike, other: FeatureLike): number {
    return weight(one) - weight(other);
  }

  limits(next: DepthLimits): void {
    if (next.navigable_m === this.by.navigable_m && next.autonomous_m === this.by.autonomous_m) return;
    this.by = next;
    this.safety = safetyContour(this.contours, next);
    this.kept = new Map();
    this.changed();
  }

  without(switches: ReadonlySet<Switch>): void {
    this.left = switches;
    this.changed();
  }

  finest(scale: number | undefined): void {
    if (scale === this.best) return;
    this.best = scale;
    this.changed();
  }

  latitude(deg: number): void {
    this.latitudeDeg = deg;
  }

  repaint(): void {
    this.now = chartColours();
    this.kept = new Map();
    this.changed();
  }

  colours(): ChartColours {
    return this.now;
  }

  safety_m(): number | undefined {
    return this.safety;
  }

  /** A style that is made once for a palette. */
  private once<T extends Style | Style[]>(key: string, made: () => T): T {
    const known = this.kept.get(key) as T | undefined;
    if (known) return known;
    const style = made();
    this.kept.set(key, style);
    return style;
  }

  private filled(key: string, color: string, zIndex: number): Style {
    return this.once(key, () => new Style({ fill: new Fill({ color }), zIndex }));
  }

  private line(key: string, color: string, width: number, zIndex: number): Style {
    return this.once(key, () => new Style({ stroke: new Stroke({ color, width }), zIndex }));
  }

  private label(text: string, { weight = "400", size, dx = 0, dy = 0, align = "center", over = false, color = this.now.text }: LabelLook): Text {
    return new Text({
      text,
      font: `${weight} ${size}px ${CANVAS_FONT}`,
      offsetX: dx,
      offsetY: dy,
      textAlign: align,
      overflow: over,
      fill: new Fill({ color }),
      stroke: new Stroke({ color: this.now.halo, width: 2.5 }),
    });
  }

  private shade(shade: Shade): string {
    const { drying, veryShallow, shallow, safe, deep } = this.now;
    return { drying, "very-shallow": veryShallow, shallow, safe, deep, unknown: veryShallow }[shade];
  }

  /** With bars where it is shown larger than it was made for, beside what is not so coarse. */
  private barred(style: Style, feature: FeatureLike, resolution: number): Style | Style[] {
    if (!isBarred(number(feature.get("scale")), this.best, shownScale(resolution, this.latitudeDeg))) return style;
    const bars = this.once("bars", () => new Style({ fill: new Fill({ color: overscalePattern(this.now) ?? "transparent" }), zIndex: 4 }));
    return this.once(`barred ${style.getZIndex()} ${String(style.getFill()?.getColor())}`, () => [style, bars]);
  }

  private contour(depth: number | undefined): Style {
    if (depth !== undefined && !this.contours.has(depth)) {
      this.contours.add(depth);
      const next = safetyContour(this.contours, this.by);
      if (next !== this.safety) {
        this.safety = next;
        this.changed();
      }
    }
    if (depth !== undefined && depth === this.safety) return this.line("safety", this.now.safety, 2.5, 7);
    return this.line("contour", this.now.contour, 1, 5);
  }

  /** Its depth along the line, where the line is long and straight enough. */
  private contourDepth(depth: number): Style {
    const safety = depth === this.safety;
    return this.once(`contour-depth ${depth} ${safety}`, () => new Style({ text: this.alongLine(String(Number(depth.toFixed(1))), safety ? "700" : "400") }));
  }

  private alongLine(text: string, weight: string): Text {
    return new Text({
      text,
      font: `${weight} 11px ${CANVAS_FONT}`,
      placement: "line",
      repeat: CONTOUR_DEPTH_EVERY_PX,
      maxAngle: 0.35,
      fill: new Fill({ color: this.now.sounding }),
      stroke: new Stroke({ color: this.now.halo, width: 3 }),
    });
  }

  private area(feature: FeatureLike): Style | Style[] {
    const { now } = this;
    const caution = /^(RESARE|CTNARE|PRCARE|TSE|ISTZNE)/.test(String(feature.get("cls")));
    return this.once(`area ${caution}`, () => {
      const edge = new Style({ stroke: new Stroke({ color: caution ? now.caution : now.area, width: caution ? 2 : 1.2, lineDash: caution ? [9, 5] : [5, 5] }), zIndex: 8 });
      return caution ? [new Style({ fill: new Fill({ color: `${now.cautionFaint}2A` }), zIndex: 3 }), edge] : [edge];
    });
  }

  private dangerArea(feature: FeatureLike, resolution: number): Style | undefined {
    const { now } = this;
    if (isPoint(feature)) return undefined;
    if (isStructure(feature)) return isHidden(feature, resolution) ? undefined : this.once("structure", () => new Style({ fill: new Fill({ color: now.land }), stroke: new Stroke({ color: now.outline, width: 1 }), zIndex: 6 }));
    const farm = feature.get("cls") === "MARCUL";
    return this.once(`danger-area ${farm}`, () => new Style({
      fill: new Fill({ color: farm ? `${now.cautionFaint}40` : `${now.veryShallow}99` }),
      stroke: new Stroke({ color: farm ? now.danger : now.outline, width: 1.5, lineDash: farm ? [6, 3] : [2, 4] }),
      zIndex: 6,
    }));
  }

  /** Bridges are solid, whatever hangs over the water is dashed. */
  private overhead(feature: FeatureLike): Style | Style[] {
    const { now } = this;
    const bridge = feature.get("cls") === "BRIDGE";
    return this.once(`overhead ${bridge}`, () =>
      bridge
        ? [new Style({ stroke: new Stroke({ color: now.outline, width: 6 }), fill: new Fill({ color: `${now.land}99` }), zIndex: 9 }), new Style({ stroke: new Stroke({ color: now.land, width: 3 }), zIndex: 10 })]
        : [new Style({ stroke: new Stroke({ color: now.halo, width: 4 }), zIndex: 9 }), new Style({ stroke: new Stroke({ color: now.caution, width: 1.8, lineDash: [10, 5] }), zIndex: 10 })]);
  }

  private height(feature: FeatureLike): Style {
    const clearance = number(feature.get("clearance_m"));
    const text = clearance === undefined ? t("height unknown") : t("{height} m high", { height: clearance });
    return this.once(`height ${text}`, () => new Style({ geometry: middle, zIndex: 3, text: this.label(text, { size: 11, weight: "600", dy: -10, over: true }) }));
  }

  private sounding(depth: number): Style {
    const bold = depth <= this.by.autonomous_m;
    const text = soundingText(depth);
    return this.once(`sounding ${bold} ${text}`, () =>
      new Style({ image: soundingIcon(text, bold ? `700 13px ${CANVAS_FONT}` : `12px ${CANVAS_FONT}`, bold ? this.now.soundingShallow : this.now.sounding) }));
  }

  private danger(feature: FeatureLike): Style {
    const [kind, depth] = [dangerOf(feature, this.by), number(feature.get("depth_m"))];
    const text = depth === undefined ? "" : soundingText(depth);
    return this.once(`danger ${kind} ${text}`, () => new Style({ geometry: middle, image: dangerIcon(kind, this.now), zIndex: 3, ...(text ? { text: this.label(text, { size: 12, weight: "700", dx: 11, dy: -9, color: this.now.soundingShallow, align: "left" }) } : {}) }));
  }

  private aid(feature: FeatureLike, resolution: number): Style {
    const [cls, shape, colour] = [String(feature.get("cls")), feature.get("shape") as unknown, feature.get("colour") as unknown];
    if (cls === "LIGHTS") return this.once(`light ${String(colour)}`, () => new Style({ image: lightIcon(colour, this.now), zIndex: 1 }));
    const name = resolution < AID_NAMES_TO && !this.left.has("names") ? String(feature.get("name") ?? "") : "";
    return this.once(`aid ${cls} ${String(shape)} ${String(colour)} ${name}`, () =>
      new Style({ image: aidIcon(cls, shape, colour, this.now), zIndex: 2, ...(name ? { text: this.label(name, { size: 11, dx: 9, dy: 9, align: "left" }) } : {}) }));
  }

  private name(text: string): Style {
    return this.once(`name ${text}`, () => new Style({ text: this.label(text, { size: 13, weight: "italic 600", over: true }) }));
  }
}

/** What symbol a danger has: the magenta one in otherwise safe water only. */
function dangerOf(feature: FeatureLike, limits: DepthLimits): Danger {
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
}

/** Less comes first: names of waters, then the shallowest soundings; depths of contours where there is room left. */
function weight(feature: FeatureLike): number {
  const layer: unknown = feature.get("layer");
  if (layer === "sounding") return number(feature.get("depth_m")) ?? 0;
  if (layer === "contour") return DEEPEST_M;
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
