// How late the fleet's values are in browsers: node bench-live.mjs URL PASSWORD SECONDS.
// Vessels, server and browsers share one clock, so that a value's age on arrival is the way's latency.

import { inBrowser, logIn } from "./browser.mjs";

const BROWSERS = 5;
const [url, password, seconds] = process.argv.slice(2);

await inBrowser(async (open) => {
  const pages = [];
  for (let n = 0; n < BROWSERS; n += 1) {
    const page = await open();
    await logIn(page, url, "admin", password);
    // A page without scripts of its own, so that what is measured is the way there and not what a page draws.
    await page.goto(`${url}/api/v1/me`);
    pages.push(page);
  }
  const counted = async () => {
    const text = await (await pages[0].request.get(`${url}/metrics`)).text();
    return Number(/^lutra_relay_packets_total\{what="received"\} (\d+)/m.exec(text)?.[1] ?? NaN);
  };
  const before = await counted();
  const begun = performance.now();
  const heard = await Promise.all(
    pages.map((page) =>
      page.evaluate(
        ([url, seconds]) =>
          new Promise((done, fail) => {
            const socket = new WebSocket(`${url.replace("http", "ws")}/api/live`);
            const late_ms = [];
            let skipped = 0;
            let missed = 0;
            socket.onopen = () => socket.send(JSON.stringify({ subscribe: { every_ms: 5 } }));
            socket.onerror = () => fail(new Error("the socket failed"));
            socket.onmessage = (message) => {
              const now_ms = performance.timeOrigin + performance.now();
              const frame = JSON.parse(message.data);
              if (frame.snapshot) return;
              skipped += frame.skipped;
              missed += frame.events_missed;
              for (const update of [...frame.values, ...frame.events]) late_ms.push(now_ms - update.time_us / 1e3);
            };
            setTimeout(() => {
              socket.close();
              done({ late_ms, skipped, missed });
            }, seconds * 1e3);
          }),
        [url, Number(seconds)],
      ),
    ),
  );
  const rate = ((await counted()) - before) / ((performance.now() - begun) / 1e3);
  console.log(`packets at the server: ${rate.toFixed(0)}/s`);
  const late = heard.flatMap(({ late_ms }) => late_ms).sort((a, b) => a - b);
  const at = (share) => late[Math.floor((late.length - 1) * share)].toFixed(1);
  const skipped = heard.reduce((sum, one) => sum + one.skipped, 0);
  const missed = heard.reduce((sum, one) => sum + one.missed, 0);
  console.log(`vessel's clock to a browser's script: p50 ${at(0.5)} ms, p99 ${at(0.99)} ms, most ${at(1)} ms`);
  console.log(`values that came: ${(late.length / BROWSERS / seconds).toFixed(0)}/s a browser; replaced by newer ones: ${skipped}, events missed: ${missed}`);
});
