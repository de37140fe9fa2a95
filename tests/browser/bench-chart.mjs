// How smoothly a map with its chart is panned: node bench-chart.mjs URL PASSWORD [SECONDS]. The person is `admin`, the
// chart of the demonstration is imported. Prints frames a second, how long frames take and what of it is the page's.

import { inBrowser, logIn } from "./browser.mjs";

const [url, password, seconds = "6"] = process.argv.slice(2);
const HARBOUR = [63.4445, 10.352];

await inBrowser(async (open) => {
  const page = await open();
  await logIn(page, url, "admin", password);
  const csrf = await page.evaluate(() => document.querySelector('meta[name="csrf"]').content);
  const [lat_deg, lon_deg] = HARBOUR;
  const corner = (id, north, east) => ({ id, speed: { value: 1, unit: "mps" }, task: { kind: "goto", at: { lat_deg: lat_deg + north, lon_deg: lon_deg + east } } });
  const plan = { name: `bench ${Date.now()}`, description: "", vessel: null, repeat: false, maneuvers: [corner("a", -0.008, -0.02), corner("b", 0.008, 0.02)] };
  const made = await page.request.post(`${url}/api/v1/plans`, { headers: { "x-csrf-token": csrf }, data: plan });
  await page.goto(`${url}/plans/${(await made.json()).id}`);
  await page.locator(".chart-credit").getByText("depths in m").waitFor();
  await page.waitForLoadState("networkidle");
  const run = () =>
    page.evaluate(
      (ms) =>
        new Promise((done) => {
          const viewport = document.querySelector(".ol-viewport");
          document.querySelector(".map").focus();
          const { left, top, width, height } = viewport.getBoundingClientRect();
          const send = (type, x, y) =>
            (type === "pointerdown" ? viewport : document).dispatchEvent(
              new PointerEvent(type, { bubbles: true, clientX: x, clientY: y, pointerId: 1, isPrimary: true, pointerType: "mouse", button: type === "pointermove" ? -1 : 0, buttons: type === "pointerup" ? 0 : 1 }),
            );
          const place = (t) => [left + width / 2 + width * 0.35 * Math.sin(t / 900), top + height / 2 + height * 0.3 * Math.sin(t / 1300)];
          const begun = performance.now();
          const frames = [];
          send("pointerdown", ...place(0));
          const frame = (now) => {
            frames.push(now);
            const t = performance.now() - begun;
            send("pointermove", ...place(t));
            if (t < ms) return requestAnimationFrame(frame);
            send("pointerup", ...place(t));
            done(frames);
          };
          requestAnimationFrame(frame);
        }),
      Number(seconds) * 1e3,
    );
  // What the page's thread works itself: on a machine that is busy with other things frames wait for those.
  const cdp = await page.context().newCDPSession(page);
  await cdp.send("Performance.enable");
  const worked_ms = async () => (await cdp.send("Performance.getMetrics")).metrics.find(({ name }) => name === "ThreadTime").value * 1e3;
  for (const name of ["first pan", "panned again"]) {
    const before = await worked_ms();
    const frames = await run();
    const each = ((await worked_ms()) - before) / frames.length;
    const took = frames.slice(1).map((at, number) => at - frames[number]).sort((one, other) => one - other);
    const share = (part) => took[Math.floor((took.length - 1) * part)].toFixed(1);
    const rate = ((frames.length - 1) / (frames.at(-1) - frames[0])) * 1e3;
    console.log(`${name}: ${rate.toFixed(1)} frames/s; a frame p50 ${share(0.5)} ms, p95 ${share(0.95)} ms, most ${share(1)} ms; the page's own work ${each.toFixed(1)} ms a frame`);
  }
});
