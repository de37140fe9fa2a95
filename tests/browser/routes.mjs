// Routes on the demonstration's chart: a refused leg is sailed around, a route is drawn and pulled, and a vessel is sent
// behind an island: node routes.mjs URL PASSWORD VESSEL.

import { fileURLToPath } from "node:url";
import { check, fits, inBrowser, logIn, look, until } from "./browser.mjs";

const [url, password, vessel] = process.argv.slice(2);
const ADDRESS = { "otter-1": 10449, "otter-2": 10450, "otter-3": 10451 }[vessel];
/** In deep water on both sides of an island. */
const EAST = [63.4455, 10.352];
const WEST = [63.4455, 10.314];

await inBrowser(async (open) => {
  const page = await open();
  await logIn(page, url, "admin", password);
  const csrf = await page.evaluate(() => document.querySelector('meta[name="csrf"]').content);
  const maneuvers = [EAST, WEST].map(([lat_deg, lon_deg], at) => ({ id: `P${at + 1}`, speed: { value: 1.5, unit: "mps" }, task: { kind: "goto", at: { lat_deg, lon_deg } } }));
  const made = await page.request.post(`${url}/api/v1/plans`, { headers: { "x-csrf-token": csrf }, data: { name: "around", description: "", vessel: null, repeat: false, maneuvers } });
  check(made.ok(), await made.text());
  let asking = 0;
  const ofRoute = (by) => (request) => request.url().endsWith("/chart/route") && (asking += by);
  page.on("request", ofRoute(1));
  for (const end of ["requestfinished", "requestfailed"]) page.on(end, ofRoute(-1));
  await page.goto(`${url}/plans/${(await made.json()).id}`);

  // The refused leg offers a way around; taking it makes the plan safe, and one undo takes it back.
  await page.getByText(/refused by the chart/).waitFor();

  // Brought aboard all the same it is refused, and where is marked, listed, and one click away.
  const { guard } = await (await page.request.post(`${url}/api/v1/plans/check`, { headers: { "x-csrf-token": csrf }, data: { name: "around", description: "", vessel: ADDRESS, repeat: false, maneuvers } })).json();
  const where = page.getByRole("group", { name: "Where it was refused" });
  /** What the map has in its middle, degrees; to a hundredth of a minute, which are some metres. */
  const isLedTo = async (place) => {
    const map = await page.locator(".map").boundingBox();
    await page.mouse.move(map.x + map.width / 2 + 1, map.y + map.height / 2);
    await page.mouse.move(map.x + map.width / 2, map.y + map.height / 2);
    const told = await page.locator(".ol-mouse-position").innerText();
    const [lat, lon] = [...told.matchAll(/(\d+)° (\d+\.\d+)′/g)].map(([, whole, minutes]) => Number(whole) + Number(minutes) / 60);
    check(Math.abs(lat - place.lat_deg) < 2e-4 && Math.abs(lon - place.lon_deg) < 4e-4, `led to ${told} in place of ${place.lat_deg} ${place.lon_deg}`);
  };
  await page.locator(".plan-aboard").getByRole("combobox").selectOption({ label: vessel });
  await page.getByRole("button", { name: "Save", exact: true }).click();
  await page.getByText(/^Saved .*Z, revision \d+; the chart refuses it as it is$/).waitFor();
  await page.getByRole("button", { name: "Upload" }).click();
  await page.getByText(/Not uploaded: The chart shows danger: .* The plan stays here as it is/).first().waitFor();
  await where.getByRole("button", { name: /the way to P2 / }).waitFor();
  await look(page, "refused-upload");
  await where.getByRole("button", { name: /the way to P2 / }).first().click();
  await isLedTo(guard.reasons.find(({ maneuver }) => maneuver === "P2"));
  await where.getByRole("button", { name: "Remove the marks" }).click();
  await where.waitFor({ state: "hidden" });

  await page.getByRole("button", { name: /^Route around: / }).first().click();
  const panel = page.locator(".sea-route");
  await panel.getByRole("heading", { name: "Way around: P2" }).waitFor();
  const text = panel.getByText(/^\d+ m · \d+ min · least depth [\d.]+ m · clear by \d+ m$/);
  await text.waitFor();
  const lengthM = async () => Number.parseInt(await text.innerText(), 10);
  check((await lengthM()) > 2_500, `around the island: ${await text.innerText()}`);
  await look(page, "route-around");
  await fits(page, "the plan page with a route");

  // The other side of the island is longer, stands beside it, and is chosen by a press.
  const ways = panel.getByRole("group", { name: "Routes to choose from" });
  const shortestM = await lengthM();
  await ways.getByRole("radio", { name: /^2: \d+ m longer · / }).check();
  check((await lengthM()) > shortestM, `the second route: ${await text.innerText()} after ${shortestM} m`);
  await look(page, "route-alternatives");
  await ways.getByRole("radio", { name: /^Shortest · / }).check();
  check((await lengthM()) === shortestM, `the shortest again: ${await text.innerText()}`);
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
  // While it was dragged it was asked about at each step: what is looked at is the last answer.
  for (let times = 0; asking > 0; times++) {
    check(times < 600, "the route is answered");
    await page.waitForTimeout(100);
  }
  await look(page, "route-drawn");

  // An area to avoid, drawn by clicks: one whose sides cross is none; the way goes around it until it is taken away.
  const shownM = () => page.evaluate(() => {
    const [, number, unit] = /^([\d.]+) (k?m)/.exec(document.querySelector(".sea-route .totals").textContent) ?? [];
    return Number(number) * (unit === "km" ? 1_000 : 1);
  });
  /** Does something, and gives the length of the way that the server answers to a question like that, as soon as it is shown. */
  const lengthAfter = async (like, act) => {
    const answered = page.waitForResponse((response) => response.url().endsWith("/chart/route") && like(response.request().postDataJSON()));
    await act();
    const { route } = await (await answered).json();
    if (route) await until(async () => Math.abs((await shownM()) - route.length_m) < 60, `${route.length_m} m are shown`);
    else await panel.locator(".note.bad").first().waitFor();
    return route?.length_m;
  };
  const keep = (metres) => async () => {
    await clearance.fill(String(metres));
    await clearance.press("Enter");
  };
  const freeM = await lengthAfter(({ clearance_m }) => clearance_m === 15, keep(15));
  // The least energy goes slower; then the shortest route again.
  const best = panel.getByLabel("Best route");
  await lengthAfter(({ objective }) => objective === "least_energy", () => best.selectOption("least_energy"));
  await panel.getByText(/Wh from the batteries at 0\.\d\d m\/s/).waitFor();
  await lengthAfter(({ objective }) => objective === "shortest", () => best.selectOption("shortest"));

  // A current from a file, read by the server: what is wrong is said at the field, and a good one is asked for until it is taken away.
  const current = panel.getByLabel("Current from a file (CSV, NetCDF) …");
  await current.setInputFiles({ name: "tide.csv", mimeType: "text/csv", buffer: Buffer.from("time,lat,lon,u,v\n") });
  await panel.locator("#sea-route-currents-wrong").getByText("Line 1: there is no column east_mps. Begin the file with time,lat,lon,east_mps,north_mps.").waitFor();
  check((await current.getAttribute("aria-invalid")) === "true", "the field says that it is wrong");
  await look(page, "route-current-refused");
  const netcdf = fileURLToPath(new URL("../../fuzz/seeds/geofile/currents.nc", import.meta.url));
  await lengthAfter(({ current_grid }) => current_grid?.lats_deg.length > 1, () => current.setInputFiles(netcdf));
  await panel.getByText("currents.nc").waitFor();
  check((await panel.locator("#sea-route-currents-wrong").count()) === 0, "nothing is wrong any more");
  await lengthAfter(({ current_grid }) => current_grid === null, () => panel.getByRole("button", { name: "Without this current" }).click());

  // A question that takes long says how far it has come and can be left. It is held back here, and what the server says of it is made up.
  const left = page.waitForEvent("requestfailed", (request) => request.url().endsWith("/chart/route"));
  await page.route("**/api/v1/chart/route", () => {});
  await page.route("**/api/v1/chart/route/*", (held) => held.fulfill({ json: { waiting: false, tiles: 140, most_tiles: 2000, spent_s: 4, most_s: 90 } }));
  await keep(20)();
  await panel.getByText("Searched 140 tiles of the chart, of 2000 at most: 4 s").waitFor();
  await look(page, "route-long");
  await panel.getByRole("button", { name: "Stop planning" }).click();
  await left;
  await panel.getByRole("button", { name: "Stop planning" }).waitFor({ state: "hidden" });
  for (const held of ["**/api/v1/chart/route", "**/api/v1/chart/route/*"]) await page.unroute(held);
  await lengthAfter(({ clearance_m }) => clearance_m === 15, keep(15));
  const onMap = (x, y) => page.mouse.click(box.x + box.width * x, box.y + box.height * y);
  await panel.getByRole("button", { name: "Draw an area" }).click();
  for (const [x, y] of [[0.55, 0.25], [0.7, 0.75], [0.7, 0.25], [0.55, 0.75]]) await onMap(x, y);
  await panel.getByRole("button", { name: "Avoid this area" }).click();
  await panel.getByText("Two sides of the area cross").waitFor();
  for (let corner = 0; corner < 3; corner++) await panel.getByRole("button", { name: "Remove the last corner" }).click();
  for (const [x, y] of [[0.7, 0.25], [0.7, 0.75], [0.55, 0.75]]) await onMap(x, y);
  await panel.getByText(/: 4 so far/).waitFor();
  const aroundM = await lengthAfter(({ zones }) => zones.length === 1, () => panel.getByRole("button", { name: "Avoid this area" }).click());
  check(aroundM === undefined || aroundM >= freeM, `${aroundM} m with the area, ${freeM} m without`);
  await page.waitForFunction(() => document.activeElement?.textContent === "Draw an area");
  await look(page, "route-with-area");
  const againM = await lengthAfter(({ zones }) => zones.length === 0, () => panel.getByRole("button", { name: "Remove area 1" }).click());
  check(Math.abs(againM - freeM) < 1, `${againM} m as before, ${freeM} m`);

  // The same area with a speed limit instead: a limit out of range is refused at its field, a good one is asked for.
  await panel.getByRole("button", { name: "Draw an area", exact: true }).click();
  for (const [x, y] of [[0.7, 0.25], [0.7, 0.75], [0.55, 0.75]]) await onMap(x, y);
  const isLimited = (mps) => ({ zones }) => zones.length === 1 && zones[0].kind === "limit" && zones[0].most_mps === mps;
  await lengthAfter(isLimited(1), () => panel.getByRole("button", { name: "Limit the speed in this area" }).click());
  const limit = panel.getByLabel("Speed limit of area 1 (m/s)");
  await limit.fill("0");
  await limit.press("Tab");
  await panel.getByText("Give a speed of 0.05 to 20 m/s.").waitFor();
  await lengthAfter(isLimited(0.5), async () => {
    await limit.fill("0.5");
    await limit.press("Tab");
  });
  await look(page, "route-with-limit");
  await lengthAfter(({ zones }) => zones.length === 0, () => panel.getByRole("button", { name: "Remove speed limit 1" }).click());
  // More distance is preferred where the water has it.
  const off = panel.getByRole("spinbutton", { name: /Prefer farther off than/ });
  const prefer = (metres) => async () => {
    await off.fill(String(metres));
    await off.press("Enter");
  };
  await lengthAfter(({ prefer_off_m }) => prefer_off_m === 100, prefer(100));
  await lengthAfter(({ prefer_off_m }) => prefer_off_m === null, prefer(0));

  // What cannot be is told, with what would do, one press away.
  if ((await lengthAfter(({ clearance_m }) => clearance_m === 300, keep(300))) === undefined && (await panel.getByRole("button", { name: "Find what would work" }).isVisible())) {
    await panel.getByRole("button", { name: "Find what would work" }).click();
    const offer = panel.getByRole("button", { name: /^Try a clearance of \d+(\.\d)? m$/ });
    await offer.waitFor();
    check((await lengthAfter(({ clearance_m }) => clearance_m < 300, () => offer.click())) > 0, "the offered clearance gives a route");
  }
  await panel.getByRole("button", { name: "Close" }).click();
  check((await panel.count()) === 0, "the panel is gone");

  // Sent behind the island: by the route, confirmed with its length, as a plan that the vessel sails.
  await page.goto(`${url}/vessels/${ADDRESS}?tab=Control`);
  await page.getByRole("button", { name: "Take control" }).click();
  const go = page.getByRole("button", { name: "Go there …" });
  await page.waitForFunction((button) => !button.disabled, await go.elementHandle());
  // A place beyond the chart is refused, and marked where; it is typed as positions are shown.
  await page.getByLabel("Latitude, °").fill("63° 36.000′ N");
  await page.getByLabel("Longitude, °").fill("010° 42.000′ E");
  await go.click();
  await page.getByRole("button", { name: "Go", exact: true }).click();
  await page.getByRole("alert").getByText(/The chart shows danger: /).waitFor();
  await where.getByRole("button", { name: /the chosen place/ }).first().waitFor();
  await look(page, "refused-goto");
  await where.getByRole("button", { name: /the chosen place/ }).first().click();
  check((await where.getByRole("button", { name: /the chosen place/ }).count()) > 0, "it stays in the list");
  await page.getByLabel("Latitude, °").fill("on land");
  await go.click();
  check(await page.getByLabel("Latitude, °").evaluate((node) => node.validationMessage.startsWith("like 63.44 or 63°")), "what is not a place is said at its field");
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
