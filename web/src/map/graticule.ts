// Meridians and parallels with their figures: drawn when the view has changed, not whenever something moves above them.

import Layer from "ol/layer/Layer";
import type { FrameState } from "ol/Map";
import type Source from "ol/source/Source";
import { fromLonLat, transformExtent } from "ol/proj";
import { apply } from "ol/transform";
import { make } from "../ui/dom";
import { latitude, longitude } from "../ui/format";
import { CHART } from "./layers";
import { CANVAS_FONT, type Palette } from "./palette";
import { graticuleStep_deg } from "./scale";

/** From one meridian to the next at least, px: their figures stand side by side. */
const APART_PX = 116;
/** Where the projection ends, degrees. */
const FARTHEST_DEG = 85;
/** The tools at the right edge cover so much: latitudes stand beside them. */
const BESIDE_TOOLS_PX = 58;
/** The words at the lower edge take two lines at most: longitudes stand above them (`.chart-credit`), and the scales above those. */
const ABOVE_WORDS_PX = 40;
/** As high as a figure with its halo. */
const FIGURE_PX = 18;

type Pixel = readonly [x: number, y: number];

export class Graticule extends Layer<Source> {
  private readonly canvas = make("canvas", { class: "ol-layer" });
  private drawn = "";

  constructor(private readonly palette: () => Palette) {
    super({ zIndex: CHART.graticule });
    Object.assign(this.canvas.style, { position: "absolute", transformOrigin: "top left" });
    // Figures that were drawn before the font came are drawn again in it.
    void document.fonts.ready.then(() => this.changed());
  }

  override render(frame: FrameState | null): HTMLElement {
    const { center, resolution, rotation } = frame?.viewState ?? {};
    const view = [center, resolution, rotation, frame?.size, frame?.pixelRatio, this.getRevision()].join();
    if (frame && view !== this.drawn) this.draw(frame);
    this.drawn = view;
    return this.canvas;
  }

  private draw({ coordinateToPixelTransform, extent, pixelRatio, size: [wide = 0, high = 0], viewState }: FrameState): void {
    const { canvas } = this;
    [canvas.width, canvas.height] = [Math.round(wide * pixelRatio), Math.round(high * pixelRatio)];
    canvas.style.transform = `scale(${1 / pixelRatio})`;
    const pen = canvas.getContext("2d");
    const [west = 0, south = 0, east = 0, north = 0] = transformExtent(extent ?? [0, 0, 0, 0], "EPSG:3857", "EPSG:4326");
    const [least, most] = [Math.max(south, -FARTHEST_DEG), Math.min(north, FARTHEST_DEG)];
    const step = graticuleStep_deg(viewState.resolution, APART_PX);
    if (!pen || step === undefined) return;
    const at = (lon: number, lat: number): Pixel => apply(coordinateToPixelTransform, fromLonLat([lon, lat])) as [number, number];
    const lines = [
      ...multiples(Math.max(west, -180), Math.min(east, 180), step).map((lon) => ({ from: at(lon, least), to: at(lon, most), figure: longitude(lon) })),
      ...multiples(least, most, step).map((lat) => ({ from: at(west, lat), to: at(east, lat), figure: latitude(lat) })),
    ];
    pen.scale(pixelRatio, pixelRatio);
    this.drawLines(pen, lines);
    for (const { from, to, figure } of lines) this.write(pen, from, to, figure, [wide, high]);
  }

  private drawLines(pen: CanvasRenderingContext2D, lines: readonly { readonly from: Pixel; readonly to: Pixel }[]): void {
    pen.strokeStyle = this.palette().grid;
    pen.beginPath();
    for (const { from, to } of lines) {
      pen.moveTo(...from);
      pen.lineTo(...to);
    }
    pen.stroke();
  }

  /** A line that is steep on the screen has its figure at the lower edge, another at the right one; the corner is left to the first. */
  private write(pen: CanvasRenderingContext2D, [fromX, fromY]: Pixel, [toX, toY]: Pixel, figure: string, [wide, high]: Pixel): void {
    const steep = Math.abs(toX - fromX) <= Math.abs(toY - fromY);
    const [edgeX, edgeY] = [wide - BESIDE_TOOLS_PX, high - ABOVE_WORDS_PX];
    const x = steep ? fromX + ((edgeY - fromY) / (toY - fromY)) * (toX - fromX) : edgeX;
    const y = steep ? edgeY : fromY + ((edgeX - fromX) / (toX - fromX)) * (toY - fromY);
    if (!steep && !(y > FIGURE_PX / 2 && y < edgeY - FIGURE_PX)) return;
    const { ink, halo } = this.palette();
    Object.assign(pen, { font: `12px ${CANVAS_FONT}`, textAlign: steep ? "center" : "right", textBaseline: steep ? "bottom" : "middle", lineJoin: "round", lineWidth: 3, strokeStyle: halo, fillStyle: ink });
    // A figure that the edge cuts off says another place.
    const half = steep ? pen.measureText(figure).width / 2 : 0;
    if (x < half || x > wide - half) return;
    pen.strokeText(figure, x, y);
    pen.fillText(figure, x, y);
  }
}

/** The multiples of `step` from `least` to `most`. */
function multiples(least: number, most: number, step: number): number[] {
  const first = Math.ceil(least / step);
  return Array.from({ length: Math.max(0, Math.floor(most / step) - first + 1) }, (_, at) => (first + at) * step);
}
