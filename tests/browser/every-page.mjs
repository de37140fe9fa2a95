// Every page and what opens on it, with an alarm of each priority told: node every-page.mjs URL ONE-TIME-PASSWORD.

import { check, inBrowser, logIn, lookInAll as look } from "./browser.mjs";

const [url, oneTime] = process.argv.slice(2);
const BOAT = 2068;

/** The page that shows what pages are made of: the font has come, and its digits are of one width. */
async function judgeStyle(page) {
  await page.getByRole("heading", { name: "Icons" }).waitFor();
  check(await page.evaluate(() => document.fonts.ready.then(() => [...document.fonts].some(({ family, status }) => family.includes("Atkinson") && status === "loaded"))), "the font has come");
  const widths = await page.locator(".digits .num").evaluateAll((all) => all.map((one) => one.getBoundingClientRect().width));
  check(widths.length === 2 && widths[0] === widths[1] && widths[0] > 0, `digits of one width: ${widths}`);
}

await inBrowser(async (open) => {
  const page = await open();
  await page.goto(`${url}/login`);
  await look(page, "login");
  await logIn(page, url, "admin", oneTime, "nine grey otters");
  await look(page, "password changed");
  const csrf = await page.evaluate(() => document.querySelector('meta[name="csrf"]').content);
  const goto = (id, lat_deg) => ({ id, speed: { value: 1.5, unit: "mps" }, task: { kind: "goto", at: { lat_deg, lon_deg: 10.4 } } });
  const made = await page.request.post(`${url}/api/v1/plans`, { headers: { "x-csrf-token": csrf }, data: { name: "a plan", description: "", vessel: null, repeat: false, maneuvers: [goto("a", 63.44), goto("b", 63.45)] } });
  const plan = (await made.json()).id;
  const recorded = { name: "a mission", people: "", purpose: "", notes: "", vessels: [BOAT], from_us: 1_700_000_000_000_000, to_us: 1_700_000_060_000_000 };
  const mission = (await (await page.request.post(`${url}/api/v1/missions`, { headers: { "x-csrf-token": csrf }, data: recorded })).json()).id;
  const set = await page.request.post(`${url}/api/v1/datasets`, { headers: { "x-csrf-token": csrf }, data: { title: "a dataset" } });
  const dataset = (await set.json()).id;
  const go = async (path) => {
    await page.goto(url + path);
    await page.getByText("Live", { exact: true }).waitFor();
    await page.locator('#alarms[data-priority="emergency"]').waitFor();
  };

  // All four priorities in the bar and in its list, which also holds the form for putting aside.
  await go("/");
  await page.locator("#alarms .open").click();
  for (const priority of ["emergency", "alarm", "warning", "caution"]) await page.locator(`#alarm-list li[data-priority="${priority}"]`).first().waitFor();
  await page.locator("#alarm-list .shelf summary").first().click();
  await look(page, "every-alarm");
  await page.locator("#alarm-list").press("Escape");
  await page.getByRole("list", { name: "Systems" }).getByText(/emergency: Grounding/).first().waitFor();
  await look(page, "fleet");

  // A vessel: each tab, and what opens in it.
  const tabs = ["Plots", "Values", "Entities", "Log book", "Tags", "Link loss", "Parameters", "Control"];
  for (const tab of tabs) {
    await go(`/vessels/${BOAT}?tab=${encodeURIComponent(tab)}`);
    await page.locator('[data-tile="mode"]').getByText("Executing maneuver").waitFor();
    if (tab === "Plots") {
      await page.getByRole("button", { name: "Add a field" }).click();
      await look(page, "vessel with the list of fields");
      await page.keyboard.press("Escape");
    }
    await look(page, `every-${tab.toLowerCase().replace(" ", "-")}`);
  }
  await page.getByRole("button", { name: "Take control" }).click();
  await page.getByText("You have control of this vessel.").waitFor();
  await page.getByLabel("Latitude, °").fill("63.44");
  await page.getByLabel("Longitude, °").fill("10.4");
  await page.getByRole("button", { name: "Go there …" }).click();
  await page.getByRole("group", { name: /^Send otter-0 there/ }).waitFor();
  await look(page, "vessel with a question");
  await page.keyboard.press("Escape");
  await page.getByRole("button", { name: "STOP otter-0" }).click();
  await page.getByText(/STOP otter-0: /).first().waitFor();
  await look(page, "vessel with a stop");
  await page.getByRole("button", { name: "Replay what is shown" }).click();
  await look(page, "vessel in the past");

  for (const [path, name] of [["/plans", "plans"], [`/plans/${plan}`, "plan"], ["/logbook", "log book"], ["/missions", "missions"], ["/no-go-areas", "no-go areas"], [`/missions/${mission}`, "mission"], ["/detections", "detections"], ["/alarms", "alarms"], ["/data", "data"], ["/explore", "explorer"], ["/register", "register"], ["/datasets", "datasets"], [`/datasets/${dataset}`, "dataset"], ["/account", "account"], ["/style", "style"], ["/admin", "people"], ["/admin/vessels", "vessels"], ["/admin/sessions", "sessions"], ["/admin/tokens", "tokens"], ["/admin/import", "import"], ["/admin/connections", "transports"], ["/admin/storage", "storage"], ["/admin/audit", "audit"]]) {
    await go(path);
    if (name === "plans") await page.getByText("STOP …").click();
    // Red is for STOP and for what is wrong, not for what takes something away.
    const red = await page.evaluate(() => [...document.querySelectorAll("button.danger, details.ask summary")].filter((one) => getComputedStyle(one).color !== getComputedStyle(document.body).color).map((one) => one.textContent));
    check(!red.length, `${path}: in another colour than text: ${red.join("; ")}`);
    if (name === "plan") await page.locator(".steps .step").first().click();
    if (name === "people") await page.getByRole("row", { name: /^admin/ }).getByText("Change", { exact: true }).click();
    if (name === "style") await judgeStyle(page);
    if (name === "no-go areas") await page.getByRole("button", { name: "Close an area", exact: true }).click();
    if (name === "missions") await page.getByRole("button", { name: "New mission" }).click();
    await look(page, name);
  }
  await page.getByRole("button", { name: "Help" }).click();
  await page.getByRole("dialog", { name: "Help" }).waitFor();
  await look(page, "help");
  const missing = await page.goto(`${url}/nowhere`);
  check(missing.status() === 404, "there is no such page");
  await look(page, "no such page");
});
