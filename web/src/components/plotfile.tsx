// A plot with its title, and the ways to take it away: picture, drawing, numbers.

import type { ComponentChildren } from "preact";
import { useEffect, useRef, useState } from "preact/hooks";
import type { Numbers } from "../state/explore";
import { csv, save } from "../ui/csv";
import { t } from "../words/words";

/** What a browser calls a drawing. */
export const SVG = "image/svg+xml";
/** What a drawing takes over from the page, for it has no style sheet of its own. */
const KEPT = ["fill", "stroke", "stroke-width", "font-family", "font-size", "text-anchor", "opacity"];
/** A picture has so many pixels for each of the drawing's, and at least so many along. */
const [SHARP, PICTURE_PX] = [2, 2_400];
/** A drawing is no narrower, and that wide before it is known how much room there is, px. */
const [LEAST_PX, FIRST_PX] = [260, 1_200];

interface Needs {
  readonly title: string;
  /** What its files are called, without their endings. */
  readonly file: string;
  readonly numbers: () => Numbers;
  /** The drawing, of a width that fits the page, px. */
  readonly draw: (width: number) => ComponentChildren;
  /** What stands below it. */
  readonly children?: ComponentChildren;
}

export function PlotFile({ title, file, numbers, draw, children }: Needs) {
  const box = useRef<HTMLDivElement>(null);
  const [width, fit] = useState(FIRST_PX);
  useEffect(() => {
    if (!box.current) return undefined;
    const seen = new ResizeObserver(([entry]) => { if (entry) fit(Math.max(LEAST_PX, Math.floor(entry.contentRect.width))); });
    seen.observe(box.current);
    return () => seen.disconnect();
  }, []);
  const [wrong, say] = useState("");
  const drawing = (): SVGSVGElement | null => box.current?.querySelector("svg") ?? null;
  const picture = (): void => {
    const node = drawing();
    say("");
    if (node) void png(node, `${file}.png`).catch(() => say(t("This browser could not draw the picture. Take the SVG.")));
  };
  return (
    <section class="plot-file" aria-label={title}>
      <h2>{title}</h2>
      <div class="plot-box" ref={box}>{draw(width)}</div>
      {children}
      <p class="row no-print">
        <button type="button" onClick={picture}>PNG</button>
        <button type="button" onClick={() => { const node = drawing(); if (node) save(`${file}.svg`, styled(node), SVG); }}>SVG</button>
        <button type="button" onClick={() => { const { head, rows } = numbers(); save(`${file}.csv`, csv(head, rows)); }}>CSV</button>
      </p>
      <p class="bad-text" role="alert">{wrong}</p>
    </section>
  );
}

/** The drawing as a file of its own, in the page's colours. */
function styled(node: SVGSVGElement): string {
  const copy = node.cloneNode(true) as SVGSVGElement;
  const [from, to] = [node.querySelectorAll("*"), copy.querySelectorAll("*")];
  from.forEach((one, at) => {
    const style = getComputedStyle(one);
    for (const name of KEPT) to[at]?.setAttribute(name, style.getPropertyValue(name));
  });
  const { width, height } = node.viewBox.baseVal;
  const ground = document.createElementNS("http://www.w3.org/2000/svg", "rect");
  for (const [name, value] of Object.entries({ width, height, fill: getComputedStyle(document.documentElement).getPropertyValue("--panel") })) ground.setAttribute(name, String(value));
  copy.prepend(ground);
  for (const [name, value] of Object.entries({ xmlns: "http://www.w3.org/2000/svg", width, height })) copy.setAttribute(name, String(value));
  return new XMLSerializer().serializeToString(copy);
}

async function png(node: SVGSVGElement, name: string): Promise<void> {
  const image = new Image();
  image.src = `data:image/svg+xml;charset=utf-8,${encodeURIComponent(styled(node))}`;
  await image.decode();
  const canvas = document.createElement("canvas");
  const { width, height } = node.viewBox.baseVal;
  const sharp = Math.max(SHARP, PICTURE_PX / width);
  [canvas.width, canvas.height] = [Math.round(width * sharp), Math.round(height * sharp)];
  canvas.getContext("2d")?.drawImage(image, 0, 0, canvas.width, canvas.height);
  saveCanvas(canvas, name);
}

/** Saves what was drawn as a PNG. */
export function saveCanvas(canvas: HTMLCanvasElement, name: string): void {
  const link = document.createElement("a");
  [link.href, link.download] = [canvas.toDataURL("image/png"), name];
  link.click();
}
