// Steering a simulated Otter by hand, and eight ways in which that fails: node teleop.mjs URL PASSWORD. Prints when each
// fault came (the last fresh sample of the person's hands, ms of UTC) and what it wants done to processes and cables;
// whether the vessel stopped in time its own log tells.

import { check, inBrowser, logIn, look } from "./browser.mjs";

const [url, password] = process.argv.slice(2);
const OTTER = 10256;

/** Runs in the page: notes the last fresh sample by a clock that nobody moves, and holds a gamepad and a clock to move. */
function instrument() {
  const now = performance.now.bind(performance);
  window.jumpMs = 0;
  performance.now = () => now() + window.jumpMs;
  const send = WebSocket.prototype.send;
  let change;
  WebSocket.prototype.send = function (text) {
    const sample = JSON.parse(text).sample;
    // A sample whose device shows no change is none of the hands'.
    if (sample?.held && sample.change !== change) window.freshMs = performance.timeOrigin + now();
    if (sample) change = sample.change;
    send.call(this, text);
  };
  window.pad = null;
  window.frozen = false;
  window.seen = true;
  Object.defineProperty(document, "visibilityState", { get: () => (window.seen ? "visible" : "hidden") });
  navigator.getGamepads = () => {
    if (!window.pad) return [null];
    if (!window.frozen) window.pad.timestamp = now();
    const { held, ahead, timestamp } = window.pad;
    const buttons = Array.from({ length: 17 }, (_, index) => ({ pressed: index === 7 && held, value: index === 7 && held ? 1 : 0 }));
    return [{ index: 0, id: "test pad", connected: true, mapping: "standard", timestamp, axes: [0, -ahead, 0, 0], buttons }];
  };
}

