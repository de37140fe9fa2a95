// The Control tab of a vessel comes after the rest of its page: bundled for Node, with the tab itself and the browser stood in.

import assert from "node:assert/strict";
import { test } from "node:test";
import { build } from "esbuild";
import { join } from "node:path";
import { folder } from "../testing/bundled.mjs";

const STAND_INS = {
  "./panel": `if (globalThis.isGone) throw new Error("not loaded"); export const createControl = () => ({ update: (...state) => globalThis.updates.push(state) });`,
  "../ui/dom": `export const make = () => ({ remove: () => (globalThis.waits = false), replaceWith: (offer) => (globalThis.waits = offer) });`,
  "../ui/reload": `export const reloadOffer = () => "Load the page again";`,
};
const outfile = join(folder, "control-soon.mjs");
await build({
  entryPoints: ["src/control/soon.ts"],
  bundle: true,
  format: "esm",
  outfile,
  logLevel: "warning",
  plugins: [{
    name: "stand-ins",
    setup({ onResolve, onLoad }) {
      onResolve({ filter: /.*/ }, ({ path }) => (path in STAND_INS ? { path, namespace: "stand-in" } : undefined));
      onLoad({ filter: /.*/, namespace: "stand-in" }, ({ path }) => ({ contents: STAND_INS[path] }));
    },
  }],
});
const loaded = () => new Promise((done) => setImmediate(done));
const begin = async (which) => (await import(`${outfile}?${which}`)).createControlSoon({ append: () => (globalThis.waits = true) }, {});

test("the tab that comes gets the last of what was told before, and all that is told later", async () => {
  globalThis.updates = [];
  const control = await begin("well");
  control.update("first");
  control.update("second", 2);
  assert.deepEqual([globalThis.updates, globalThis.waits], [[], true]);
  await loaded();
  assert.deepEqual([globalThis.updates, globalThis.waits], [[["second", 2]], false]);
  control.update("third");
  assert.deepEqual(globalThis.updates.at(-1), ["third"]);
});

test("a tab that did not come says so and is offered again", async () => {
  globalThis.isGone = true;
  const control = await begin("badly");
  control.update("first");
  await loaded();
  assert.equal(globalThis.waits, "Load the page again");
  control.update("second");
});
