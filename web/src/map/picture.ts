// What a map shows, as one picture.

import type OlMap from "ol/Map";
import type { FleetMap } from "./map";

/** Draws the map once more and puts its layers on top of each other, in the pixels of this screen, but for those of a class. Rejected
 * where the browser may not read a layer, as pictures of other servers. */
export async function pictureOf({ ol, ground }: Pick<FleetMap, "ol" | "ground">, without?: string): Promise<HTMLCanvasElement> {
  await Promise.all([ol, ground].map(complete));
  return drawn(ol, without);
}

function complete(map: OlMap): Promise<void> {
  return new Promise((done) => {
    map.once("rendercomplete", () => done());
    map.render();
  });
}

function drawn(map: OlMap, without?: string): HTMLCanvasElement {
  const picture = document.createElement("canvas");
  const [wide = 0, high = 0] = map.getSize() ?? [];
  const sharp = window.devicePixelRatio;
  [picture.width, picture.height] = [Math.round(wide * sharp), Math.round(high * sharp)];
  const [pen, view] = [picture.getContext("2d"), map.getTargetElement()];
  if (!pen || !view) throw new Error("the map has no place to be drawn");
  pen.fillStyle = groundOf(view);
  pen.fillRect(0, 0, picture.width, picture.height);
  for (const layer of view.querySelectorAll<HTMLCanvasElement>(".ol-layer canvas, canvas.ol-layer")) {
    if (!layer.width || !layer.height || (without && layer.closest(`.${without}`))) continue;
    const parent = layer.parentElement;
    pen.globalAlpha = Number((parent?.style.opacity || layer.style.opacity) || 1);
    // Layers are drawn sharper than the page, or moved while they wait to be drawn.
    pen.setTransform(new DOMMatrix().scale(sharp).multiply(new DOMMatrix(getComputedStyle(layer).transform)));
    pen.drawImage(layer, 0, 0);
  }
  return picture;
}

/** The colour that is seen where no layer draws anything: of the map itself, or of what it lies on. */
function groundOf(view: HTMLElement): string {
  for (let on: HTMLElement | null = view; on; on = on.parentElement) {
    const { backgroundColor } = getComputedStyle(on);
    if (!/^(transparent|rgba\(.*, 0\))$/.test(backgroundColor)) return backgroundColor;
  }
  return "white";
}
