// The words of Bokmål for the browser, divided by page: of the catalogue a page gets what its own scripts say, and what became
// of orders. What parts say that come after the map and STOP is fetched with them; why the server refused something, and what
// parts say that few open, when it is first needed (`src/words/nb.ts`).

import { readFile } from "node:fs/promises";
import { join } from "node:path";
import { keysOfAlarms, keysOfSaid, keysOfScripts } from "./keys.mjs";
import { pack } from "../src/words/packed.mjs";

/** Pages with words of their own, as `bundle_of` in `server/src/pages/frame.rs` has them, and those that share theirs. */
export const OWN = ["fleet", "vessel", "plan", "nogo", "detections", "data", "explore", "register", "logbook", "missions", "mission", "datasets", "dataset"];
export const SHARED = ["import", "plans", "style"];

/** Where what comes over the live sockets is worded: no request fails there, after which words could be fetched. */
const OUTCOMES = /^crates\/(operations|hub)\/|^shore\/src\/(commands\/|router\/|error\.rs)|^server\/src\/(http\/(live|teleop)|web\/(error|guard))/;

/** Parts that each of their pages loads by `soon`, after what matters more; their words come just before them. */
export const SOON = ["src/plot/plots.ts", "src/control/panel.ts"];

/** The sources whose words are loaded with `sources`, by the metafile of a bundle. */
export function reached(inputs, sources) {
  const seen = new Set();
  const visit = (source) => {
    if (seen.has(source)) return;
    seen.add(source);
    for (const { path, kind } of inputs[source]?.imports ?? []) if (kind !== "dynamic-import") visit(path);
  };
  sources.forEach(visit);
  return seen;
}

/** What is loaded when it is first needed. */
function laterParts(inputs) {
  const loaded = Object.values(inputs).flatMap(({ imports }) => imports).filter(({ kind }) => kind === "dynamic-import");
  return loaded.map(({ path }) => path).filter((path) => !path.startsWith("src/pages/") && !SOON.includes(path));
}

/** The texts of the catalogue by bundle: for each of {@link OWN} pages, those of `others`, of the parts that come `soon`, and the
 * `rest`. `source` of a page. */
export async function wordsByBundle(web, inputs, source) {
  const root = join(web, "..");
  const nb = JSON.parse(await readFile(join(root, "words/nb.json"), "utf8"));
  const scripts = keysOfScripts(web).keys;
  const said = await keysOfSaid(root, { scripts: true });
  const always = [...(await keysOfAlarms(root)), ...said.filter(([, where]) => OUTCOMES.test(where))];
  const words = (keys) => Object.fromEntries(keys.filter(([key]) => Object.hasOwn(nb, key)).map(([key]) => [key, nb[key]]));
  const first = reached(inputs, ["src/main.ts", ...[...OWN, ...SHARED].map(source)]);
  const main = reached(inputs, ["src/main.ts"]);
  const soon = reached(inputs, SOON);
  // What one page has from the start may come later on another.
  const later = reached(inputs, laterParts(inputs));
  const ofPages = (pages) => {
    const sources = reached(inputs, ["src/main.ts", ...pages.map(source)]);
    return words([...scripts.filter(([, where]) => sources.has(where)), ...always]);
  };
  return { ...Object.fromEntries(OWN.map((page) => [page, ofPages([page])])), others: ofPages(SHARED), soon: words(scripts.filter(([, where]) => soon.has(where) && !main.has(where))), rest: words([...said, ...scripts.filter(([, where]) => !first.has(where) || (later.has(where) && !main.has(where)))]) };
}

/** For esbuild: `lutra:nb/NAME` says the words of that bundle, `lutra:words/NAME` holds them; those that are fetched later are files. */
export function wordsPlugin(web, bundles) {
  return {
    name: "words",
    setup({ onResolve, onLoad }) {
      onResolve({ filter: /^lutra:(nb|words|later)\// }, ({ path }) => ({ path, namespace: "lutra" }));
      onLoad({ filter: /^lutra:nb\//, namespace: "lutra" }, ({ path }) => ({
        contents: `import { fetched, speak } from "./src/words/nb";
import words from "${path.replace("nb", "words")}";
import soon from "lutra:later/nb-soon.json";
import rest from "lutra:later/nb-rest.json";
const [ofSoon, ofRest] = [soon, rest].map((file) => () => fetched(new URL(file, import.meta.url)));
speak(words, ofSoon, ofRest);`,
        loader: "ts",
        resolveDir: web,
      }));
      onLoad({ filter: /^lutra:words\//, namespace: "lutra" }, ({ path }) => ({ contents: JSON.stringify(pack(bundles[path.slice("lutra:words/".length)])), loader: "json" }));
      onLoad({ filter: /^lutra:later\//, namespace: "lutra" }, ({ path }) => ({ contents: JSON.stringify(pack(bundles[/nb-(\w+)/.exec(path)[1]])), loader: "file" }));
    },
  };
}
