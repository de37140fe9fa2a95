// The font as the pages use it: with the weights that `src/style` names alone, which halves it. No letter is left out.

import { readFile } from "node:fs/promises";
import subsetFont from "subset-font";

/** The weights from the thinnest to the boldest that the style may name. */
export const WEIGHTS = { min: 400, max: 700 };

/** Each letter of a `unicode-range`, as `U+0000-00FF, U+0131`. */
export function lettersOf(range) {
  const spans = [...range.matchAll(/U\+([0-9A-F]+)(?:-([0-9A-F]+))?/g)].map(([, from, to = from]) => [parseInt(from, 16), parseInt(to, 16)]);
  return spans.flatMap(([from, to]) => Array.from({ length: to - from + 1 }, (_, at) => String.fromCodePoint(from + at))).join("");
}

/** For esbuild: of each file of a font the letters that `style` asks it for, in the weights. */
export function fontPlugin(style) {
  return {
    name: "fonts",
    setup({ onLoad }) {
      onLoad({ filter: /-wght-normal\.woff2$/ }, async ({ path }) => {
        const name = path.split("/").at(-1);
        const range = new RegExp(`${name}"[^}]*unicode-range: ([^;]*);`).exec(await readFile(style, "utf8"))?.[1];
        if (!range) throw new Error(`${style}: ${name} has no unicode-range`);
        const contents = await subsetFont(await readFile(path), lettersOf(range), { targetFormat: "woff2", variationAxes: { wght: WEIGHTS } });
        return { contents, loader: "file" };
      });
    },
  };
}
