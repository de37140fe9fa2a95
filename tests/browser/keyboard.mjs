// Everything by keyboard alone: node keyboard.mjs URL PASSWORD. No pointer is used and no focus set by the script: keys
// only. Wherever the focus stops it must be seen.

import { check, inBrowser } from "./browser.mjs";

const [url, password] = process.argv.slice(2);
const OTTER = 10449;
/** No page has more stops than this. */
const STOPS = 200;

await inBrowser(async (open) => {
  const page = await open();
  page.context().setDefaultTimeout(60_000);
  const press = (...keys) => keys.reduce((before, key) => before.then(() => page.keyboard.press(key)), Promise.resolve());
  /** What has the focus: its role or element, its name, and whether one sees that. */
  const focused = () =>
    page.evaluate(() => {
      const one = document.activeElement;
      if (!one || one === document.body) return undefined;
      const style = getComputedStyle(one);
      const { width, height, top, bottom } = one.getBoundingClientRect();
      // Of a label around its field, what is not the field.
      const own = (label) => (label.contains(one) ? [...label.childNodes].filter((node) => !node.contains(one)).map((node) => node.textContent).join("") : label.textContent);
      const label = one.getAttribute("aria-label") ?? (one.labels?.[0] ? own(one.labels[0]) : one.textContent);
      return {
        name: label.trim(),
        seen: width > 0 && height > 0 && bottom > 0 && top < innerHeight && ((style.outlineStyle !== "none" && style.outlineWidth !== "0px") || style.boxShadow !== "none"),
        html: one.outerHTML.slice(0, 120),
      };
    });
  /** Goes on with Tab to what has this name. */
  const to = async (name, key = "Tab") => {
    const passed = [];
    for (let stop = 0; stop < STOPS; stop++) {
      const at = await focused();
      if (at && (typeof name === "string" ? at.name === name : name.test(at.name))) return;
      await press(key);
      const now = await focused();
      if (!now) continue;
      check(now.seen, `the focus is not seen: ${now.html}`);
      passed.push(now.name);
    }
    throw new Error(`Tab does not come to ${name}, but to ${[...new Set(passed)].join(" | ")}`);
  };
  const type = async (name, text) => {
    await to(name);
    await press("Control+a");
    await page.keyboard.type(text);
    await press("Enter");
  };
  const choose = async (name, option) => {
    await to(name);
    await page.keyboard.type(option);
  };

  /** Enter, which leads to another page. */
  const follow = async (address) => {
    await press("Enter");
    await page.waitForURL(address);
    await page.getByText("Live", { exact: true }).waitFor();
  };

  await page.goto(`${url}/login`);
  await to(/^Name/);
  await page.keyboard.type("admin");
  await to(/^Password/);
  await page.keyboard.type(password);
  await follow(/:\d+\/$/);
  const { fix } = (await (await page.request.get(`${url}/api/v1/vessels`)).json()).find((one) => one.address === OTTER);

  // A plan of three kinds of maneuver, typed, nudged on the map, put in order, taken back.
  await to("Plans");
  await follow(/\/plans$/);
  await to("New plan");
  await follow(/\/plans\/\d+$/);
  await page.getByText("No maneuvers yet.").waitFor();
  const steps = page.getByRole("list", { name: "Maneuvers" }).getByRole("listitem");
  const add = async (kind, count) => {
    await choose("What to add", kind);
    await to("Add");
    await press("Enter");
    await page.waitForFunction((count) => document.querySelectorAll(".steps > li").length === count, count);
  };
  await add("Goto", 1);
  await type("Latitude", (fix.lat_deg + 0.0004).toFixed(6));
  await type("Longitude", fix.lon_deg.toFixed(6));
  await to("What to add", "Shift+Tab");
  await add("Station", 2);
  await type("Latitude", (fix.lat_deg + 0.0008).toFixed(6));
  await type("Longitude", fix.lon_deg.toFixed(6));
  await to(/^Map of the plan/, "Shift+Tab");
  await press("Shift+ArrowUp", "ArrowRight");
  await to("What to add", "Shift+Tab");
  await add("Path", 3);
  await press("Delete");
  await page.waitForFunction(() => document.querySelectorAll(".steps > li").length === 2);
  await press("Control+z");
  await page.waitForFunction(() => document.querySelectorAll(".steps > li").length === 3);
  await press("Control+y");
  await page.waitForFunction(() => document.querySelectorAll(".steps > li").length === 2);
  await to(/^2 Station/);
  await press("Alt+ArrowUp");
  await steps.first().getByText("1 Station 1").waitFor();
  await press("Control+z");
  await steps.first().getByText("1 Goto 1").waitFor();
  await to("Name of the plan", "Shift+Tab");
  await type("Name of the plan", "by keys");
  await press("Control+s");
  await page.getByText(/^Saved .*Z, revision \d+$/).waitFor();

  // Aboard, and started in two steps.
  await choose("Vessel", "otter-1");
  await to("Take control");
  await press("Enter");
  await page.getByText("You have control of this vessel.").waitFor();
  await to("Upload", "Shift+Tab");
  await press("Enter");
  await page.getByText(/Same digest ashore and aboard otter-1: [0-9a-f]{8}/).waitFor();
  await to("Start by keys …");
  await press("Enter");
  await page.getByText(/Digest: [0-9a-f]{32}/).waitFor();
  await to("Start by keys");
  await press("Enter");
  await page.locator('.commands > li[data-order="plan.start"]').first().getByText(/effect seen/).waitFor();

  // The vessel's page: from the list by its link, through the tabs, a field to the plots, and STOP.
  await to("Fleet", "Shift+Tab");
  await follow(/:\d+\/$/);
  await to("Open otter-1");
  await follow(/\/vessels\/\d+/);
  await page.locator('[data-tile="plan"]').getByText("by keys").waitFor();
  await to("Plots");
  for (const tab of ["Values", "Entities", "Log book", "Tags", "Link loss", "Parameters", "Control", "Plots"]) {
    await press("ArrowRight");
    await page.getByRole("tabpanel", { name: tab }).waitFor();
  }
  await to("Add a field");
  await press("Enter");
  await page.keyboard.type("estimatedstate psi");
  await press("Enter");
  await page.getByRole("region", { name: "EstimatedState, °", exact: true }).waitFor();
  await press("Control+.");
  await page.getByText(/STOP otter-1: (effect seen|it stopped) after \d/).waitFor();
});
