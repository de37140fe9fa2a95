// Plans and a vessel's page by keyboard alone: node keyboard.mjs URL PASSWORD OTTER. keyboard-past, -control and -admin do the rest.

import { inBrowser } from "./browser.mjs";
import { atKeyboard } from "./keys.mjs";

const [url, password, otter] = process.argv.slice(2);

await inBrowser(async (open) => {
  const page = await open();
  const { press, to, type, choose, follow, logIn } = atKeyboard(page);
  await logIn(url, "admin", password);
  const { fix } = (await (await page.request.get(`${url}/api/v1/vessels`)).json()).find((one) => one.name === otter);

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
  await choose("Vessel", otter);
  await to("Take control");
  await press("Enter");
  await page.getByText("You have control of this vessel.").waitFor();
  await to("Upload", "Shift+Tab");
  await press("Enter");
  await page.getByText(new RegExp(`Same digest ashore and aboard ${otter}: [0-9a-f]{8}`)).waitFor();
  await to("Start by keys …");
  await press("Enter");
  await page.getByText(/Digest: [0-9a-f]{32}/).waitFor();
  await to("Start by keys");
  await press("Enter");
  await page.locator('.commands > li[data-order="plan.start"]').first().getByText(/done/).waitFor();

  // The vessel's page: from the list by its link, through the tabs, a field to the plots, and STOP.
  await to("Fleet", "Shift+Tab");
  await follow(/:\d+\/$/);
  await to(`Open ${otter}`);
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
  await page.getByText(new RegExp(`STOP ${otter}: stopped after \\d`)).waitFor();
});
