// Symbols of the chart, drawn here: dangers, buoys, beacons, lights. Small canvases, made once for a palette.

import { Icon } from "ol/style";
import { buoyShape, colourWords } from "../../state/chart";
import type { ChartColours } from "./colours";

/** Canvases are finer than they are shown, for screens with small pixels. */
const FINE = 2;

export type Danger = "isolated" | "rock-awash" | "rock" | "wreck" | "wreck-showing" | "obstruction" | "pile" | "structure" | "islet" | "farm";

type Draw = (ctx: CanvasRenderingContext2D, colours: ChartColours) => void;

/** An icon of `size` px whose middle, or `anchor`, is the place. */
function icon(size: number, colours: ChartColours, draw: Draw, anchor: readonly [number, number] = [0.5, 0.5]): Icon {
  const img = document.createElement("canvas");
  img.width = img.height = size * FINE;
  const ctx = img.getContext("2d");
  if (ctx) {
    ctx.scale(FINE, FINE);
    ctx.translate(size * anchor[0], size * anchor[1]);
    ctx.lineJoin = ctx.lineCap = "round";
    draw(ctx, colours);
  }
  return new Icon({ img, scale: 1 / FINE, anchor: [...anchor], declutterMode: "obstacle" });
}

/** A path drawn twice, with a halo beneath, so that it can be told from any shade. */
function haloed(ctx: CanvasRenderingContext2D, colours: ChartColours, colour: string, width: number, path: () => void): void {
  for (const [stroke, wide] of [[colours.halo, width + 2.5], [colour, width]] as const) {
    ctx.beginPath();
    path();
    ctx.strokeStyle = stroke;
    ctx.lineWidth = wide;
    ctx.stroke();
  }
}

function dotted(ctx: CanvasRenderingContext2D, radius: number): void {
  ctx.setLineDash([1, 3]);
  ctx.beginPath();
  ctx.arc(0, 0, radius, 0, 2 * Math.PI);
  ctx.stroke();
  ctx.setLineDash([]);
}

const plus = (ctx: CanvasRenderingContext2D, r: number) => (): void => {
  ctx.moveTo(-r, 0);
  ctx.lineTo(r, 0);
  ctx.moveTo(0, -r);
  ctx.lineTo(0, r);
};

const cross = (ctx: CanvasRenderingContext2D, r: number) => (): void => {
  ctx.moveTo(-r, -r);
  ctx.lineTo(r, r);
  ctx.moveTo(-r, r);
  ctx.lineTo(r, -r);
};

const DANGERS: Readonly<Record<Danger, Draw>> = {
  isolated(ctx, colours) {
    ctx.beginPath();
    ctx.arc(0, 0, 8, 0, 2 * Math.PI);
    ctx.fillStyle = colours.danger;
    ctx.fill();
    ctx.strokeStyle = colours.halo;
    ctx.lineWidth = 1.5;
    ctx.stroke();
    ctx.beginPath();
    cross(ctx, 4)();
    ctx.lineWidth = 2.6;
    ctx.stroke();
  },
  rock(ctx, colours) {
    haloed(ctx, colours, colours.outline, 1.6, plus(ctx, 5));
    ctx.strokeStyle = colours.outline;
    ctx.lineWidth = 1.2;
    dotted(ctx, 8);
  },
  "rock-awash"(ctx, colours) {
    haloed(ctx, colours, colours.outline, 1.6, () => {
      for (const turn of [0, 1, 2]) {
        const [x, y] = [6 * Math.cos((turn * Math.PI) / 3), 6 * Math.sin((turn * Math.PI) / 3)];
        ctx.moveTo(-x, -y);
        ctx.lineTo(x, y);
      }
    });
  },
  wreck(ctx, colours) {
    haloed(ctx, colours, colours.outline, 1.6, () => {
      ctx.moveTo(-8, 0);
      ctx.lineTo(8, 0);
      for (const [x, r] of [[-4.5, 3], [0, 4.5], [4.5, 3]] as const) {
        ctx.moveTo(x, -r);
        ctx.lineTo(x, r);
      }
    });
  },
  "wreck-showing"(ctx, colours) {
    haloed(ctx, colours, colours.outline, 1.6, () => {
      ctx.moveTo(-8, 4);
      ctx.lineTo(8, 4);
      ctx.moveTo(-6, 4);
      ctx.lineTo(6, -5);
      ctx.lineTo(7, 4);
      ctx.moveTo(-1, 0);
      ctx.lineTo(-4, -4);
    });
  },
  obstruction(ctx, colours) {
    ctx.beginPath();
    ctx.arc(0, 0, 7, 0, 2 * Math.PI);
    ctx.fillStyle = colours.veryShallow;
    ctx.fill();
    ctx.strokeStyle = colours.outline;
    ctx.lineWidth = 1.5;
    dotted(ctx, 7);
    haloed(ctx, colours, colours.outline, 1.4, cross(ctx, 2.5));
  },
  pile(ctx, colours) {
    ctx.beginPath();
    ctx.arc(0, 0, 3, 0, 2 * Math.PI);
    ctx.fillStyle = colours.outline;
    ctx.fill();
    ctx.strokeStyle = colours.halo;
    ctx.lineWidth = 1;
    ctx.stroke();
  },
  structure(ctx, colours) {
    haloed(ctx, colours, colours.outline, 1.4, () => ctx.rect(-4, -4, 8, 8));
    ctx.beginPath();
    ctx.arc(0, 0, 1.2, 0, 2 * Math.PI);
    ctx.fillStyle = colours.outline;
    ctx.fill();
  },
  islet(ctx, colours) {
    ctx.beginPath();
    ctx.arc(0, 0, 4, 0, 2 * Math.PI);
    ctx.fillStyle = colours.land;
    ctx.fill();
    ctx.strokeStyle = colours.coast;
    ctx.lineWidth = 1.5;
    ctx.stroke();
  },
  farm(ctx, colours) {
    ctx.fillStyle = colours.halo;
    ctx.globalAlpha = 0.75;
    ctx.fillRect(-10, -7, 20, 14);
    ctx.globalAlpha = 1;
    ctx.strokeStyle = colours.danger;
    ctx.lineWidth = 1.5;
    ctx.setLineDash([3, 2]);
    ctx.strokeRect(-10, -7, 20, 14);
    ctx.setLineDash([]);
    ctx.beginPath();
    ctx.ellipse(-1, 0, 4.5, 2.6, 0, 0, 2 * Math.PI);
    ctx.moveTo(3.5, 0);
    ctx.lineTo(7, -2.5);
    ctx.lineTo(7, 2.5);
    ctx.closePath();
    ctx.stroke();
  },
};

