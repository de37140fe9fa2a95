// The chart on the map: node chart.mjs URL ONE-TIME-PASSWORD, against a server that holds the demonstration's chart.

import { check, inBrowser, logIn, look } from "./browser.mjs";

const [url, oneTime] = process.argv.slice(2);
/** About the middle of the demonstration's harbour cell. */
const MIDDLE = { lat_deg: 63.446, lon_deg: 10.352 };

/** How many different colours the map's canvas shows: an empty one shows one. */
const colours = (page) =>
  page.evaluate(() => {
    const seen = new Set();
    for (const canvas of document.querySelectorAll(".map canvas")) {
      const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
      for (let at = 0; at < data.length; at += 4 * 97) if (data[at + 3]) seen.add((data[at] << 16) | (data[at + 1] << 8) | data[at + 2]);
    }
    return [...seen];
  });
const shows = async (page, colour) => {
  for (let tries = 0; tries < 100; tries++) {
    if ((await colours(page)).includes(colour)) return true;
    await page.evaluate(() => new Promise((done) => requestAnimationFrame(done)));
    await new Promise((done) => setTimeout(done, 100));
  }
  return false;
};

await inBrowser(async (open) => {
  const page = await open();
  await logIn(page, url, "admin", oneTime, "nine grey otters");
  const csrf = await page.evaluate(() => document.querySelector('meta[name="csrf"]').content);
  const draw = async (name, ...places) => {
    const maneuvers = places.map(([lat_deg, lon_deg], at) => ({ id: `P${at + 1}`, speed: { value: 1.5, unit: "mps" }, task: { kind: "goto", at: { lat_deg, lon_deg } } }));
    const made = await page.request.post(`${url}/api/v1/plans`, { headers: { "x-csrf-token": csrf }, data: { name, description: "", vessel: null, repeat: false, maneuvers } });
    check(made.ok(), await made.text());
    await page.goto(`${url}/plans/${(await made.json()).id}`);
    await page.locator(".chart-credit").getByText("NOT FOR NAVIGATION").waitFor();
  };

  // The whole of the harbour, in all palettes; the colours change without a reload.
  const { lat_deg, lon_deg } = MIDDLE;
  await draw("harbour", [lat_deg - 0.009, lon_deg - 0.02], [lat_deg + 0.009, lon_deg + 0.02]);
  check(await shows(page, 0xc9b97a), "land in the colour of the day");
  check(await shows(page, 0xd4eaee), "deep water in the colour of the day");
  await page.locator(".chart-credit").getByText(/depths in m below chart datum · safety depth 5 m/).waitFor();
  await page.evaluate(() => (document.documentElement.dataset.palette = "night"));
  check(await shows(page, 0x14100c), "land in the colour of the night");
  await page.evaluate(() => (document.documentElement.dataset.palette = "day"));
  check(await shows(page, 0xc9b97a), "and of the day again");

  // A plan over a shoal or land is refused where it is.
  await page.getByText(/refused by the chart/).waitFor();
  const spot = page.locator(".guard .spot").first();
  await spot.waitFor();
  check(/XX[45]LUTRA/.test(await spot.innerText()), `the reason names its chart: ${await spot.innerText()}`);
  const bad = Number.parseInt((await page.evaluate(() => getComputedStyle(document.documentElement).getPropertyValue("--bad"))).trim().slice(1), 16);
  check(await shows(page, bad), "the refused leg is drawn in the colour of danger");
  await spot.click();
  await page.getByRole("application", { name: /Depth along the plan/ }).focus();
  for (let n = 0; n < 20; n++) await page.keyboard.press("ArrowRight");
  await page.getByText(/^At \d+ m: /).waitFor();
  await page.getByText("As a table").click();
  check((await page.getByRole("region", { name: /as a table/ }).getByRole("row").count()) > 10, "the profile as a table");
  await look(page, "chart-refused");

  // One over deep water is not.
  await draw("deep", [63.4465, 10.3500], [63.4485, 10.3530]);
  await page.locator(".guard-ok, .guard").first().waitFor();
  check((await page.getByText(/refused by the chart/).count()) === 0, "deep water is taken");

  // What is here, by mouse and by keyboard.
  const map = page.getByRole("application", { name: /Map of the plan/ });
  const box = await map.boundingBox();
  await page.mouse.move(box.x + box.width * 0.4, box.y + box.height * 0.6);
  await page.locator(".chart-depth").getByText(/^(Depth \d|Land|Obstacle)/).waitFor();
  await page.mouse.click(box.x + box.width * 0.4, box.y + box.height * 0.6);
  const panel = page.locator(".chart-query");
  await panel.getByText(/XX[45]LUTRA edition 1 update 0, 1 : [15]/).first().waitFor();
  await panel.getByText(/zone of confidence [A-D]/).first().waitFor();
  await page.getByRole("button", { name: "Close what is here" }).click();
  await page.getByRole("button", { name: "What is here" }).focus();
  await page.keyboard.press("Enter");
  await panel.getByRole("heading", { name: "What is here" }).waitFor();
  check(await page.evaluate(() => document.querySelector(".chart-query").contains(document.activeElement)), "the keyboard is in the panel");
  await page.keyboard.press("Escape");
  check((await page.evaluate(() => document.activeElement.getAttribute("aria-label"))) === "What is here", "and back at the button");

  // A wheel over the map zooms it, wherever the keyboard is.
  const before = await page.locator(".ol-scale-line-inner").evaluate((bar) => bar.style.width);
  await page.mouse.move(box.x + box.width * 0.5, box.y + box.height * 0.5);
  await page.mouse.wheel(0, -400);
  await page.waitForFunction((before) => document.querySelector(".ol-scale-line-inner").style.width !== before, before);
  check(!(await page.evaluate(() => document.querySelector(".map").contains(document.activeElement))), "the map has no focus");

  // Too near is overscale; the switches are remembered; the base cannot be switched off.
  await map.focus();
  for (let n = 0; n < 3; n++) await page.getByTitle("Zoom in").click();
  await page.getByText(/^Overscale × \d+: chart 1 : \d/).waitFor();
  await page.getByRole("button", { name: "Chart", exact: true }).click();
  check(await page.getByLabel(/Depths, land and dangers/).isDisabled(), "the base stays");
  const safety = page.getByLabel(/Safety depth of the shades/);
  await safety.fill("20");
  await safety.press("Enter");
  await page.locator(".chart-credit").getByText(/safety depth 20 m/).waitFor();
  await page.getByText("1 to 20 m: less than the safety depth chosen here").waitFor();
  await safety.fill("2");
  await safety.press("Enter");
  await page.locator(".chart-credit").getByText(/safety depth 5 m/).waitFor();
  check((await safety.inputValue()) === "5", "never less than the guard's");
  await page.getByLabel("Soundings").uncheck();
  await look(page, "chart-overscale");
  await page.reload();
  await page.locator(".map canvas").first().waitFor();
  // One that began beside the map goes on scrolling the page when the map comes under the pointer.
  const taken = await page.evaluate(() => {
    const turn = (target) => {
      const event = new WheelEvent("wheel", { deltaY: 100, bubbles: true, cancelable: true });
      target.dispatchEvent(event);
      return event.defaultPrevented;
    };
    turn(document.body);
    return turn(document.querySelector(".map > .ol-viewport"));
  });
  check(!taken, "the page is scrolled, not the map zoomed");
  await page.getByRole("button", { name: "Chart", exact: true }).click();
  check(!(await page.getByLabel("Soundings").isChecked()), "what is left out is remembered");
  await page.getByLabel("Soundings").check();

  // Where there is no chart it says so.
  await draw("far", [63.60, 10.70], [63.61, 10.72]);
  await page.locator(".chart-note").getByText("No chart here").waitFor();
  await page.getByText(/refused by the chart/).waitFor();
  await look(page, "chart-none-here");

  // While its tiles are on their way, nothing says that there is no chart.
  let [release, held] = [() => undefined, 0];
  const released = new Promise((done) => (release = done));
  await page.route("**/api/v1/chart/tiles/**", async (route) => {
    held += 1;
    await released;
    await route.continue();
  });
  await draw("near", [lat_deg - 0.002, lon_deg - 0.004], [lat_deg + 0.002, lon_deg + 0.004]);
  await page.locator(".chart-note").getByText("Loading the chart …").waitFor();
  check(held > 0, "tiles are held back");
  release();
  await page.locator(".chart-note").getByText("Loading the chart …").waitFor({ state: "hidden" });
  check(!(await page.locator(".chart-note").getByText("No chart here").isVisible()), "the chart is there once its tiles are");
  await page.unroute("**/api/v1/chart/tiles/**");

  // The fleet has it too.
  await page.goto(url);
  await page.locator(".chart-credit").getByText("NOT FOR NAVIGATION").waitFor();
  await look(page, "chart-fleet");
});
