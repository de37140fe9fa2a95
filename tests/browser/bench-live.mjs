// How late the fleet's values are at browsers: node --experimental-websocket bench-live.mjs URL PASSWORD SECONDS.
// Vessels, server and browsers share one clock, so that a value's age on arrival is the way's latency. Measured
// where a browser's socket hands a frame over, before a page reads it; there again while fifty requests for routes wait
// all the time; and in the scripts of real pages.

import { inBrowser, logIn } from "./browser.mjs";

const BROWSERS = 5;
/** Requests for routes that are under way at any time; the server has room for so many. */
const ROUTES = 50;
/** Around the demo's chart. */
const [SOUTH_DEG, NORTH_DEG, WEST_DEG, EAST_DEG] = [63.43, 63.46, 10.31, 10.39];
/** As often as the server tells anybody what is new, in milliseconds. */
const EVERY_MS = Number(process.env.BENCH_EVERY_MS ?? 2);
const [url, password, duration_s] = process.argv.slice(2);
const seconds = Number(duration_s);

/** Listens for a while; runs here and in pages, so that it can use nothing from outside. */
async function listen({ url, seconds, every_ms, headers }) {
  const target = `${url.replace("http", "ws")}/api/live`;
  const socket = headers ? new WebSocket(target, { headers }) : new WebSocket(target);
  const told = { late_ms: [], ashore_ms: [], skipped: 0, missed: 0, frames: 0 };
  await new Promise((done, fail) => {
    socket.onopen = () => socket.send(JSON.stringify({ subscribe: { every_ms } }));
    socket.onerror = () => fail(new Error("the socket failed"));
    socket.onmessage = (message) => {
      const now_ms = performance.timeOrigin + performance.now();
      const frame = JSON.parse(message.data);
      if (frame.snapshot) return;
      told.frames += 1;
      told.skipped += frame.skipped;
      told.missed += frame.events_missed;
      for (const { time_us, received_us } of [...frame.values, ...frame.events]) {
        told.late_ms.push(now_ms - time_us / 1e3);
        told.ashore_ms.push((received_us - time_us) / 1e3);
      }
    };
    setTimeout(done, seconds * 1e3);
  });
  socket.close();
  return told;
}

function report(where, heard) {
  const all = (name) => heard.flatMap((one) => one[name]).sort((a, b) => a - b);
  const sum = (name) => heard.reduce((sum, one) => sum + one[name], 0);
  const told = (list) => {
    const [p50, p99, most] = [0.5, 0.99, 1].map((share) => list[Math.floor((list.length - 1) * share)]?.toFixed(1));
    return `p50 ${p50} ms, p99 ${p99} ms, most ${most} ms`;
  };
  const each = (count) => (count / BROWSERS / seconds).toFixed(0);
  const late = all("late_ms");
  console.log(`${where}: ${told(late)}; of that to the server: ${told(all("ashore_ms"))}`);
  console.log(
    `  ${each(late.length)} values/s and ${each(sum("frames"))} frames/s for each; ` +
      `replaced by newer ones: ${sum("skipped")}, events missed: ${sum("missed")}`,
  );
}

/** Keeps so many requests for routes under way while `work` is done: between places by chance, each with a clearance of its own, so
 * that most need water that was not prepared. */
async function amongRoutes(headers, work) {
  const within = (least, most) => least + Math.random() * (most - least);
  const place = () => [within(SOUTH_DEG, NORTH_DEG), within(WEST_DEG, EAST_DEG)];
  const [answers, took_ms] = [{}, []];
  let wanted = true;
  const ask = async () => {
    while (wanted) {
      const begun = performance.now();
      const body = JSON.stringify({ points: [place(), place()], clearance_m: Math.round(within(10, 200)) });
      const answer = await fetch(`${url}/api/v1/chart/route`, { method: "POST", headers: { ...headers, "content-type": "application/json" }, body });
      await answer.arrayBuffer();
      answers[answer.status] = (answers[answer.status] ?? 0) + 1;
      took_ms.push(performance.now() - begun);
    }
  };
  const all = Array.from({ length: ROUTES }, ask);
  const done = await work();
  wanted = false;
  await Promise.all(all);
  took_ms.sort((a, b) => a - b);
  const counts = Object.entries(answers).map(([status, count]) => `${count} with ${status}`).join(", ");
  console.log(`${ROUTES} requests for routes at a time: ${counts}; p50 ${took_ms[took_ms.length >> 1].toFixed(0)} ms, most ${took_ms.at(-1).toFixed(0)} ms`);
  return done;
}

await inBrowser(async (open) => {
  const first = await open();
  await logIn(first, url, "admin", password);
  const counted = async () => {
    const text = await (await first.request.get(`${url}/metrics`)).text();
    return Number(/^lutra_relay_packets_total\{what="received"\} (\d+)/m.exec(text)?.[1] ?? NaN);
  };
  const rate = async (work) => {
    const [before, begun] = [await counted(), performance.now()];
    const done = await work();
    const packets = (await counted()) - before;
    console.log(`packets at the server: ${(packets / ((performance.now() - begun) / 1e3)).toFixed(0)}/s`);
    return done;
  };
  const five = (each) => Promise.all(Array.from({ length: BROWSERS }, each));
  // A page without scripts of its own, so that what is measured is the way there and not what a page draws.
  const csrf = await first.locator('meta[name="csrf"]').getAttribute("content");
  await first.goto(`${url}/api/v1/me`);
  const cookies = await first.context().cookies();
  const headers = { cookie: cookies.map(({ name, value }) => `${name}=${value}`).join("; "), origin: url };
  const asked = { url, seconds, every_ms: EVERY_MS };
  report("a vessel's time to five sockets", await rate(() => five(() => listen({ ...asked, headers }))));
  const posting = { ...headers, "x-csrf-token": csrf };
  report("the same among routes", await rate(() => amongRoutes(posting, () => five(() => listen({ ...asked, headers })))));

  const pages = [first];
  while (pages.length < BROWSERS) {
    const page = await open();
    await logIn(page, url, "admin", password);
    await page.goto(`${url}/api/v1/me`);
    pages.push(page);
  }
  report("a vessel's time to scripts in five pages", await rate(() => five((_, n) => pages[n].evaluate(listen, asked))));
});
