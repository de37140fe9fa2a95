// What is taken away is what is shown, value by value, also of more than fits a page: node taken.mjs URL PASSWORD FROM TO.
// The history from FROM to TO (µs) is a test's: 10500 entries of the log book, 5200 tags, 40 places.

import { readFile } from "node:fs/promises";
import { check, inBrowser, logIn, look, same, table } from "./browser.mjs";

const [url, password, fromText, toText] = process.argv.slice(2);
const [FROM, TO] = [Number(fromText), Number(toText)];
const BOAT = 2068;

await inBrowser(async (open) => {
  const page = await open();
  await logIn(page, url, "admin", password, "nine grey otters");
  // Nothing is heard: the first page tells how a vessel comes in.
  await page.goto(url);
  const first = page.getByRole("region", { name: "Vessels" });
  await first.getByText("No system has been heard yet.").waitFor();
  for (const line of [`URL = ${url.replace("http", "ws")}/link`, 'listen = "0.0.0.0:6001"', 'connect = ["10.77.0.10:7001"]', "[Transports.TCP.Server]"]) await first.getByText(line).waitFor();
  await look(page, "first-steps");
  const csrf = await page.evaluate(() => document.querySelector('meta[name="csrf"]').content);
  const named = await page.request.post(`${url}/admin/vessel`, { form: { csrf, name: "otter-0", address: String(BOAT) }, headers: { origin: url } });
  check(named.ok(), await named.text());
  const address = (tab, from = FROM, to = TO) => `${url}/vessels/${BOAT}?from=${from}&to=${to}&tab=${encodeURIComponent(tab)}&plots=EstimatedState.1.u,EstimatedState.1.true_lat_deg,EstimatedState.1.true_lon_deg`;
  // Named by selectors: to look through fifty thousand cells for a role takes seconds, each time. That roles and names are
  // right is every-page's and the keyboard's matter.
  const panel = (name) => page.locator(`.tabpanel:has([role="region"][aria-label="${name === "Tags" ? "Tags heard" : name}"])`);
  const older = (name) => panel(name).locator("button.older", { hasText: "Older ones" });
  const csv = (what) => page.locator(`[aria-label^="Download CSV of ${what}"]`);
  const take = async (button) => {
    const saved = page.waitForEvent("download");
    await button.click();
    const download = await saved;
    return { name: download.suggestedFilename(), ...table(await readFile(await download.path(), "utf8")) };
  };
  /** The texts of all rows. */
  const shown = (name) => panel(name).locator("tbody").evaluate((body) => [...body.rows].map((row) => [...row.cells].map((cell) => cell.textContent)));
  const rows = (name, count) => page.waitForFunction(([id, count]) => document.getElementById(id).querySelectorAll("tbody tr").length === count, [name, count]);
  const id = (name) => panel(name).getAttribute("id");

  // The log book: the newest first, older ones by a button, and all of the time in the file.
  await page.goto(address("Log book"));
  const book = await id("Log book");
  const [newest] = [panel("Log book").locator("tbody tr").first()];
  await newest.getByText(/^entry 10498 /).waitFor();
  await panel("Log book").getByText(/^The newest 2000 of this time, since 2026-11-21 \d\d:\d\d:\d\dZ\.$/).waitFor();
  await rows(book, 1_600);
  const stays = await newest.elementHandle();
  await older("Log book").focus();
  await page.keyboard.press("Enter");
  await panel("Log book").getByText(/^The newest 4000 of this time/).waitFor();
  check(await stays.evaluate((row) => row.isConnected), "a row that stays is not rebuilt: it may have the focus");
  await rows(book, 3_200);
  const button = csv("log book");
  const all = await take(button);
  same(all.head, ["vessel", "time [UTC]", "severity", "entity", "from", "text"], "the head");
  check(all.name === "otter-0_2026-11-21_080000Z_to_2026-11-21_105500Z_log_book.csv", all.name);
  same(all.rows.length, 8_400, "all of the time but debugging, which is not shown");
  const told = ([vessel, time, severity, entity, from, text]) => [vessel, `${time.slice(0, 19).replace("T", " ")}Z`, severity, from || entity, text];
  const seen = (await shown("Log book")).map(([time, severity, from, text]) => ["otter-0", time, severity.split(" ")[1], from, text]);
  same(all.rows.slice(0, seen.length).map(told), seen, "the newest, as they are shown");
  // Two are of one time.
  same(all.rows.slice(-2).find((row) => row[5].startsWith("entry 0 ")), ["otter-0", "2026-11-21T08:00:00.000000Z", "info", "Navigation", "", "entry 0 =1+1, \"quoted\""], "the oldest");
  await panel("Log book").locator("select").selectOption("errors and worse");
  const bad = await take(button);
  check(bad.rows.length === 4_200 && bad.rows.every((row) => ["error", "critical"].includes(row[2])), `${bad.rows.length} errors and worse`);

  // Tags: the map says that it has not all of them.
  await page.goto(address("Tags"));
  const tags = await id("Tags");
  await rows(tags, 5_000);
  await page.locator(".map-box").getByText(/^Tags on the map: the newest 5000, since 2026-11-21 08:03:20Z\. For older ones, see Tags\.$/).waitFor();
  const heard = await take(csv("tags heard"));
  same(heard.rows.length, 5_200, "all tags of the time");
  await older("Tags").click();
  await rows(tags, 5_200);
  check(!(await page.locator(".map-box .tags-cut").isVisible()), "all of them are on the map");
  check(!(await older("Tags").isVisible()), "there are no older ones");
  const lines = await shown("Tags");
  same(lines.length, heard.rows.length, "tags");
  // The file is the server's: the oldest first.
  const cells = heard.rows.toReversed();
  const of = (name) => {
    const at = heard.head.findIndex((one) => one.split(" ")[0] === name);
    check(at >= 0, `${name} in ${heard.head}`);
    return at;
  };
  const columns = ["tag", "sensor_value", "snr", "frequency", "receiver"].map(of);
  const [when, lat, lon] = ["heard_utc", "latitude", "longitude"].map(of);
  lines.forEach(([time, ...rest], at) => {
    const row = cells[at];
    same([time, ...rest.slice(0, 5)], [`${row[when].slice(0, 19).replace("T", " ")}Z`, ...columns.map((one) => row[one])], `tag ${at}`);
    isAt(rest[5], Number(row[lat]), Number(row[lon]));
  });

  // Plots and the track: each sample under the pointer, with its value, its time and the place of the vessel then.
  await page.goto(address("Plots", FROM, FROM + 120_000_000));
  const plot = (unit) => page.getByRole("region", { name: `EstimatedState, ${unit}`, exact: true });
  await plot("m/s").getByText(/40 points/).waitFor();
  const u = await take(plot("m/s").getByRole("link", { name: /Download CSV of EstimatedState u/ }));
  const places = await take(plot("°").getByRole("link", { name: /Download CSV of EstimatedState true_lat_deg, true_lon_deg/ }));
  const column = ({ head }, name) => head.findIndex((one) => one.split(" ")[0] === name);
  check(u.head[column(u, "u")] === "u [m/s]" && places.head[column(places, "true_lat_deg")] === "true_lat_deg [deg]", `${u.head} and ${places.head} tell units`);
  same([u.rows.length, places.rows.length], [40, 40], "samples");
  const over = plot("m/s").locator(".u-over");
  await over.scrollIntoViewIfNeeded();
  const { width } = await over.boundingBox();
  const legend = plot("m/s").locator(".legend .num");
  for (const [at, row] of u.rows.entries()) {
    const us = Math.round(Number(row[column(u, "unix_s")]) * 1e6);
    same(row[0], places.rows[at][0], "both files tell of the same time");
    const value = `${Number(Number(row[column(u, "u")]).toFixed(3))} m/s`.replace("-", "−");
    await over.hover({ position: { x: ((us - FROM) / 120e6) * width, y: 40 } });
    await legend.getByText(value, { exact: true }).waitFor();
    await page.waitForFunction((us) => Math.abs(Date.parse(document.querySelector(".here").textContent.slice(0, 20).replace(" ", "T")) * 1e3 - us) < 2e6, us);
    isAt((await page.locator(".here").textContent()).slice(20).trim(), Number(places.rows[at][column(places, "true_lat_deg")]), Number(places.rows[at][column(places, "true_lon_deg")]), 0.0002);
  }

  // While another time is being asked for, and where it does not come, there is no file of the time before under its name.
  await page.goto(address("Log book", TO - 60_000_000));
  await panel("Log book").getByText("entry 10498").waitFor();
  await button.waitFor();
  let letGo = () => undefined;
  const held = new Promise((done) => (letGo = done));
  await page.route("**/logbook?*", async (route) => {
    await held;
    await route.abort();
  });
  await page.getByRole("button", { name: "Earlier" }).click();
  await panel("Log book").getByText("Fetching …").waitFor();
  check(!(await button.isVisible()), "no file while another time is asked for");
  const kept = await panel("Log book").locator("tbody tr").count();
  check(kept > 0 && kept < 40, `${kept} rows are of both times`);
  letGo();
  await panel("Log book").getByText("Not known: The server cannot be reached.").waitFor();
  check(!(await button.isVisible()), "no file of what did not come");
  await page.unroute("**/logbook?*");
  await page.getByRole("button", { name: "Later" }).click();
  await panel("Log book").getByText("entry 10498").waitFor();
  await button.waitFor();
  same((await take(button)).rows.length, 48, "entries of the last minute but debugging");
});

/** Whether a place as it is shown is this one. */
function isAt(text, lat, lon, within = 0.00001) {
  const found = [...text.matchAll(/(\d+)° (\d+\.\d+)′ ([NSEW])/g)].map(([, degrees, minutes, side]) => (Number(degrees) + Number(minutes) / 60) * (/[SW]/.test(side) ? -1 : 1));
  check(found.length === 2 && Math.abs(found[0] - lat) <= within && Math.abs(found[1] - lon) <= within, `${text} is ${lat} ${lon}`);
}
