// No-go areas: node nogo.mjs URL ONE-TIME-PASSWORD. A boat lies in deep water of the archipelago. An area is closed on the map;
// then nobody is sent into it; it is lifted, and closed again. Prints nothing.

import { check, inBrowser, logIn, look, same } from "./browser.mjs";

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

  // A corner is dragged, another one pulled out of a side; each is one step back. The corners are there as text, too.
  const drawn = (count) => page.getByText(`Click the corners on the map, in order: ${count} so far.`).waitFor();
  const drag = async (from, to) => {
    const { x, y, width, height } = await map.boundingBox();
    await page.mouse.move(x + width / 2 + from[0], y + height / 2 + from[1]);
    await page.mouse.down();
    for (const part of [0.3, 0.6, 1]) await page.mouse.move(x + width / 2 + from[0] + part * (to[0] - from[0]), y + height / 2 + from[1] + part * (to[1] - from[1]));
    await page.mouse.up();
  };
  await page.getByText("Corners as text").click();
  const text = page.getByLabel("A corner in each line: latitude, longitude");
  const lines = async () => (await text.inputValue()).split("\n");
  const before = await lines();
  await drag([-60, -60], [-90, -80]);
  const dragged = await lines();
  check(dragged.length === 4 && dragged[0] !== before[0], `the first corner is at ${dragged[0]}`);
  same(dragged.slice(1), before.slice(1), "the others stay");
  await drag([0, 60], [0, 90]);
  await drawn(5);
  const undo = page.getByRole("button", { name: "Undo" });
  for (let steps = 0; steps < 2; steps++) await undo.click();
  same(await lines(), before, "as it was");
  // Typed, as it stands in a permit; what is no place is said, and nothing is taken.
  await text.fill(`${before[0]}\n63,4 10,3`);
  await text.press("Tab");
  await page.getByText("Line 2 is not a place").waitFor();
  await drawn(4);
  // And nothing is saved with other corners than the text has: it stays, and stays in sight.
  await save.click();
  await page.getByText("Corners as text").click();
  await page.getByText("Line 2 is not a place").waitFor();
  check((await text.inputValue()).endsWith("63,4 10,3"), `what was typed: ${await text.inputValue()}`);
  check(!(await page.request.get(`${url}/api/v1/no-go-areas`).then((answer) => answer.json())).areas.length, "nothing was closed");
  await text.fill("63°26.79'N 010°20.64'E\n63°26.79'N 010°20.76'E\n63.4471, 10.346");
  await text.press("Tab");
  await drawn(3);
  // What lies half beneath the bar while the page is scrolled is no small target.
  await page.evaluate(() => scrollTo(0, 0));
  await look(page, "nogo-text");
  await undo.click();
  same(await lines(), before, "as it was drawn");
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

  // Renamed while another one changes it, lifted, and closed again by the way back.
  await page.goto(`${url}/no-go-areas`);
  await page.getByRole("button", { name: "Change Salmon farm" }).click();
  await page.getByLabel("Name", { exact: true }).fill("Fish farm");
  const meanwhile = await page.request.patch(`${url}/api/v1/no-go-areas/1`, { headers: { "x-csrf-token": csrf }, data: { revision: 2, area: { ...area, reason: "Nets" }, closed: true } });
  check(meanwhile.ok(), await meanwhile.text());
  await page.getByRole("button", { name: "Save" }).click();
  await page.getByText("admin changed it meanwhile, as the map shows. Save replaces that by what is here.").waitFor();
  check((await page.getByLabel("Name", { exact: true }).inputValue()) === "Fish farm", "what was typed stays");
  await page.getByRole("button", { name: "Save" }).click();
  await page.getByText(/^Changed by admin, 20/).waitFor();
  await page.getByRole("button", { name: "Lift Fish farm" }).click();
  await page.getByText("Fish farm is lifted: vessels may enter it.").waitFor();
  await page.getByText("No areas are closed.").waitFor();
  await page.getByRole("button", { name: "Undo" }).click();
  await page.getByRole("button", { name: "Lift Fish farm" }).waitFor();
  check((await page.getByText("Lifted areas").count()) === 0, "it is closed again");

  // A file is shown before it is taken, and closed as a whole.
  const ring = (east) => [[10.35 + east, 63.44], [10.351 + east, 63.44], [10.351 + east, 63.441], [10.35 + east, 63.44]];
  const feature = (name, east) => ({ type: "Feature", properties: { name }, geometry: { type: "Polygon", coordinates: [ring(east)] } });
  const file = { type: "FeatureCollection", features: [feature("Net north", 0), feature("Net south", 0.002)] };
  const choose = (geo) => page.locator('input[type="file"]').setInputFiles({ name: "nets.geojson", mimeType: "application/geo+json", buffer: Buffer.from(JSON.stringify(geo)) });
  await choose({ type: "FeatureCollection", features: [feature("Net north", 0), { ...feature("half", 0), geometry: { type: "Polygon", coordinates: [ring(0).slice(0, 3)] } }] });
  await page.getByText("Polygon 2: its last corner is not its first").waitFor();
  await choose(file);
  await page.getByText("2 areas to be closed: Net north, Net south").waitFor();
  await page.getByRole("button", { name: "Close these areas" }).click();
  await page.getByRole("heading", { name: "Net south" }).waitFor();
  await page.getByText("2 areas to be closed").waitFor({ state: "hidden" });
  const closed = await (await page.request.get(`${url}/api/v1/no-go-areas`)).json();
  check(closed.in_force && closed.areas.length === 3, JSON.stringify(closed));
});
