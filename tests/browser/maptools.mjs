// Tools of the map: node maptools.mjs URL ONE-TIME-PASSWORD. Prints nothing; the boat sails.

import { check, inBrowser, logIn, look } from "./browser.mjs";

const [url, oneTime] = process.argv.slice(2);
const BOAT = 2068;

/** Degrees and minutes as the map and the cards tell them. */
const degrees = (text) => [...text.matchAll(/(\d+)° (\d+\.\d+)′/g)].map(([, whole, minutes]) => Number(whole) + Number(minutes) / 60);

await inBrowser(async (open) => {
  const page = await open();
  await logIn(page, url, "admin", oneTime, "battery horse staple");
  const csrf = await page.evaluate(() => document.querySelector('meta[name="csrf"]').content);
  await page.request.post(`${url}/admin/vessel`, { form: { csrf, name: "northern", address: String(BOAT) }, headers: { origin: url } });
  await page.goto(url);
  const tool = (name) => page.getByRole("group", { name: "Map tools" }).getByRole("button", { name, exact: true });
  const pressed = (name, is) => tool(name).and(page.locator(`[aria-pressed="${is}"]`)).waitFor();
  const card = page.locator(".vessel-card", { hasText: "northern" });
  await card.locator('.system[aria-pressed="true"]').waitFor();
  const map = page.locator(".map");
  const box = await map.boundingBox();
  const middle = [box.x + box.width / 2, box.y + box.height / 2];
  /** How far the vessel is from the middle of the map, minutes of latitude; the map tells the place under the pointer. */
  const off = async () => {
    await page.mouse.move(middle[0] + 1, middle[1]);
    await page.mouse.move(...middle);
    const [here, there] = [degrees(await page.locator(".ol-mouse-position").innerText()), degrees(await card.locator(".place").innerText())];
    return Math.max(...here.map((value, at) => Math.abs(value - there[at]))) * 60;
  };
  const until = async (holds, what) => {
    for (let times = 0; !(await holds()); times++) {
      check(times < 100, what);
      await page.waitForTimeout(100);
    }
  };

  // The map stays on the vessel until somebody drags it elsewhere.
  await page.keyboard.press("Tab");
  await map.press("ArrowRight");
  await map.press("ArrowRight");
  await until(async () => (await off()) > 0.02, "led away");
  await tool("Follow").click();
  await pressed("Follow", true);
  await until(async () => (await off()) < 0.02, `it is followed: ${await off()}′ off`);
  await page.mouse.down();
  await page.mouse.move(middle[0] - 420, middle[1] + 40, { steps: 4 });
  await page.mouse.up();
  await pressed("Follow", false);
  check((await off()) > 0.01, "and left when the map is dragged");

  // Course up turns it, north up turns it back and ends that.
  const turned = () => page.locator(".ol-compass").evaluate((node) => node.style.transform);
  check(/rotate\(0(rad)?\)|^$/.test(await turned()), await turned());
  await tool("Course up").click();
  await page.waitForFunction(() => /rotate\(-?[\d.]*[1-9]/.test(document.querySelector(".ol-compass").style.transform));
  await page.getByRole("button", { name: "North up" }).click();
  await pressed("Course up", false);

  // Range rings are kept by the browser.
  await tool("Range rings").click();
  await pressed("Range rings", true);
  await look(page, "map-tools");
  await page.reload();
  await pressed("Range rings", true);
  // Where no vessel is chosen there are no tools for it.
  await page.goto(`${url}/plans`);
  await page.getByRole("button", { name: "New plan" }).click();
  await tool("Show all").waitFor();
  check((await tool("Follow").count()) === 0, "nothing to follow on the page of a plan");
});
