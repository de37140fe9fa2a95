// How fast plots of very many points are drawn and moved.

import { createRequire } from "node:module";
import { fileURLToPath } from "node:url";
import { join } from "node:path";
import { frames, smooth, verdict, worked } from "./bench-frames.mjs";

const web = fileURLToPath(new URL("../../web", import.meta.url));
const { build } = createRequire(join(web, "package.json"))("esbuild");
const POINTS = 1_000_000;

/** The history of `vessel` from `from` to `to` (µs), in the page, from the server's buckets. */
export async function benchPlot(page, url, { vessel, from, to, seconds }) {
  await page.addInitScript(() => {
    const asked = window.fetch;
    window.fetch = async (...what) => {
      const answer = await asked(...what);
      if (!String(what[0]).includes("/buckets?")) return answer;
      const read = answer.json.bind(answer);
      answer.json = async () => {
        const found = await read();
        window.benchCame = { count: found.count.reduce((sum, one) => sum + one, 0), at: performance.now() };
        return found;
      };
      return answer;
    };
  });
  await page.goto(`${url}/vessels/${vessel}?from=${from}&to=${to}&plots=EstimatedState.1.u`);
  const plot = page.getByRole("region", { name: /^EstimatedState/ });
  await page.waitForFunction(() => window.benchCame && /m\/s/.test(document.querySelector(".legend .num").textContent));
  const drawn = [];
  const whole = [];
  let count = 0;
  for (const key of ["-", "+", "-", "+", "-", "+", "-"]) {
    await plot.locator(".canvas").focus();
    const told = await page.evaluate(
      (key) =>
        new Promise((done) => {
          window.benchCame = undefined;
          const asked = performance.now();
          document.activeElement.dispatchEvent(new KeyboardEvent("keydown", { key, bubbles: true, cancelable: true }));
          const look = () => {
            const came = window.benchCame;
            if (!came) return requestAnimationFrame(look);
            // After the frame that shows it.
            requestAnimationFrame(() => setTimeout(() => done({ count: came.count, drawn: performance.now() - came.at, whole: performance.now() - asked })));
          };
          look();
        }),
      key,
    );
    // Ten a second; what is zoomed in on has fewer.
    if (told.count < (to - from) * 0.9e-5) continue;
    count = told.count;
    drawn.push(told.drawn);
    whole.push(told.whole);
  }
  const middle = (list) => list.sort((one, other) => one - other)[Math.floor(list.length / 2)];
  verdict(`plot of ${count} samples by the server's buckets, from their arrival to the picture`, `${middle(drawn).toFixed(0)} ms`, "100 ms", middle(drawn) <= 100);
  console.log(`  from the key to the picture, with 150 ms in which further keys are awaited: ${middle(whole).toFixed(0)} ms`);
  const move = async (name) => {
    await page.evaluate(() => {
      const box = document.querySelector(".plot .canvas");
      window.benchEach = (t) => box.dispatchEvent(new WheelEvent("wheel", { deltaX: 25 * Math.cos(t / 700), deltaY: 0, bubbles: true, cancelable: true }));
    });
    smooth(name, await frames(page, seconds), 30);
    await page.evaluate(() => delete window.benchEach);
  };
  await plot.locator(".canvas").press("+");
  await page.waitForLoadState("networkidle");
  await move("the same, panned in the page");
}

/** As many points at once in the plot itself, as no page asks for. */
export async function benchRawPlot(page, url, seconds) {
  const { outputFiles } = await build({ entryPoints: [join(web, "src/plot/chart.ts")], bundle: true, format: "iife", globalName: "lutraPlot", write: false, minify: true });
  await page.goto(`${url}/account`);
  await page.evaluate(`${outputFiles[0].text}; window.lutraPlot = lutraPlot;`);
  await page.evaluate((points) => {
    const root = document.querySelector("main");
    root.className = "";
    root.replaceChildren();
    const table = [[], [], [], []];
    for (let at = 0; at < points; at++) {
      const value = 1.5 + 0.1 * Math.sin(at * 0.07) + 0.05 * Math.sin(at * 12.9898) * Math.cos(at * 78.233);
      table[0].push(1.79e9 + at / 10);
      for (const column of [1, 2, 3]) table[column].push(value);
    }
    window.bench = { root, table, first: table[0][0] * 1e6, last: table[0].at(-1) * 1e6 };
  }, POINTS);
  const drawn = [];
  for (let round = 0; round < 5; round++) {
    await page.evaluate(async () => {
      const { root, table } = window.bench;
      const nothing = () => undefined;
      const handlers = { cursor: nothing, pick: nothing, zoom: nothing, pan: nothing, scale: nothing, remove: nothing };
      window.bench.chart?.dispose();
      const chart = window.lutraPlot.createChart("Made up", "m/s", ["u"], handlers);
      root.replaceChildren(chart.root);
      // A table that was never seen before.
      Object.assign(window.bench, { chart, lines: [{ label: "u", table: table.map((column) => column.slice()) }] });
      await new Promise((done) => requestAnimationFrame(() => setTimeout(done)));
    });
    drawn.push(
      await worked(page, () =>
        page.evaluate(async () => {
          const { chart, lines, first, last } = window.bench;
          const begun = performance.now();
          chart.update(lines, first, last, []);
          await new Promise((done) => requestAnimationFrame(() => setTimeout(done)));
          return performance.now() - begun;
        }),
      ),
    );
  }
  drawn.sort((one, other) => one.found - other.found);
  verdict(`plot of ${POINTS} points, drawn raw`, `${drawn[2].found.toFixed(0)} ms, most of ${drawn.length} ${drawn.at(-1).found.toFixed(0)} ms; the page's own work ${drawn[2].own_ms.toFixed(0)} ms`, "100 ms", drawn[2].found <= 100);
  await page.evaluate(() => {
    const { chart, lines, first, last } = window.bench;
    window.benchEach = (t) => {
      const by = (last - first) * 0.1 * Math.sin(t / 700);
      chart.update(lines, first + by, last + by, []);
    };
  });
  smooth("the same, panned", await frames(page, seconds), 30);
}
