// STOP is within reach whatever stands on a page: nothing in the sources holds the rest of it up.

import assert from "node:assert/strict";
import { readdirSync, readFileSync } from "node:fs";
import { test } from "node:test";
import { fileURLToPath } from "node:url";

const src = fileURLToPath(new URL("../src/", import.meta.url));

test("no dialog makes STOP inert", () => {
  const held = readdirSync(src, { recursive: true })
    .filter((file) => /\.tsx?$/.test(file))
    .filter((file) => /\.showModal\(|\bwindow\.(confirm|alert|prompt)\(|(?:^|[^.\w])(?:alert|prompt)\(|aria-modal/m.test(readFileSync(src + file, "utf8")));
  assert.deepEqual(held, [], "modal: use show(), or ask in place (components/twostep.tsx, control/confirm.ts)");
});
