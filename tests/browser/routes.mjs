// Routes on the demonstration's chart: a refused leg is sailed around, a route is drawn and pulled, and a vessel is sent
// behind an island: node routes.mjs URL PASSWORD VESSEL.

import { check, fits, inBrowser, logIn, look } from "./browser.mjs";

const [url, password, vessel] = process.argv.slice(2);
const ADDRESS = { "otter-1": 10449, "otter-2": 10450, "otter-3": 10451 }[vessel];
/** In deep water on both sides of an island. */
const EAST = [63.4455, 10.352];
const WEST = [63.4455, 10.314];

await inBrowser(async (open) => {
  const page = await open();
  page.context().setDefaultTimeout(60_000);
  await logIn(page, url, "admin", password);
  const csrf = await page.evaluate(() => document.querySelector('meta[name="csrf"]').content);
  const maneuvers = [EAST, WEST].map(([lat_deg, lon_deg], at) => ({ id: `P${at + 1}`, speed: { value: 1.5, unit: "mps" }, task: { kind: "goto", at: { lat_deg, lon_deg } } }));
  const made = await page.request.post(`${url}/api/v1/plans`, { headers: { "x-csrf-token": csrf }, data: { name: "around", description: "", vessel: null, repeat: false, maneuvers } });
  check(made.ok(), await made.text());
  await page.goto(`${url}/plans/${(await made.json()).id}`);

  // The refused leg offers a way around; taking it makes the plan safe, and one undo takes it back.
  await page.getByText(/refused by the chart/).waitFor();
  await page.getByRole("button", { name: /^Route around: / }).first().click();
  const panel = page.locator(".sea-route");
  await panel.getByRole("heading", { name: "Way around: P2" }).waitFor();
  const text = panel.getByText(/^\d+ m · \d+ min · least depth [\d.]+ m · clear by \d+ m$/);
  await text.waitFor();
  const lengthM = async () => Number.parseInt(await text.innerText(), 10);
  check((await lengthM()) > 2_500, `around the island: ${await text.innerText()}`);
  await look(page, "route-around");
  await fits(page, "the plan page with a route");
  await panel.getByRole("button", { name: "Take this way" }).click();
  await page.locator(".guard-ok, .guard-by").first().waitFor();
  await page.waitForFunction(() => !/refused by the chart/.test(document.body.innerText));
  check((await page.locator(".plan-list").innerText()).includes("Path 1"), "the way is a path of the plan");
  await page.getByRole("button", { name: "Undo" }).click();
  await page.getByText(/refused by the chart/).waitFor();
  await page.getByRole("button", { name: "Redo" }).click();

  // A route by itself: from the end of the plan to a click, at once longer where more clearance is asked, pulled aside.
  await page.getByRole("button", { name: "Route …" }).click();
  await panel.getByText("Click on the map where it leads.").waitFor();
  const box = await page.locator(".map").boundingBox();
  await page.mouse.click(box.x + box.width * 0.8, box.y + box.height * 0.62);
  await text.waitFor();
  const plain = await lengthM();
  const clearance = panel.getByRole("spinbutton", { name: /Keep clear by/ });
  await clearance.fill("60");
  await clearance.press("Enter");
  const wider = await page.waitForFunction((plain) => {
    const now = Number.parseInt(document.querySelector(".sea-route .totals").textContent, 10);
    return now > plain && now;
  }, plain).then((handle) => handle.jsonValue());
  await page.mouse.move(box.x + box.width * 0.8, box.y + box.height * 0.62);
  await page.mouse.down();
  await page.mouse.move(box.x + box.width * 0.85, box.y + box.height * 0.6, { steps: 8 });
  await page.mouse.up();
  await page.waitForFunction((wider) => ![wider, NaN].includes(Number.parseInt(document.querySelector(".sea-route .totals").textContent, 10)), wider);
  await look(page, "route-drawn");

  // What cannot be is told, with what would do.
  await clearance.fill("2000");
  await clearance.press("Enter");
  await panel.locator(".note.bad").waitFor();
  await panel.getByRole("button", { name: "Close" }).click();
  check((await panel.count()) === 0, "the panel is gone");

  // Sent behind the island: by the route, confirmed with its length, as a plan that the vessel sails.
  await page.goto(`${url}/vessels/${ADDRESS}?tab=Control`);
  await page.getByRole("button", { name: "Take control" }).click();
  const go = page.getByRole("button", { name: "Go there …" });
  await page.waitForFunction((button) => !button.disabled, await go.elementHandle());
  await page.getByLabel("Latitude, °").fill(String(WEST[0]));
  await page.getByLabel("Longitude, °").fill(String(WEST[1]));
  await go.click();
  await page.getByRole("heading", { name: `Send ${vessel} there by this route?` }).waitFor();
  await page.getByText(/The straight way is closed by the chart. By a route of \d+ legs: /).waitFor();
  await look(page, "route-send");
  await page.getByRole("button", { name: "Go by this route" }).click();
  await page.locator(".under-way").getByText(/^Sails To 63\.4455 10\.3140 /).waitFor();
  await look(page, "route-sailed");
});
