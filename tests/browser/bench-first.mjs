// From the start of the demo's program to the first picture that moves: node bench-first.mjs PROGRAM [ARGUMENTS].
// The browser runs already, with an empty page, as it does when somebody starts the program and then opens its page.

import { spawn } from "node:child_process";
import { createInterface } from "node:readline";
import { inBrowser, logIn } from "./browser.mjs";

const [program, ...more] = process.argv.slice(2);

await inBrowser(async (open) => {
  const page = await open();
  const begun = performance.now();
  const told = (what) => console.log(`${what}: ${((performance.now() - begun) / 1e3).toFixed(2)} s`);
  const demo = spawn(program, ["demo", "--listen", "127.0.0.1:0", ...more], { stdio: ["ignore", "pipe", "inherit"] });
  try {
    const [url, password] = await new Promise((done, fail) => {
      demo.on("error", fail);
      demo.on("exit", (code) => fail(new Error(`the demo ended with ${code}`)));
      createInterface({ input: demo.stdout }).on("line", (line) => {
        const found = /^server +(http\S+) .* password (\S+)$/.exec(line);
        if (found) done(found.slice(1));
      });
    });
    told("start to the printed address");
    await logIn(page, url, "admin", password);
    told("start to the first page");
    // The places of vessels as they stand in the list; the page draws the map from the same.
    await page.evaluate(
      () =>
        new Promise((done) => {
          const places = new Map();
          const look = () => {
            for (const card of document.querySelectorAll(".systems .system")) {
              const [name, place] = [card.querySelector(".name").textContent, card.querySelector(".place").textContent];
              const before = places.get(name);
              if (!/\d/.test(place) || before?.place === place) continue;
              const moved = before ? before.moved + 1 : 0;
              places.set(name, { place, moved });
              if (moved === 2) return done();
            }
            requestAnimationFrame(look);
          };
          look();
        }),
    );
    told("start to a vessel that has moved twice on the page");
  } finally {
    demo.removeAllListeners("exit");
    const over = new Promise((done) => demo.on("exit", done));
    demo.kill("SIGTERM");
    await over;
  }
});
