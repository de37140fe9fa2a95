// Modules of the pages, bundled for Node. What is written for that lies in one folder, which goes with the process.

import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { build } from "esbuild";

/** A folder for what a test writes. */
export const folder = mkdtempSync(join(tmpdir(), "lutra-web-"));
process.on("exit", () => rmSync(folder, { recursive: true, force: true }));

/** The module at `src/{path}.ts`; with a word for `copy`, another copy of it, whose tables are made anew. */
export async function load(path, copy = "") {
  const outfile = join(folder, `${path.replaceAll("/", "-")}.mjs`);
  await build({ entryPoints: [`src/${path}.ts`], bundle: true, format: "esm", outfile, logLevel: "warning" });
  return import(`${outfile}?${copy}`);
}
