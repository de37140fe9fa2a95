// STOP over TLS while whatever else goes to the server hangs: node held.mjs URL PORT TOKEN PASSWORD PROTOCOL. The way to the server
// listens on PORT, or on any (0); PROTOCOL is how requests go, `http/1.1` or `h2`. What was carried out is asked beside that way.

import { BUSY, check, inBrowser, logIn, look, until } from "./browser.mjs";
import { wayTo } from "./hole.mjs";

const [url, port, token, password, protocol] = process.argv.slice(2);
const VESSEL = 0x2810;
/** Connections that a browser opens for requests by HTTP/1.1; by HTTP/2 it has one. */
const CONNECTIONS = 6;
/** From a press on a page whose live socket is dead until the server has it, ms. Silence alone shows that after 2.8 s; where a STOP
 * waits, 1.5 s are enough. */
const DEAD_MS = 2_700 * BUSY;
/** The same on a page that is Live, ms. */
const LIVE_MS = 1_000 * BUSY;

await inBrowser(async (open) => {
  // The authority is the test's own.
  const options = { ignoreHTTPSErrors: true };
  const beside = await open(options);
  const commands = async () => (await beside.request.get(`${url}/api/v1/vessels/${VESSEL}/commands`, { headers: { authorization: `Bearer ${token}` } })).json();
  const stops = async () => (await commands()).filter((one) => one.order === "vessel.abort").length;

  const way = await wayTo(url, Number(port));
  const page = await open(options);
  const sockets = [];
  page.on("websocket", (socket) => sockets.push(socket.url()));
  await logIn(page, way.url, "nils", password);
  await page.goto(`${way.url}/vessels/${VESSEL}?tab=Control`);
  const live = page.locator('body[data-link="up"]');
  const halt = page.getByRole("button", { name: "STOP otter-1", exact: true });
  const latest = page.locator("#orders .order").first();
  await live.waitFor();
  await halt.waitFor();
  check(sockets.length > 0 && sockets.every((one) => one.startsWith("wss://")), `the live socket: ${sockets}`);
  const others = await page.evaluate(
    (wanted) =>
      [...performance.getEntriesByType("navigation"), ...performance.getEntriesByType("resource")]
        .filter((one) => one.name.startsWith("https:") && one.transferSize > 0 && one.nextHopProtocol !== wanted)
        .map((one) => `${one.nextHopProtocol} ${new URL(one.name).pathname}`),
    protocol,
  );
  check(!others.length, `by another protocol than ${protocol}: ${others.join(", ")}`);

  // The page's own requests, which it gives up when the link is lost, hold nothing then.
  await page.waitForLoadState("networkidle");
  // Downloads hold each connection for requests, and the way dies under them and under the live socket. New connections are good.
  way.swallow(true);
  await page.evaluate((count) => {
    window.held = count;
    const over = () => (window.held -= 1);
    for (let n = 0; n < count; n++) fetch(`/api/v1/vessels?held=${n}`).then(over, over);
  }, CONNECTIONS);
  const dead = protocol === "h2" ? 2 : CONNECTIONS + 1;
  await until(() => way.dead() >= dead, `${dead} connections are dead`);
  way.swallow(false);
  const press = async (withinMs, count, what) => {
    const pressed = performance.now();
    await halt.click();
    await latest.getByText(/accepted, sent|stopped after/).waitFor();
    const tookMs = performance.now() - pressed;
    console.log(`${what}: the server had STOP ${Math.round(tookMs)} ms after the press, with ${way.dead()} connections that hang`);
    check(tookMs < withinMs, `${what}: ${Math.round(tookMs)} ms`);
    check((await stops()) === count, `${what}: carried out once`);
    check((await page.evaluate(() => window.held)) === CONNECTIONS, `${what}: the downloads still hang`);
  };
  await press(DEAD_MS, 1, "a page whose live socket is dead");
  await live.waitFor();
  await press(LIVE_MS, 2, "a page that is Live");
  await look(page, "stop-held");
  way.close();
});
