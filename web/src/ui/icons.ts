// Icons: strokes on a field of 24 by 24, in the ink of where they stand.

const PATHS = {
  all: "M4 9V4h5M20 9V4h-5M4 15v5h5M20 15v5h-5",
  calendar: "M4 6h16v14H4ZM4 10h16M8 3v5M16 3v5",
  chart: "M3 6l6-2 6 2 6-2v14l-6 2-6-2-6 2ZM9 4v14M15 6v14",
  course: "M12 3l7 17-7-4-7 4Z",
  follow: "M12 2v5M12 17v5M2 12h5M17 12h5M12 7a5 5 0 1 0 0 10a5 5 0 0 0 0-10",
  measure: "M3 17L17 3l4 4L7 21ZM7 13l2 2M10 10l3 3M13 7l2 2",
  person: "M12 3a4 4 0 1 0 0 8a4 4 0 0 0 0-8M4 21c0-5 4-7 8-7s8 2 8 7",
  query: "M12 3a9 9 0 1 0 0 18a9 9 0 0 0 0-18M12 11v6M12 7v.5",
  rings: "M12 2a10 10 0 1 0 0 20a10 10 0 0 0 0-20M12 7a5 5 0 1 0 0 10a5 5 0 0 0 0-10M12 11.500v1",
  tags: "M3 4h8l10 10-7 7L3 12ZM7.500 8v.5",
} as const;

export type Icon = keyof typeof PATHS;

/** All of them. */
export const ICONS = Object.keys(PATHS) as readonly Icon[];

const SVG = "http://www.w3.org/2000/svg";

export function icon(name: Icon): SVGElement {
  const root = document.createElementNS(SVG, "svg");
  for (const [key, value] of [["viewBox", "0 0 24 24"], ["width", "24"], ["height", "24"], ["aria-hidden", "true"], ["class", "icon"]] as const) root.setAttribute(key, value);
  const path = document.createElementNS(SVG, "path");
  path.setAttribute("d", PATHS[name]);
  root.append(path);
  return root;
}
