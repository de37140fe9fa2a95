// Bundles src/ into dist/: names with a hash of the content, each also packed by Brotli and gzip, and a manifest that the
// server reads.

import { build } from "esbuild";
import { copyFile, mkdir, readdir, readFile, rename, rm, writeFile } from "node:fs/promises";
import { basename, join } from "node:path";
import { brotliCompressSync, gzipSync } from "node:zlib";
import { existsSync } from "node:fs";
import { fontPlugin } from "./scripts/fonts.mjs";
import { openLayersPlugin } from "./scripts/openlayers.mjs";
import { OWN, SHARED, wordsByBundle, wordsPlugin } from "./scripts/words.mjs";

/** What each page may load before it is used, packed, with the words of Bokmål, kB: a twentieth above what it does, so that growth
 * is seen, and of a vessel's page what people with a slow line were promised. The Control tab and the plots of a vessel come after it. */
const MOST_KB = { fleet: 179, vessel: 200, plan: 256, nogo: 187, detections: 186, data: 83, explore: 194, register: 89, logbook: 88, missions: 85, mission: 90, datasets: 88, dataset: 98, import: 72, plans: 84, style: 77 };

const made = "dist.new";
await rm(made, { recursive: true, force: true });
await mkdir(made);
const source = (page) => `src/pages/${page}.ts${existsSync(`src/pages/${page}.tsx`) ? "x" : ""}`;
const shared = {
  bundle: true,
  minify: true,
  sourcemap: false,
  metafile: true,
  format: "esm",
  splitting: true,
  chunkNames: "[name]-[hash]",
  target: "es2022",
  jsx: "automatic",
  jsxImportSource: "preact",
  legalComments: "none",
  // What OpenLayers keeps for itself ends so; nothing asks for it by a text.
  mangleProps: /[a-zA-Z]_$/,
  entryNames: "[name]-[hash]",
  assetNames: "[name]-[hash]",
  outdir: made,
  logLevel: "warning",
};
const scripts = await build({
  ...shared,
  entryPoints: ["src/main.ts", "src/offline.ts", "src/style/main.css"],
  plugins: [fontPlugin("src/style/tokens.css"), openLayersPlugin],
});
const bundles = await wordsByBundle(import.meta.dirname, scripts.metafile.inputs, source);
const words = await build({
  ...shared,
  entryPoints: Object.keys(bundles).filter((name) => !["soon", "rest"].includes(name)).map((name) => ({ in: `lutra:nb/${name}`, out: name === "others" ? "nb" : `nb-${name}` })),
  plugins: [wordsPlugin(import.meta.dirname, bundles)],
});
const metafile = { outputs: { ...scripts.metafile.outputs, ...words.metafile.outputs } };

const manifest = {};
const sizes = {};
for (const [path, output] of Object.entries(metafile.outputs)) {
  const name = basename(path);
  const plain = await readFile(path);
  sizes[path] = plain.length;
  // A font is packed already.
  if (!path.endsWith(".woff2")) {
    const packed = brotliCompressSync(plain);
    await writeFile(join(made, `${name}.br`), packed);
    await writeFile(join(made, `${name}.gz`), gzipSync(plain, { level: 9 }));
    sizes[path] = packed.length;
  }
  const plainName = name.replace(/-[A-Z0-9]{8}\./, ".");
  const isWords = output.entryPoint?.includes("lutra:nb/");
  if (isWords || ["main.js", "offline.js", "main.css"].includes(output.entryPoint && plainName)) manifest[plainName] = name;
}
await writeFile(join(made, "manifest.json"), JSON.stringify(manifest, null, 2));
// The worker's address must not change, so that a browser finds the new one.
await build({
  entryPoints: ["src/worker.ts"],
  bundle: true,
  minify: true,
  format: "esm",
  target: "es2022",
  legalComments: "none",
  outdir: made,
  define: { PARTS: JSON.stringify(["main.css", "offline.js"].map((name) => `/static/${manifest[name]}`)) },
  logLevel: "warning",
});
await copyFile("node_modules/@fontsource-variable/atkinson-hyperlegible-next/LICENSE", join(made, "font-license.txt"));
for (const icon of await readdir("icons")) await copyFile(join("icons", icon), join(made, icon));
// A build or a server at this moment finds the old bundle or the new one.
await rm("dist", { recursive: true, force: true });
await rename(made, "dist");

// What each page loads: everything that its entry reaches, the style, and the font for western Europe.
const reach = (path, seen = new Set()) => {
  if (seen.has(path)) return seen;
  seen.add(path);
  for (const one of metafile.outputs[path].imports) if (one.kind === "import-statement") reach(one.path, seen);
  return seen;
};
const outputs = Object.entries(metafile.outputs);
const of = (source) => outputs.find(([, output]) => output.entryPoint?.replace(/^lutra:lutra:/, "lutra:") === source)?.[0];
for (const page of [...OWN, ...SHARED]) {
  const loaded = new Set(["src/main.ts", source(page), "src/style/main.css"].flatMap((one) => [...reach(of(one))]));
  for (const path of Object.keys(sizes)) if (/next-latin-wght.*woff2$/.test(path)) loaded.add(path);
  const kB = Math.round([...loaded].reduce((sum, path) => sum + sizes[path], 0) / 1024);
  const words = Math.round([...reach(of(`lutra:nb/${OWN.includes(page) ? page : "others"}`))].reduce((sum, path) => sum + sizes[path], 0) / 1024);
  console.log(`web/dist: the page ${page} loads ${kB} kB; in Bokmål ${words} kB more`);
  if (!(kB + words <= MOST_KB[page])) throw new Error(`the page ${page} weighs ${kB + words} kB; ${MOST_KB[page]} kB are allowed: load less, or later`);
}