export function dangerIcon(danger: Danger, colours: ChartColours): Icon {
  return icon(24, colours, DANGERS[danger]);
}

/** Fills the path that `path` makes with bands of colours from top to bottom, and outlines it. */
function banded(ctx: CanvasRenderingContext2D, colours: ChartColours, words: readonly string[], top: number, bottom: number, path: () => void): void {
  const bands = words.length ? words : ["grey"];
  ctx.beginPath();
  path();
  ctx.strokeStyle = colours.halo;
  ctx.lineWidth = 3.5;
  ctx.stroke();
  ctx.save();
  ctx.clip();
  bands.forEach((word, index) => {
    ctx.fillStyle = colours.aids[word] ?? colours.area;
    const [from, to] = [top + ((bottom - top) * index) / bands.length, top + ((bottom - top) * (index + 1)) / bands.length];
    ctx.fillRect(-12, from, 24, to - from);
  });
  ctx.restore();
  ctx.strokeStyle = colours.outline;
  ctx.lineWidth = 1.2;
  ctx.stroke();
}

/** S-57 BOYSHP: conical, can, sphere, pillar, spar, barrel, super-buoy, ice buoy. */
function buoy(ctx: CanvasRenderingContext2D, shape: number): void {
  switch (shape) {
    case 1:
      ctx.moveTo(-6, -1);
      ctx.lineTo(0, -13);
      ctx.lineTo(6, -1);
      return ctx.closePath();
    case 2:
      return ctx.rect(-5, -11, 10, 10);
    case 3:
      return ctx.arc(0, -6, 5.5, 0, 2 * Math.PI);
    case 5:
      return ctx.rect(-1.8, -16, 3.6, 15);
    case 6:
      return ctx.ellipse(0, -5, 7, 4, 0, 0, 2 * Math.PI);
    case 7:
      ctx.moveTo(-8, -1);
      ctx.lineTo(-6, -7);
      ctx.lineTo(6, -7);
      ctx.lineTo(8, -1);
      return ctx.closePath();
    default:
      ctx.moveTo(-5.5, -1);
      ctx.lineTo(-1.8, -7);
      ctx.lineTo(-1.8, -16);
      ctx.lineTo(1.8, -16);
      ctx.lineTo(1.8, -7);
      ctx.lineTo(5.5, -1);
      ctx.closePath();
  }
}

/** What may stand on top: cones of cardinal marks by their colours, spheres of isolated dangers and safe water. */
function top(cls: string, words: readonly string[]): "north" | "east" | "south" | "west" | "spheres" | "sphere" | "cross" | undefined {
  if (/ISD$/.test(cls)) return "spheres";
  if (/SAW$/.test(cls)) return "sphere";
  if (/SPP$/.test(cls)) return "cross";
  if (!/CAR$/.test(cls)) return undefined;
  return ({ "black,yellow": "north", "black,yellow,black": "east", "yellow,black": "south", "yellow,black,yellow": "west" } as const)[words.join()];
}

