// A heading as a needle on a ring, beside its number.

const SVG = "http://www.w3.org/2000/svg";

export interface Dial {
  readonly root: SVGElement;
  /** Points it; null takes it away. */
  turn(heading_rad: number | null): void;
}

export function createDial(): Dial {
  const node = (name: string, attributes: Readonly<Record<string, string>>): SVGElement => {
    const made = document.createElementNS(SVG, name);
    for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
    return made;
  };
  const root = node("svg", { class: "dial", viewBox: "-16 -16 32 32", width: "34", height: "34", "aria-hidden": "true" });
  const needle = node("path", { class: "needle", d: "M0 -12 L6 9 L0 5 L-6 9 Z" });
  root.append(node("circle", { class: "ring", r: "14.500" }), node("path", { class: "north", d: "M0 -14.500 V-10.500" }), needle);
  return {
    root,
    turn(heading_rad) {
      root.classList.toggle("unknown", heading_rad === null);
      if (heading_rad !== null) needle.setAttribute("transform", `rotate(${Math.round((heading_rad * 180) / Math.PI)})`);
    },
  };
}
