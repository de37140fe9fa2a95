// The first page on a moving fleet: node fleet.mjs URL ONE-TIME-PASSWORD. Prints "stop the server" when it wants that.

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
  const place = systems.getByRole("button", { name: "otter-0" }).locator(".place");
  const before = await place.innerText();
  check(/^63° \d\d\.\d{3}′ N 010° \d\d\.\d{3}′ E$/.test(before), before);
  await page.waitForFunction(([node, before]) => node.textContent !== before, [await place.elementHandle(), before]);

  // A card tells what the vessel does, how fast it goes, where to and how old that is; it has the colour of the map.
  const card = systems.getByRole("button", { name: "otter-0" });
  for (const [what, told] of [["Speed", /^2\.9 kn$/], ["Heading", /^\d{3}° T$/], ["Battery", /^not reported$/], ["Position age", /^\d\.\d s$/]]) {
    const fact = card.locator(".fact", { hasText: what }).locator(".num");
    check(told.test(await fact.innerText()), `${what}: ${await fact.innerText()}`);
  }
  await card.getByText("State not reported").waitFor();
  await card.getByText(/^heard \d\.\d s ago/).waitFor();
  const edge = await page.locator(".vessel-card", { hasText: "otter-1" }).evaluate((node) => [getComputedStyle(node).borderLeftColor, getComputedStyle(node).getPropertyValue(`--series-${(2069 % 4) + 1}`)]);
  const [red, green, blue] = edge[1].match(/[0-9a-f]{2}/gi).map((part) => Number.parseInt(part, 16));
  check(edge[0] === `rgb(${red}, ${green}, ${blue})`, `${edge}`);
  // What is old is struck and hatched, and nothing else is.
  const silent = systems.getByRole("button", { name: "otter-2" });
  for (const [of, old] of [[silent, true], [card, false]]) {
    if (old) await of.locator(".place[data-old]").waitFor();
    const looks = await of.locator(".place").evaluate((node) => [getComputedStyle(node).textDecorationLine, getComputedStyle(node).backgroundImage]);
    check(looks[0].includes("line-through") === old && looks[1].includes("gradient") === old, `${looks}`);
  }
  check((await page.locator("table, #export").count()) === 0, "no table and no form on the landing page");

  // Choosing a system by keys puts its STOP into the bar; its values are on its page. Text from a vessel stays text.
  await systems.getByRole("button", { name: "otter-1" }).press("Enter");
  check((await systems.getByRole("button", { name: "otter-1" }).getAttribute("aria-pressed")) === "true", "chosen");
  await page.locator("#stop .aim").getByText("STOP otter-1", { exact: true }).waitFor();
  await page.getByRole("link", { name: "Open otter-1" }).click();
  await page.getByRole("tab", { name: "Values" }).click();
  const panel = page.getByRole("tabpanel", { name: "Values" });
  const values = panel.getByRole("table");
  await values.getByRole("row", { name: /Voltage <b>Battery<\/b> value/ }).waitFor();
  await values.getByRole("row", { name: /onerror=alert/ }).waitFor();
  check((await values.getByRole("row", { name: /EstimatedState Navigation psi/ }).innerText()).includes("°"), "angles are in degrees");
  check((await values.getByRole("row", { name: /Voltage.*Spare/ }).innerText()).includes("no number"), "NaN is not a number");
  await panel.getByLabel("Filter").fill("voltage");
  await values.getByRole("row", { name: /EstimatedState/ }).first().waitFor({ state: "detached" });
  await page.goto(`${url}/vessels/2070?tab=Values`);
  await panel.locator("tr.stale").first().waitFor();
  await page.goto(url);
  await page.getByText("Live", { exact: true }).waitFor();
  await systems.getByRole("button", { name: "otter-0" }).waitFor();

  // The map is drawn: pixels differ where a vessel is, and a click on it chooses it.
  await page.getByRole("button", { name: "Show all" }).click();
  await look(page, "fleet");
  const canvas = page.locator(".map > .ol-viewport canvas").first();
  const colours = await canvas.evaluate((canvas) => {
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    const seen = new Set();
    for (let at = 0; at < data.length; at += 4) if (data[at + 3]) seen.add((data[at] << 16) | (data[at + 1] << 8) | data[at + 2]);
    return seen.size;
  });
  check(colours > 20, `the map shows ${colours} colours`);

  // The history of a message as CSV holds each sample once.
  const [from, to] = [new Date(Date.now() - 3_600_000).toISOString(), new Date().toISOString()];
  const series = (await (await page.request.get(`${url}/api/v1/series?system=2068`)).json()).find((one) => one.message === "EstimatedState");
  const ask = async (fields, range) => (await page.request.get(`${url}/api/v1/vessels/2068/samples?message=EstimatedState&entity=${series.entity}&fields=${fields}&limit=10000&${range}`)).json();
  // The file is asked for once all of its time is on the disk: once something later is.
  while (!(await ask("psi", `from_us=${Date.parse(to) * 1e3}&to_us=${Date.parse(to) * 1e3 + 60e6}`)).rows.length) await page.waitForTimeout(100);
  const csv = await (await page.request.get(`${url}/api/v1/export.csv?message=EstimatedState&vessel=2068&angles=rad&from=${from}&to=${to}`)).text();
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