function topmark(ctx: CanvasRenderingContext2D, colours: ChartColours, kind: NonNullable<ReturnType<typeof top>>): void {
  const dark = colours.outline;
  ctx.fillStyle = kind === "sphere" ? (colours.aids["red"] ?? dark) : kind === "cross" ? (colours.aids["yellow"] ?? dark) : dark;
  ctx.strokeStyle = dark;
  const cone = (y: number, up: boolean): void => {
    ctx.beginPath();
    ctx.moveTo(-3, up ? y + 2.4 : y - 2.4);
    ctx.lineTo(3, up ? y + 2.4 : y - 2.4);
    ctx.lineTo(0, up ? y - 2.4 : y + 2.4);
    ctx.fill();
  };
  const ball = (y: number): void => {
    ctx.beginPath();
    ctx.arc(0, y, 2.3, 0, 2 * Math.PI);
    ctx.fill();
  };
  const [low, high] = [-19.5, -25];
  if (kind === "spheres") [low, high].forEach(ball);
  else if (kind === "sphere") ball(low);
  else if (kind === "cross") {
    ctx.lineWidth = 1.6;
    ctx.beginPath();
    ctx.moveTo(-2.5, low - 2.5);
    ctx.lineTo(2.5, low + 2.5);
    ctx.moveTo(-2.5, low + 2.5);
    ctx.lineTo(2.5, low - 2.5);
    ctx.stroke();
  } else {
    // Both point to where the water is for north and south; apart for east, together for west.
    cone(low, kind === "north" || kind === "west");
    cone(high, kind === "north" || kind === "east");
  }
}

/** A buoy or beacon; its foot is the place. */
export function aidIcon(cls: string, shape: unknown, colour: unknown, colours: ChartColours): Icon {
  const words = colourWords(colour);
  const beacon = cls.startsWith("BCN") || cls === "DAYMAR";
  return icon(
    60,
    colours,
    (ctx) => {
      if (beacon) {
        banded(ctx, colours, words, -16, 0, () => ctx.rect(-2, -16, 4, 16));
        ctx.beginPath();
        ctx.moveTo(-5, 0);
        ctx.lineTo(5, 0);
        ctx.strokeStyle = colours.text;
        ctx.lineWidth = 1.5;
        ctx.stroke();
      } else {
        banded(ctx, colours, words, -16, -1, () => buoy(ctx, buoyShape(shape)));
        ctx.beginPath();
        ctx.arc(0, 0, 1.8, 0, 2 * Math.PI);
        ctx.fillStyle = colours.halo;
        ctx.fill();
        ctx.strokeStyle = colours.text;
        ctx.lineWidth = 1;
        ctx.stroke();
      }
      const kind = top(cls, words);
      if (kind) topmark(ctx, colours, kind);
    },
    [0.5, 0.6],
  );
}

/** A sounding as a picture: there are hundreds in view, and pictures are drawn faster than text is set. */
export function soundingIcon(text: string, font: string, color: string): Icon {
  const img = document.createElement("canvas");
  const ctx = img.getContext("2d");
  const [width, height] = [Math.ceil(text.length * 9) + 4, 18];
  img.width = width * FINE;
  img.height = height * FINE;
  if (ctx) {
    ctx.scale(FINE, FINE);
    ctx.font = font;
    ctx.textAlign = "center";
    ctx.textBaseline = "middle";
    ctx.fillStyle = color;
    ctx.fillText(text, width / 2, height / 2);
  }
  return new Icon({ img, scale: 1 / FINE, declutterMode: "declutter" });
}

/** A light: a flare to the lower right in its colour. */
export function lightIcon(colour: unknown, colours: ChartColours): Icon {
  const [word] = colourWords(colour);
  const fill = word === "red" || word === "green" ? colours.aids[word] : word === undefined || word === "white" || word === "yellow" || word === "amber" ? colours.aids["yellow"] : colours.caution;
  return icon(44, colours, (ctx) => {
    ctx.rotate(Math.PI / 4);
    ctx.beginPath();
    ctx.moveTo(2, 0);
    ctx.bezierCurveTo(8, -5.5, 17, -5.5, 17, 0);
    ctx.bezierCurveTo(17, 5.5, 8, 5.5, 2, 0);
    ctx.fillStyle = fill ?? colours.caution;
    ctx.fill();
    ctx.strokeStyle = colours.text;
    ctx.lineWidth = 1;
    ctx.stroke();
  });
}

/** Vertical bars for what is shown larger than it was made for. */
export function overscalePattern(colours: ChartColours): CanvasPattern | null {
  const canvas = document.createElement("canvas");
  canvas.width = 32;
  canvas.height = 8;
  const ctx = canvas.getContext("2d");
  if (!ctx) return null;
  ctx.fillStyle = colours.overscale;
  ctx.fillRect(15, 0, 1, 8);
  return ctx.createPattern(canvas, "repeat");
}
