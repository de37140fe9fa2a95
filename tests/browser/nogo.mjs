// No-go areas: node nogo.mjs URL ONE-TIME-PASSWORD. A boat lies in deep water of the archipelago. An area is closed on the map;
// then nobody is sent into it; it is lifted, and closed again. Prints nothing.

import { check, inBrowser, logIn, look } from "./browser.mjs";

const [url, oneTime] = process.argv.slice(2);
const BOAT = 2068;
/** In deep water, a little north of the boat. */
const INSIDE = ["63.4468", "10.3450"];

await inBrowser(async (open) => {
  const page = await open();
  await logIn(page, url, "admin", oneTime, "nine grey otters");
  await page.goto(`${url}/no-go-areas`);
  await page.getByText("No areas are closed.").waitFor();
  await page.getByRole("button", { name: "Close an area", exact: true }).click();

  // What is missing is said at its field; nothing is sent.
  const save = page.getByRole("button", { name: "Close this area" });
  await save.click();
  await page.getByText("An area has three corners or more").waitFor();

  // Corners by clicks, within a map that was brought to the place by the middle of the map.
  const map = page.locator(".map");
  const click = async (right, down) => {
    const { x, y, width, height } = await map.boundingBox();
    await page.mouse.click(x + width / 2 + right, y + height / 2 + down);
    // Two clicks that come soon after each other are one that zooms.
    const count = (corners += 1);
    await page.getByText(`Click the corners on the map, in order: ${count} so far.`).waitFor();
  };
  let corners = 0;
  await page.getByLabel("Name", { exact: true }).fill("Salmon farm");
  await page.getByLabel("Why it is closed").fill("Moorings just below the surface");
  for (const [right, down] of [[-60, -60], [60, -60], [60, 60], [-60, 60]]) await click(right, down);
  await look(page, "nogo-drawing");
  await save.click();
  await page.getByRole("heading", { name: "Salmon farm" }).waitFor();
  await page.getByText(/^Closed by admin, 20/).waitFor();
  // Without a pointer: the middle of the map, which the keyboard moves.
  await page.getByRole("button", { name: "Close an area", exact: true }).click();
  const corner = page.getByRole("button", { name: "Corner in the middle of the map" });
  await corner.press("Enter");
  for (const key of ["ArrowRight", "ArrowDown", "ArrowLeft"]) {
    await map.press(key);
    await corner.press("Enter");
  }
  await page.getByText("Click the corners on the map, in order: 4 so far.").waitFor();
  await page.getByRole("button", { name: "Cancel" }).click();

  // Another operator has it just beside the boat; the page shows what others do.
  const csrf = await page.evaluate(() => document.querySelector('meta[name="csrf"]').content);
  const area = { name: "Salmon farm", reason: "Moorings", corners: [[63.4464, 10.344], [63.4464, 10.346], [63.4472, 10.346], [63.4472, 10.344]] };
  const moved = await page.request.patch(`${url}/api/v1/no-go-areas/1`, { headers: { "x-csrf-token": csrf }, data: { revision: 1, area, closed: true } });
  check(moved.ok(), await moved.text());
  await page.reload();
  await page.getByText(/^Changed by admin, 20/).waitFor();
  await look(page, "nogo-closed");

  // Who sends the boat into it is told that it stops before.
  await page.goto(`${url}/vessels/${BOAT}?tab=Control`);
  await page.getByRole("button", { name: "Take control" }).click();
  await page.getByLabel("Latitude, °").fill(INSIDE[0]);
  await page.getByLabel("Longitude, °").fill(INSIDE[1]);
  const there = page.getByRole("button", { name: "Go there …" });
  await page.waitForFunction((button) => !button.disabled, await there.elementHandle());
  await there.click();
  await page.getByText(/an area to avoid; it was moved by \d+ m/).first().waitFor();
  await look(page, "nogo-moved");
  await page.getByRole("button", { name: "Cancel" }).first().click();

  // A plan through it is refused by its name.
  const goto = (id, lat_deg) => ({ id, speed: { value: 1.5, unit: "mps" }, task: { kind: "goto", at: { lat_deg, lon_deg: 10.345 } } });
  const plan = { name: "through", description: "", vessel: null, repeat: false, maneuvers: [goto("a", 63.446), goto("b", 63.4476)] };
  const verdict = await page.request.post(`${url}/api/v1/plans/check`, { headers: { "x-csrf-token": csrf }, data: plan });
  const [leg] = (await verdict.json()).guard.reasons;
  check(leg?.area === "Salmon farm" && leg.code === "entry-prohibited", await verdict.text());

  // Renamed, lifted, and closed again by the way back.
  await page.goto(`${url}/no-go-areas`);
  await page.getByRole("button", { name: "Change Salmon farm" }).click();
  await page.getByLabel("Name", { exact: true }).fill("Fish farm");
  await page.getByRole("button", { name: "Save" }).click();
  await page.getByText(/^Changed by admin, 20/).waitFor();
  await page.getByRole("button", { name: "Lift Fish farm" }).click();
  await page.getByText("Fish farm is lifted: vessels may enter it.").waitFor();
  await page.getByText("No areas are closed.").waitFor();
  await page.getByRole("button", { name: "Undo" }).click();
  await page.getByRole("button", { name: "Lift Fish farm" }).waitFor();
  check((await page.getByText("Lifted areas").count()) === 0, "it is closed again");
});
