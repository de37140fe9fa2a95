// The first page on a moving fleet: node fleet.mjs URL ONE-TIME-PASSWORD. Prints "stop the server" when it wants that.

import { readFile } from "node:fs/promises";
import { check, inBrowser, logIn, look, sameSamples, table } from "./browser.mjs";

const [url, oneTime] = process.argv.slice(2);

await inBrowser(async (open) => {
  const page = await open();
  await logIn(page, url, "admin", oneTime, "nine grey otters");
  await page.getByRole("link", { name: "Fleet" }).click();
  await page.getByText("Live", { exact: true }).waitFor();

  // Every system is there, also the one that nobody knows; a stale one says so.
  const systems = page.getByRole("list", { name: "Systems" });
  for (const name of ["otter-0", "otter-1", "otter-2", "unknown 0x0817"]) {
    await systems.getByRole("button", { name }).waitFor();
  }
  // The third said its word once and is silent since.
  await systems.getByRole("button", { name: "otter-2" }).getByText(/stale|lost/).waitFor();
  const place = systems.getByRole("button", { name: "otter-0" }).locator(".num").first();
  const before = await place.innerText();
  check(/^63° \d\d\.\d{3}′ N 010° \d\d\.\d{3}′ E$/.test(before), before);
  await page.waitForFunction(([node, before]) => node.textContent !== before, [await place.elementHandle(), before]);

  // Its latest values are on its page; text from a vessel stays text.
  await systems.getByRole("link", { name: "Open otter-1" }).press("Enter");
  await page.getByRole("tab", { name: "Values" }).click();
  const values = page.getByRole("tabpanel", { name: "Values" }).getByRole("table");
  await values.getByRole("row", { name: /Voltage <b>Battery<\/b> value/ }).waitFor();
  await values.getByRole("row", { name: /onerror=alert/ }).waitFor();
  check((await values.getByRole("row", { name: /EstimatedState Navigation psi/ }).innerText()).includes("°"), "angles are in degrees");
  check((await values.getByRole("row", { name: /Voltage.*Spare/ }).innerText()).includes("no number"), "NaN is no number");
  await page.getByLabel("Filter").fill("voltage");
  await values.getByRole("row", { name: /EstimatedState/ }).first().waitFor({ state: "detached" });
  await page.getByLabel("Filter").fill("");
  await page.goto(`${url}/vessels/2070?tab=Values`);
  await page.getByRole("tabpanel", { name: "Values" }).locator("tr.stale").first().waitFor();
  await page.goto(url);
  await systems.getByRole("button", { name: "otter-2" }).click();

  // The map is drawn: pixels differ where a vessel is, and a click on it chooses it.
  await page.getByRole("button", { name: "Show all" }).click();
  await look(page, "fleet");
  const canvas = page.locator(".map canvas").first();
  const colours = await canvas.evaluate((canvas) => {
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    const seen = new Set();
    for (let at = 0; at < data.length; at += 4) if (data[at + 3]) seen.add((data[at] << 16) | (data[at + 1] << 8) | data[at + 2]);
    return seen.size;
  });
  check(colours > 20, `the map shows ${colours} colours`);

  // CSV of the chosen message and time.
  await page.locator("#messages option").first().waitFor({ state: "attached" });
  const form = page.locator("#export");
  await form.getByLabel("Vessel").selectOption("otter-0");
  await form.getByLabel("Angles").selectOption("radians");
  const from = await form.getByLabel("From").inputValue();
  const to = new Date().toISOString();
  await form.getByLabel("To", { exact: false }).fill(to);
  const series = (await (await page.request.get(`${url}/api/v1/series?system=2068`)).json()).find((one) => one.message === "EstimatedState");
  const ask = async (fields, range) => (await page.request.get(`${url}/api/v1/vessels/2068/samples?message=EstimatedState&entity=${series.entity}&fields=${fields}&limit=10000&${range}`)).json();
  // The file is asked for once all of its time is on the disk: once something later is.
  while (!(await ask("psi", `from_us=${Date.parse(to) * 1e3}&to_us=${Date.parse(to) * 1e3 + 60e6}`)).rows.length) await page.waitForTimeout(100);
  const download = page.waitForEvent("download");
  await page.getByRole("button", { name: "CSV" }).click();
  const csv = await readFile(await (await download).path(), "utf8");
  const { head, rows } = table(csv);
  check(rows.length > 390 && head.slice(0, 3).join() === "time,unix_s,system", `the CSV is whole: ${rows.length} rows`);
  const range = `from_us=${Date.parse(from) * 1e3}&to_us=${Date.parse(to) * 1e3}`;
  for (const field of ["psi", "true_lat_deg"]) {
    sameSamples(csv, await ask(field, range), field);
  }

  // Without the server nothing looks fresh, and it comes back by itself to the login when the session is over.
  const asked = Date.now();
  console.log("stop the server");
  await page.getByText("No link to the server").waitFor();
  console.log(`greyed ${Date.now() - asked} ms after the server was told to stop`);
  check((await page.locator("#fleet").evaluate((node) => getComputedStyle(node).filter)) !== "none", "greyed");
  await systems.getByRole("button", { name: "otter-0" }).getByText("not known").waitFor();
});
