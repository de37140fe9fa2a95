// A plot with its title, and the ways to take it away: picture, drawing, numbers.

import type { ComponentChildren } from "preact";
import { useRef, useState } from "preact/hooks";
import type { Numbers } from "../state/explore";
import { csv, save } from "../ui/csv";
import { t } from "../words/words";

/** What a drawing takes over from the page, for it has no style sheet of its own. */
const KEPT = ["fill", "stroke", "stroke-width", "font-family", "font-size", "text-anchor", "opacity"];
/** A picture has so many pixels for each of the drawing's. */
const SHARP = 2;

interface Needs {
  readonly title: string;
  /** What its files are called, without their endings. */
  readonly file: string;
  readonly numbers: () => Numbers;
  readonly children: ComponentChildren;
}

export function PlotFile({ title, file, numbers, children }: Needs) {
  const box = useRef<HTMLDivElement>(null);
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
      <div class="plot-scroll" tabIndex={0} role="group" aria-label={t("{title}, scrolls sideways", { title })} ref={box}>{children}</div>
      <p class="row no-print">
        <button type="button" onClick={picture}>PNG</button>
        <button type="button" onClick={() => { const node = drawing(); if (node) save(`${file}.svg`, styled(node)); }}>SVG</button>
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
  [canvas.width, canvas.height] = [width * SHARP, height * SHARP];
  canvas.getContext("2d")?.drawImage(image, 0, 0, canvas.width, canvas.height);
  const link = document.createElement("a");
  [link.href, link.download] = [canvas.toDataURL("image/png"), name];
  link.click();
}
