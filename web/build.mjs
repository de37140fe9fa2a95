// Bundles src/ into dist/: names with a hash of the content, a gzip of each, and a manifest that the server reads.

import { build } from "esbuild";
import { copyFile, mkdir, readdir, readFile, rename, rm, writeFile } from "node:fs/promises";
import { basename, join } from "node:path";
import { gzipSync } from "node:zlib";

const made = "dist.new";
await rm(made, { recursive: true, force: true });
await mkdir(made);
const { metafile } = await build({
  entryPoints: ["src/main.ts", "src/offline.ts", "src/style/main.css"],
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
  outdir: made,
  logLevel: "warning",
});

const manifest = {};
const sizes = {};
for (const [path, output] of Object.entries(metafile.outputs)) {
  const name = basename(path);
  const packed = gzipSync(await readFile(path), { level: 9 });
  await writeFile(join(made, `${name}.gz`), packed);
  sizes[path] = packed.length;
  const entry = output.entryPoint && basename(output.entryPoint).replace(/\.ts$/, ".js");
  if (["main.js", "offline.js", "main.css"].includes(entry)) manifest[entry] = name;
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
for (const icon of await readdir("icons")) await copyFile(join("icons", icon), join(made, icon));
// Whoever compiles or serves at this moment sees the old bundle or the new one, hardly ever none.
await rm("dist", { recursive: true, force: true });
await rename(made, "dist");

// What each page loads: everything that its entry reaches, and the style.
const reach = (path, seen = new Set()) => {
  if (seen.has(path)) return seen;
  seen.add(path);
  for (const one of metafile.outputs[path].imports) if (one.kind === "import-statement") reach(one.path, seen);
  return seen;
};
const outputs = Object.entries(metafile.outputs);
const of = (source) => outputs.find(([, output]) => output.entryPoint === source)?.[0];
for (const page of ["fleet", "vessel", "import", "plans", "plan", "detections", "data", "logbook", "missions", "mission"]) {
  const loaded = new Set(["src/main.ts", of(`src/pages/${page}.ts`) ? `src/pages/${page}.ts` : `src/pages/${page}.tsx`, "src/style/main.css"].flatMap((source) => [...reach(of(source))]));
  const kB = Math.round([...loaded].reduce((sum, path) => sum + sizes[path], 0) / 1024);
  console.log(`web/dist: the page ${page} loads ${kB} kB gzip`);
  if (kB > 300) throw new Error("a page may weigh 300 kB at most");
}
