// Grips on the map: what one takes hold of to move, turn or resize a whole maneuver, and how they look.

import { Style } from "ol/style";
import type { Palette } from "../map/palette";
import type { Grip } from "../state/wholes";

/** A finger is on a grip within this, px. */
export const GRIP_PX = 22;
const RADIUS_PX = 13;
/** Strokes on a field of 24 by 24. */
const SIGNS: Readonly<Record<Grip["kind"], string>> = {
  move: "M12 4v16M4 12h16M12 4l-3 3M12 4l3 3M12 20l-3-3M12 20l3-3M4 12l3-3M4 12l3 3M20 12l-3-3M20 12l-3 3",
  turn: "M18.500 14.500a7 7 0 1 1 .5-4.500M19 4.500v5.500h-5.500",
  size: "M6 6l12 12M6 6h5M6 6v5M18 18h-5M18 18v-5",
};

/** How far beside its place a grip is drawn, px to the right and down. */
export function gripOffset({ beside }: Grip, rotation: number): readonly [number, number] {
  if (typeof beside.px !== "number") return beside.px;
  const angle = ("bearing_deg" in beside ? (beside.bearing_deg * Math.PI) / 180 : 0) + rotation;
  return [beside.px * Math.sin(angle), -beside.px * Math.cos(angle)];
}

export function gripStyle(grip: Grip, { ink, halo }: Palette, rotation: number): Style {
  const [right, down] = gripOffset(grip, rotation);
  const sign = new Path2D(SIGNS[grip.kind]);
  return new Style({
    zIndex: 7,
    renderer: (pixel, { context, pixelRatio }) => {
      const [x = 0, y = 0] = pixel as number[];
      context.save();
      context.translate(x + right * pixelRatio, y + down * pixelRatio);
      context.scale(pixelRatio, pixelRatio);
      context.beginPath();
      context.arc(0, 0, RADIUS_PX, 0, 2 * Math.PI);
      Object.assign(context, { fillStyle: ink, strokeStyle: halo, lineWidth: 3 });
      context.fill();
      context.stroke();
      context.scale(0.85, 0.85);
      context.translate(-12, -12);
      Object.assign(context, { lineWidth: 2, lineCap: "round", lineJoin: "round" });
      context.stroke(sign);
      context.restore();
    },
  });
}
