// Tags that all vessels heard: node detections.mjs URL ONE-TIME-PASSWORD. Prints what the boat hears.

import { readFile } from "node:fs/promises";
import { check, inBrowser, logIn, look, same, table } from "./browser.mjs";

const [url, oneTime] = process.argv.slice(2);

await inBrowser(async (open) => {
  const page = await open();
  await logIn(page, url, "admin", oneTime, "battery horse staple");
  await page.getByRole("link", { name: "Detections" }).click();
  await page.getByText("No tag was heard in this time. Choose a longer time, or clear the tag filter.").waitFor();
  await page.getByText("Live", { exact: true }).waitFor();

  // They come by themselves, each once, in table, legend and times.
  const region = page.getByRole("region", { name: "Detections" });
  const row = (tag) => region.getByRole("row", { name: new RegExp(tag) });
  const asked = [];
  page.on("request", (request) => request.url().includes("/detections?") && asked.push(request.url()));
  for (const [number, how, tag] of [[101, "brief", "R64K-101"], [102, "whole", "R64K-102"], [103, "nameless", "OPi-103"]]) {
    console.log(`hear ${number} ${how}`);
    await row(tag).waitFor();
  }
  same(asked, [], "questions");
  same(await region.locator("tbody tr").count(), 3, "rows");
  await row("OPi-103").getByText("(reported)").waitFor();
  await page.getByRole("img", { name: /^R64K-102: 1 time,/ }).waitFor();

  // What is left out in the legend is left out of the table, and comes back.
  await page.getByRole("checkbox", { name: /R64K-101/ }).uncheck();
  await row("R64K-101").waitFor({ state: "detached" });
  await page.getByRole("checkbox", { name: /R64K-101/ }).check();
  await row("R64K-101").waitFor();

  // A filter is answered by the history, and the file has exactly what it shows.
  const path = `${url}/api/v1/detections?from_us=0&to_us=4000000000000000`;
  const recorded = async () => (await (await page.request.get(path)).json()).detections.length;
  for (let times = 0; (await recorded()) < 3; times++) {
    check(times < 100, "they are recorded");
    await page.waitForTimeout(100);
  }
  await page.getByRole("textbox", { name: "Tags" }).fill("R64K-102 OPi-103");
  await page.getByRole("button", { name: "Show", exact: true }).click();
  await row("R64K-101").waitFor({ state: "detached" });
  same(await region.locator("tbody tr").count(), 2, "rows of the filter");
  const saved = page.waitForEvent("download");
  await page.getByRole("link", { name: "Download all detections" }).click();
  const { head, rows } = table(await readFile(await (await saved).path(), "utf8"));
  const cell = (one, name) => one[head.findIndex((column) => column === name || column.startsWith(`${name} `))];
  same(rows.map((one) => cell(one, "tag")).sort(), ["OPi-103", "R64K-102"], "tags of the file");
  const whole = rows.find((one) => cell(one, "tag") === "R64K-102");
  check(/^\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{3}Z$/.test(cell(whole, "heard_utc")), `heard at ${cell(whole, "heard_utc")}`);
  same([cell(rows.find((one) => cell(one, "tag") === "OPi-103"), "heard_utc")], [""], "a clock that is not set tells no time");

  // What cannot be is said where it stands.
  await page.getByLabel("From (UTC)", { exact: true }).fill("2026-11-22T10:00");
  await page.getByLabel("To (UTC)", { exact: true }).fill("2026-11-21T10:00");
  await page.getByText("The end is not after the beginning.").waitFor();
  await page.getByRole("button", { name: "All", exact: true }).click();
  await row("R64K-102").waitFor();

  // A question that nobody answers does not say that there are none.
  await page.route(/\/api\/v1\/detections\?/, (route) => route.abort());
  await page.getByRole("textbox", { name: "Tags" }).fill("R64K-101");
  await page.getByRole("button", { name: "Show", exact: true }).click();
  await page.getByText("The server cannot be reached.", { exact: true }).waitFor();
  await page.getByText(/^Below are the \d detections of the filter before\.$/).waitFor();
  check((await page.getByText("No tag was heard").count()) === 0, "nothing is known of this filter");
  await page.unroute(/\/api\/v1\/detections\?/);
  await page.getByRole("button", { name: "Show", exact: true }).click();
  await page.getByText("1 detection.", { exact: true }).waitFor();
  await look(page, "detections");

  // On a phone all that is known of a detection stands in its lines, and nothing beside the window.
  await page.setViewportSize({ width: 390, height: 844 });
  await row("R64K-101").scrollIntoViewIfNeeded();
  const beside = await region.evaluate((node) => node.scrollWidth - node.clientWidth);
  check(beside <= 0, `${beside} px of the detections are beside the window`);
});
