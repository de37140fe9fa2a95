// Data to be taken away: node data.mjs URL ONE-TIME-PASSWORD. Prints nothing. The history has one vessel without a name from
// people: 40 states, one every 3 s, and 5,200 tags.

import { readFile } from "node:fs/promises";
import { check, inBrowser, logIn, look, same, table } from "./browser.mjs";

const [url, oneTime] = process.argv.slice(2);

await inBrowser(async (open) => {
  const page = await open();
  await logIn(page, url, "admin", oneTime, "battery horse staple");
  await page.getByRole("link", { name: "Data", exact: true }).click();
  const take = async () => {
    const saved = page.waitForEvent("download");
    await page.getByRole("link", { name: "Download", exact: true }).click();
    const file = await saved;
    return { name: file.suggestedFilename(), text: await readFile(await file.path(), "utf8") };
  };
  const told = (text) => page.getByRole("status").getByText(text).waitFor();

  // One row for the day, with the vessel's own name as nobody gave it another; choosing it fills the form.
  const days = page.getByRole("region", { name: "Recorded days" });
  const day = days.locator("tbody tr");
  await days.getByRole("rowheader").waitFor();
  same(await day.count(), 1, "days");
  await day.getByRole("button", { name: "Choose" }).click();
  const vessel = page.getByLabel("Vessel", { exact: true });
  check((await vessel.inputValue()) !== "" && (await vessel.locator("option").count()) === 2, "a vessel that is known from its data alone is in the list");
  check(/^\d{4}-\d\d-\d\d \d\d:\d\d:\d\d$/.test(await page.getByLabel("From (UTC)", { exact: true }).inputValue()), "the span of the day");
  check(await page.locator("#download").evaluate((node) => node === document.activeElement), "the next press downloads");

  // Positions: where the vessel was, not its reference point; as many rows as were told.
  await told(/^40 rows, about [456]\.\d kB\.$/);
  const positions = table((await take()).text);
  same(positions.rows.length, 40, "rows");
  same(positions.head.slice(8, 11), ["true_lat_deg [deg]", "true_lon_deg [deg]", "psi [deg]"], "columns");
  check(Math.abs(Number(positions.rows[0][8]) - 63.44) < 0.001, positions.rows[0]);
  await page.getByLabel("Sampling interval, seconds").fill("6");
  await told(/^2[01] rows/);
  const fewer = table((await take()).text);
  check(fewer.rows.length === 20 || fewer.rows.length === 21, `${fewer.rows.length} rows`);

  // What is wrong is said at its field, with the remedy, and nothing is fetched.
  await page.getByLabel("Sampling interval, seconds").fill("never");
  await page.getByText("From 0.001 to 86400 seconds.").waitFor();
  await page.getByRole("button", { name: "Download", exact: true, disabled: true }).waitFor();
  await page.getByLabel("Sampling interval, seconds").fill("");
  await page.getByRole("radio", { name: /^Messages of one kind/ }).check();
  const message = page.getByRole("combobox", { name: "Message" });
  await message.fill("EstimatedStat");
  await page.locator("#message-wrong").getByText(/IMC has no message `EstimatedStat`; did you mean `EstimatedState`/).waitFor();
  check((await message.getAttribute("aria-invalid")) === "true", "and the field says so");
  await look(page, "data-wrong");
  await message.fill("TBRFishTag");
  await told(/^5,200 rows/);
  const tags = table((await take()).text);
  same(tags.rows.length, 5_200, "tags");
  check(/^heard$/.test(tags.head[8]) && /^\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.250Z$/.test(tags.rows[0][8]), `the receiver's time: ${tags.head[8]} ${tags.rows[0][8]}`);
  // The same with types: whole from its first mark to its last.
  await page.getByLabel("File format").selectOption({ label: "Parquet: pandas, R, DuckDB" });
  await told(/^5,200 rows\.$/);
  check((await page.getByLabel("Compress with gzip").count()) === 0, "it is packed within");
  const typed = await take();
  check(typed.name === "TBRFishTag.parquet" && typed.text.startsWith("PAR1") && typed.text.endsWith("PAR1"), typed.name);
  await page.getByLabel("File format").selectOption({ label: "CSV" });
  await page.getByLabel("From (UTC)", { exact: true }).fill("2026-11-22T10:00:00");
  await page.getByLabel("To (UTC)", { exact: true }).fill("2026-11-21T10:00:00");
  await page.getByText("The end is not after the beginning.").waitFor();
  // A time is typed as it stands everywhere, whatever the browser's locale; what is none is told at its field, once it is left.
  const begin = page.getByLabel("From (UTC)", { exact: true });
  await begin.fill("11/22/2026 10:00 AM");
  await begin.press("Tab");
  await page.locator("#span-from-wrong").getByText("Not a valid time. Write it like 2026-06-01 12:00, in UTC.").waitFor();
  check((await begin.getAttribute("aria-invalid")) === "true" && (await page.locator("#download").isDisabled()), "and nothing is asked for");
  await begin.fill("2026-02-30 10:00");
  await begin.press("Tab");
  await page.locator("#span-from-wrong").getByText("Not a valid time").waitFor();
  for (const field of ["From (UTC)", "To (UTC)"]) check((await page.getByRole("button", { name: `Choose in a calendar: ${field}`, exact: true }).count()) === 1, `a calendar stays within reach of ${field}`);

  // Often wanted spans; where nothing is, that is said before anybody waits for a file.
  await page.getByRole("button", { name: "Last hour" }).click();
  await told("No rows in this time: the file will have its header only.");
  await page.getByRole("button", { name: "All", exact: true }).click();
  await page.getByRole("radio", { name: /^Detections/ }).check();
  const detections = table((await take()).text);
  same(detections.rows.length, 5_200, "detections");
  await page.getByRole("radio", { name: /^Everything, as a log/ }).check();
  await told(/^At most [\d.]+ [kM]B\.$/);
  const log = await take();
  same(log.name, "lutra.lsf", "a log");
  await look(page, "data");

  // The day is watched where it was.
  await day.getByRole("link", { name: "Watch" }).click();
  await page.waitForURL(/\/vessels\/\d+\?.*from=\d+&to=\d+/);
});
