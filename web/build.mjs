// Bundles src/ into dist/: names with a hash of the content, each also packed by Brotli and gzip, and a manifest that the
// server reads.

import { build } from "esbuild";
import { copyFile, mkdir, readdir, readFile, rename, rm, writeFile } from "node:fs/promises";
import { basename, join } from "node:path";
import { brotliCompressSync, gzipSync } from "node:zlib";
import { keysOfAlarms, keysOfSaid, keysOfScripts } from "./scripts/keys.mjs";
import { pack } from "./src/words/packed.mjs";

const made = "dist.new";
await rm(made, { recursive: true, force: true });
await mkdir(made);
// Of the catalogue of words a browser gets what scripts say; the server says the rest itself.
const root = join(import.meta.dirname, "..");
const said = new Set([...keysOfScripts(import.meta.dirname).keys, ...(await keysOfAlarms(root)), ...(await keysOfSaid(root, { scripts: true }))].map(([key]) => key));
const wordsOfScripts = {
  name: "words of scripts",
  setup: ({ onResolve, onLoad }) => {
    onResolve({ filter: /^lutra:nb$/ }, () => ({ path: join(import.meta.dirname, "../words/nb.json"), namespace: "words" }));
    onLoad({ filter: /.*/, namespace: "words" }, async ({ path }) => {
      const all = Object.entries(JSON.parse(await readFile(path, "utf8")));
      return { contents: JSON.stringify(pack(Object.fromEntries(all.filter(([key]) => said.has(key))))), loader: "json" };
    });
  },
};
const { metafile } = await build({
  entryPoints: ["src/main.ts", "src/offline.ts", "src/words/nb.ts", "src/style/main.css"],
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
  entryNames: "[name]-[hash]",
  assetNames: "[name]-[hash]",
  loader: { ".woff2": "file" },
  plugins: [wordsOfScripts],
  outdir: made,
  logLevel: "warning",
});

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
  const entry = output.entryPoint && basename(output.entryPoint).replace(/\.ts$/, ".js");
  if (["main.js", "offline.js", "nb.js", "main.css"].includes(entry)) manifest[entry] = name;
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
// Whoever compiles or serves at this moment sees the old bundle or the new one, hardly ever none.
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
const of = (source) => outputs.find(([, output]) => output.entryPoint === source)?.[0];
for (const page of ["fleet", "vessel", "import", "plans", "plan", "detections", "data", "logbook", "missions", "mission", "nogo", "datasets", "dataset"]) {
  const loaded = new Set(["src/main.ts", of(`src/pages/${page}.ts`) ? `src/pages/${page}.ts` : `src/pages/${page}.tsx`, "src/style/main.css"].flatMap((source) => [...reach(of(source))]));
  for (const path of Object.keys(sizes)) if (/next-latin-wght.*woff2$/.test(path)) loaded.add(path);
  const kB = Math.round([...loaded].reduce((sum, path) => sum + sizes[path], 0) / 1024);
  const words = Math.round(sizes[of("src/words/nb.ts")] / 1024);
  console.log(`web/dist: the page ${page} loads ${kB} kB; in Bokmål ${words} kB more`);
  if (kB + words > 300) throw new Error("a page may weigh 300 kB at most");
}
