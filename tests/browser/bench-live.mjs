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
            const ashore_ms = [];
            let skipped = 0;
            let missed = 0;
            socket.onopen = () => socket.send(JSON.stringify({ subscribe: { every_ms: 2 } }));
            socket.onerror = () => fail(new Error("the socket failed"));
            socket.onmessage = (message) => {
              const now_ms = performance.timeOrigin + performance.now();
              const frame = JSON.parse(message.data);
              if (frame.snapshot) return;
              skipped += frame.skipped;
              missed += frame.events_missed;
              for (const { time_us, received_us } of [...frame.values, ...frame.events]) {
                late_ms.push(now_ms - time_us / 1e3);
                ashore_ms.push((received_us - time_us) / 1e3);
              }
            };
            setTimeout(() => {
              socket.close();
              done({ late_ms, ashore_ms, skipped, missed });
            }, seconds * 1e3);
          }),
        [url, Number(seconds)],
      ),
    ),
  );
  const rate = ((await counted()) - before) / ((performance.now() - begun) / 1e3);
  console.log(`packets at the server: ${rate.toFixed(0)}/s`);
  const sorted = (list) => list.sort((a, b) => a - b);
  const late = sorted(heard.flatMap(({ late_ms }) => late_ms));
  const shares = (list) => [0.5, 0.99, 1].map((share) => list[Math.floor((list.length - 1) * share)].toFixed(1));
  const told = ([p50, p99, most]) => `p50 ${p50} ms, p99 ${p99} ms, most ${most} ms`;
  const skipped = heard.reduce((sum, one) => sum + one.skipped, 0);
  const missed = heard.reduce((sum, one) => sum + one.missed, 0);
  console.log(`a vessel's time to the server: ${told(shares(sorted(heard.flatMap(({ ashore_ms }) => ashore_ms))))}`);
  console.log(`a vessel's time to a browser's script: ${told(shares(late))}`);
  console.log(`values that came: ${(late.length / BROWSERS / seconds).toFixed(0)}/s a browser; replaced by newer ones: ${skipped}, events missed: ${missed}`);
});
