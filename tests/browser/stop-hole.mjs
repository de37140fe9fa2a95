// STOP by a way that swallows what is sent: node stop-hole.mjs URL ONE-TIME-PASSWORD. What was carried out is read from the
// audit log by another way.

import { check, inBrowser, logIn, look } from "./browser.mjs";
import { wayTo } from "./hole.mjs";

const [url, oneTime] = process.argv.slice(2);
const BOAT = 0x0814;
/** From when the way is good again until the vessel is stopped by an order that was given before, ms. */
const BACK_MS = 12_000;
/** From the press to the server's answer on a page that says Live, ms. A machine that is busy has half of it. */
const LIVE_MS = 1_000;

await inBrowser(async (open) => {
  const direct = await open();
  await logIn(direct, url, "admin", oneTime, "nine grey otters");
  const stops = async () => (await (await direct.request.get(`${url}/api/v1/vessels/2068/commands`)).json()).filter((one) => one.order === "vessel.abort").length;

  const way = await wayTo(url);
  const page = await open();
  await logIn(page, way.url, "admin", "nine grey otters");
  await page.goto(`${way.url}/vessels/${BOAT}`);
  const live = page.locator('body[data-link="up"]');
  const orders = page.locator("#orders .order");
  const halt = page.getByRole("button", { name: "STOP otter-0", exact: true });
  await live.waitFor();
  await halt.waitFor();
  await page.getByRole("tab", { name: "Log book" }).click();

  // The way swallows, and all that the page asks hangs. That it is greyed is a matter of the clock; STOP is pressed.
  const swallowed = performance.now();
  way.swallow(true);
  await page.locator('body[data-link="down"]').waitFor();
  console.log(`greyed ${Math.round(performance.now() - swallowed)} ms after the last that came`);
  await halt.click();
  await orders.first().getByText(/NOT SENT as far as is known/).waitFor();
  check((await orders.count()) === 1, "one order");
  // Impatience makes no second order.
  await halt.click();
  await page.keyboard.press("Control+.");
  check((await orders.count()) === 1, "one order, however often it is pressed");
  await look(page, "stop-unanswered");
  // Long enough that whatever the page asks by itself has hung once more.
  while (performance.now() - swallowed < 14_000) await page.waitForTimeout(500);
  check((await stops()) === 0, "nothing came through");
  await orders.first().getByText(/NOT SENT as far as is known/).waitFor();
  console.log(`${way.dead()} connections hang`);

  // The way is good again for new connections; those that hung stay dead.
  const back = performance.now();
  way.swallow(false);
  await orders.first().getByText(/accepted, sent|NO EFFECT SEEN/).waitFor();
  console.log(`STOP got through ${Math.round(performance.now() - back)} ms after the way was good again`);
  check(performance.now() - back < BACK_MS, "the order got through in time");
  await live.waitFor();
  check((await stops()) === 1, "it was carried out once");
  check((await orders.count()) === 1, "and stands there once");

  // The same once more, but STOP is pressed as soon as the page says Live, while the old connections still hang.
  way.swallow(true);
  await page.locator('body[data-link="down"]').waitFor();
  await page.waitForTimeout(6_000);
  way.swallow(false);
  await live.waitFor();
  const pressed = performance.now();
  await halt.click();
  await orders.first().getByText(/accepted, sent/).waitFor();
  const tookMs = performance.now() - pressed;
  console.log(`STOP was answered ${Math.round(tookMs)} ms after the press, with ${way.dead()} connections that hang`);
  check(tookMs < LIVE_MS, "a page that is Live sends STOP at once");
  check((await stops()) === 2, "carried out once");

  // One way is enough: the live socket while requests are swallowed, a request while there is no socket.
  await page.route("**/abort?*", () => undefined);
  await halt.click();
  await orders.first().getByText(/accepted, sent/).waitFor();
  check((await stops()) === 3, "by the live socket alone");
  await page.unroute("**/abort?*");
  const deaf = await open();
  await deaf.routeWebSocket("**/api/live", () => undefined);
  await logIn(deaf, url, "admin", "nine grey otters");
  await deaf.goto(`${url}/vessels/${BOAT}`);
  // Before its script has begun the button is a form, which leads to another page.
  await deaf.locator("#stop[title]").waitFor();
  await deaf.locator("#stop form .halt").click();
  await deaf.locator("#orders .order").first().getByText(/NOT SENT|accepted, sent/).first().waitFor();
  check((await stops()) === 4, "by the request alone");

  // Given up, it is not sent later, and the page says what is known.
  way.swallow(true);
  await page.locator('body[data-link="down"]').waitFor();
  await halt.click();
  await page.getByRole("button", { name: "Give up: STOP otter-0" }).click();
  await orders.first().getByText(/given up, without an answer since .* Nobody knows whether it was sent\./).waitFor();
  way.swallow(false);
  await live.waitFor();
  check((await stops()) === 4, "what was given up is not sent");
  await page.getByRole("button", { name: "Close: STOP otter-0" }).first().click();
  way.close();
});
