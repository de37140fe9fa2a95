// How smoothly a page moves: frames while something happens, and what of their time is the page's own work.

/**
 * What `work` gives, and how long the page's own thread worked meanwhile, ms. On a machine that is busy with other
 * things a page waits for those too.
 */
export async function worked(page, work) {
  const cdp = await page.context().newCDPSession(page);
  await cdp.send("Performance.enable");
  const now_ms = async () => (await cdp.send("Performance.getMetrics")).metrics.find(({ name }) => name === "ThreadTime").value * 1e3;
  const before = await now_ms();
  const found = await work();
  const own_ms = (await now_ms()) - before;
  await cdp.detach();
  return { found, own_ms };
}

/** Counts frames for `seconds` while `window.benchEach` is called in each with the time since the begin, ms. */
export async function frames(page, seconds) {
  const { found: at, own_ms: all_ms } = await worked(page, () => page.evaluate(
    (ms) =>
      new Promise((done) => {
        const begun = performance.now();
        const seen = [];
        const frame = (now) => {
          seen.push(now);
          const t = performance.now() - begun;
          window.benchEach?.(t);
          if (t < ms) requestAnimationFrame(frame);
          else done(seen);
        };
        requestAnimationFrame(frame);
      }),
    seconds * 1e3,
  ));
  const took = at.slice(1).map((now, number) => now - at[number]).sort((one, other) => one - other);
  const share = (part) => took[Math.floor((took.length - 1) * part)];
  return { rate: ((at.length - 1) / (at.at(-1) - at[0])) * 1e3, p50_ms: share(0.5), p95_ms: share(0.95), most_ms: share(1), own_ms: all_ms / at.length };
}

/** One line of it, beside what is wanted; one frame in fifty may be late. */
export function smooth(what, { rate, p50_ms, p95_ms, most_ms, own_ms }, goal) {
  verdict(what, `${rate.toFixed(1)} frames/s; a frame p50 ${p50_ms.toFixed(1)} ms, p95 ${p95_ms.toFixed(1)} ms, most ${most_ms.toFixed(0)} ms; the page's own work ${own_ms.toFixed(1)} ms a frame`, `${goal} frames/s`, rate >= goal * 0.98);
}

/** A figure beside what is wanted. */
export function verdict(what, figure, goal, met) {
  console.log(`${what}: ${figure} (goal ${goal}${met ? "" : ": MISSED"})`);
}

/** Leads the map of a page round about while `work` goes on, as a hand would. */
export async function panning(page, work) {
  await page.evaluate(() => {
    const viewport = document.querySelector(".map > .ol-viewport");
    const { left, top, width, height } = viewport.getBoundingClientRect();
    const send = (type, t) =>
      (type === "pointerdown" ? viewport : document).dispatchEvent(
        new PointerEvent(type, {
          bubbles: true,
          clientX: left + width / 2 + width * 0.35 * Math.sin(t / 900),
          clientY: top + height / 2 + height * 0.3 * Math.sin(t / 1300),
          pointerId: 1,
          isPrimary: true,
          pointerType: "mouse",
          button: type === "pointermove" ? -1 : 0,
          buttons: type === "pointerup" ? 0 : 1,
        }),
      );
    document.querySelector(".map").focus();
    send("pointerdown", 0);
    let last = 0;
    window.benchEach = (t) => send("pointermove", (last = t));
    window.benchEnd = () => send("pointerup", last);
  });
  const found = await work();
  await page.evaluate(() => {
    window.benchEnd();
    delete window.benchEach;
  });
  return found;
}