await inBrowser(async (open) => {
  const other = await open();
  await logIn(other, url, "bert", password);
  let page;
  const button = (page, name) => page.getByRole("button", { name, exact: true });
  const state = (text) => page.locator(".helm-state").getByText(text).waitFor();
  const enter = async (of) => {
    // A server that was killed is back soon, and its old connections are told to be broken one by one.
    for (let tries = 0; ; tries += 1) {
      try {
        await of.goto(`${url}/vessels/${OTTER}`);
        break;
      } catch (error) {
        if (tries === 50) throw error;
        await of.waitForTimeout(200);
      }
    }
    await of.getByText("Live", { exact: true }).waitFor();
    await of.getByRole("tab", { name: "Control" }).click();
  };
  const arrive = async () => {
    page = await open();
    await page.addInitScript(instrument);
    await logIn(page, url, "anna", password);
    await takeControl();
  };
  const takeControl = async () => {
    await enter(page);
    const take = page.locator(".control").getByRole("button", { name: /^Take (control|control here|over …)$/ });
    const mine = page.getByText("You have control of this vessel.");
    await take.or(mine).first().waitFor();
    if (!(await mine.isVisible())) {
      if ((await take.innerText()) === "Take over …") {
        await page.getByLabel("Reason, for the one who has control").fill("a test");
        await take.click();
        await button(page, "Take over now").click();
      } else await take.click();
    }
    await mine.waitFor();
    const up = async () => (await (await page.request.get(`${url}/api/v1/links`)).json()).some((one) => one.vessel === OTTER && one.up);
    for (const end = Date.now() + 60_000; !(await up()); ) check(Date.now() < end, "the link does not stand");
  };
  const begin = async () => {
    const refused = page.locator(".control .note:visible");
    for (let tries = 0; ; tries++) {
      await button(page, "Steer by hand …").click();
      await button(page, "Steer by hand").click();
      const ready = page.locator(".helm-state").getByText(/Ready/);
      await ready.or(refused).first().waitFor();
      if (await ready.isVisible()) return;
      if (tries === 20) throw new Error(`not begun: ${await refused.innerText()}`);
    }
  };
  const tell = (text) => console.log(text);
  const fresh = () => page.evaluate(() => window.freshMs);
  /** Whatever moves from here on may move. */
  const may = async () => tell(`may ${Date.now()}`);
  const byKeys = async () => {
    await state(/Ready/);
    await may();
    await page.locator(".helm-keys").focus();
    await page.keyboard.down("Space");
    await state("STEERING");
    await page.keyboard.down("ArrowUp");
    await moves();
  };
  const letGo = async () => {
    for (const key of ["ArrowUp", "Space"]) await page.keyboard.up(key);
  };
  /** Until the vessel itself says that its motors turn. */
  const moves = async () => {
    const from = new Date().toISOString();
    const turning = async () => {
      const csv = await (await page.request.get(`${url}/api/v1/export.csv?message=SetThrusterActuation&vessel=${OTTER}&from=${from}`)).text();
      return csv.split("\n").slice(1).some((row) => Number(row.trim().split(",").at(-1)) > 0.1);
    };
    for (const end = Date.now() + 30_000; !(await turning()); ) check(Date.now() < end, "the motors do not turn");
  };
  const stays = async (text) => {
    // Sticks that are still held do not move it.
    await state(/STOPPED/);
    await page.locator(".helm-state").getByText(text).waitFor();
  };
  const fault = (name, ms) => tell(`fault ${name} ${ms}`);

  await arrive();
  check(await button(page, "Steer by hand …").isEnabled(), "with control one may steer");
  await begin();
  await look(page, "teleop-ready");
  await button(page, "End steering by hand").click();
  await begin();
  await byKeys();
  await look(page, "teleop-steering");
  await letGo();
  await stays("the dead-man was released").catch(() => undefined);

  // The tab is hidden.
  await byKeys();
  await page.evaluate(() => {
    window.seen = false;
    document.dispatchEvent(new Event("visibilitychange"));
  });
  fault("tab-hidden", await fresh());
  await page.evaluate(() => (window.seen = true));
  await state(/Ready|STOPPED/);
  await letGo();

  // The clock of the browser jumps.
  await byKeys();
  fault("clock-jump", await page.evaluate(() => ((window.jumpMs = 3_600_000), window.freshMs)));
  await stays(/the clock of your computer jumped|released|sign of life|too late/);
  await look(page, "teleop-stopped");
  await letGo();
  await state(/Ready/);

  // A gamepad: in neutral with the dead-man released first; then it freezes, then it is gone.
  const padSays = (held, ahead) => page.evaluate(([held, ahead]) => (window.pad = { held, ahead, timestamp: 0 }), [held, ahead]);
  const byPad = async () => {
    await padSays(false, 0);
    await state(/Ready/);
    await may();
    await padSays(true, 0);
    await state("STEERING");
    await padSays(true, 1);
    await moves();
  };
  await byPad();
  await page.evaluate(() => (window.frozen = true));
  await stays(/sign of life/);
  fault("gamepad-frozen", await fresh());
  await page.evaluate(() => (window.frozen = false));
  // It lives again with the dead-man still held: that is not enough.
  await page.waitForFunction((since) => performance.timeOrigin + performance.now() - window.jumpMs > since + 1_500, await fresh());
  await state(/STOPPED/);
  await byPad();
  fault("gamepad-unplugged", await page.evaluate(() => ((window.pad = null), window.freshMs)));
  await state(/Ready|STOPPED/);

  // Somebody else takes over.
  await enter(other);
  await other.getByLabel("Reason, for the one who has control").fill("my turn");
  await button(other, "Take over …").click();
  await byKeys();
  await button(other, "Take over now").click();
  await other.getByText("You have control of this vessel.").waitFor();
  const lease = await (await other.request.get(`${url}/api/v1/vessels/${OTTER}/lease`)).json();
  fault("lease-taken", lease.holder.since_us / 1e3);
  await page.getByText("Steering by hand ended: you do not have control").or(page.getByText("Ended: you do not have control")).first().waitFor();
  await letGo();
  await look(page, "teleop-taken");
  await button(other, "Release control").click();
  await other.getByText("Nobody has control of this vessel.").waitFor();

  // The way to the vessel, and the way to the server, carry nothing any more.
  for (const way of ["vessel", "browser"]) {
    await takeControl();
    await begin();
    await byKeys();
    tell(`silence ${way}`);
    await (way === "browser" ? state("The server is not heard") : page.locator('.helm[data-phase="locked"], .helm[hidden]').waitFor({ state: "attached", timeout: 60_000 }));
    await letGo();
    tell(`passes ${way}`);
  }

  // The server is killed.
  await takeControl();
  await begin();
  await byKeys();
  tell("kill server");
  await page.getByText(/Steering by hand ended: the server is not reached/).waitFor();
  await letGo();

  // The browser is killed.
  await takeControl();
  await begin();
  await byKeys();
  fault("browser-killed", await fresh());
  const cdp = await page.context().newCDPSession(page);
  const gone = page.waitForEvent("crash");
  cdp.send("Page.crash").catch(() => undefined);
  await gone;
});
