// Bundles src/ into dist/: names with a hash of the content, a gzip of each, and a manifest that the server reads.

import { build } from "esbuild";
import { mkdir, readFile, rename, rm, writeFile } from "node:fs/promises";
import { basename, join } from "node:path";
import { gzipSync } from "node:zlib";

const made = "dist.new";
await rm(made, { recursive: true, force: true });
await mkdir(made);
const { metafile } = await build({
  entryPoints: ["src/main.ts", "src/style/main.css"],
  bundle: true,
  minify: true,
  sourcemap: false,
  metafile: true,
  format: "esm",
  target: "es2022",
  legalComments: "none",
  entryNames: "[name]-[hash]",
  assetNames: "[name]-[hash]",
  outdir: made,
  logLevel: "warning",
});

const manifest = {};
let sum = 0;
for (const [path, output] of Object.entries(metafile.outputs)) {
  const name = basename(path);
  const packed = gzipSync(await readFile(path), { level: 9 });
  await writeFile(join(made, `${name}.gz`), packed);
  sum += packed.length;
  if (output.entryPoint) manifest[basename(output.entryPoint).replace(/\.ts$/, ".js")] = name;
}
await writeFile(join(made, "manifest.json"), JSON.stringify(manifest, null, 2));
// Whoever compiles or serves at this moment sees the old bundle or the new one, hardly ever none.
await rm("dist", { recursive: true, force: true });
await rename(made, "dist");
console.log(`web/dist: ${Object.values(manifest).join(", ")}; ${Math.round(sum / 1024)} kB gzip`);
if (sum > 300 * 1024) throw new Error("the first page may weigh 300 kB at most");
