// The log book: node logbook.mjs URL ONE-TIME-PASSWORD FROM TO. Prints nothing. The history of one vessel begins at FROM (µs
// since 1970 UTC). Notes are written by keyboard and on a phone, found, corrected and withdrawn.

import { readFile } from "node:fs/promises";
import { check, fits, inBrowser, logIn, look, same, table } from "./browser.mjs";

const [url, oneTime, from] = process.argv.slice(2);
const BOAT = 2068;
/** A photo of one pixel. */
const PNG = Buffer.from("iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNk+M9QDwADhgGAWjR9awAAAABJRU5ErkJggg==", "base64");

await inBrowser(async (open) => {
  const page = await open();
  await logIn(page, url, "admin", oneTime, "battery horse staple");
  const csrf = await page.evaluate(() => document.querySelector('meta[name="csrf"]').content);
  await page.request.post(`${url}/admin/vessel`, { form: { csrf, name: "otter-0", address: String(BOAT) }, headers: { origin: url } });
  await page.getByRole("link", { name: "Log book", exact: true }).click();

  // The empty state says what to do; a note is written by keyboard alone.
  await page.getByText("The log book is empty. Write the first note above").waitFor();
  await look(page, "logbook-empty");
  const form = page.getByRole("form", { name: "Write a note" });
  const text = form.getByLabel("Text");
  await text.focus();
  await page.keyboard.press("Tab");
  check(await form.getByLabel("About vessel").evaluate((node) => node === document.activeElement), "from field to field");
  await form.getByRole("button", { name: "Write", exact: true }).press("Enter");
  await form.getByText("Write something.").waitFor();
  check(await text.evaluate((node) => node === document.activeElement && node.getAttribute("aria-invalid") === "true"), "the wrong field has the focus and says so");
  await page.keyboard.type("Swell from west, wind 8 m/s");
  await form.getByLabel("Latitude, °").fill("63,44");
  await form.getByRole("button", { name: "Write", exact: true }).press("Enter");
  await form.getByText("Give the longitude too.").waitFor();
  await look(page, "logbook-wrong");
  await form.getByLabel("Longitude, °").fill("10.4");
  await form.getByLabel("About vessel").selectOption("otter-0");
  await form.getByLabel("Time (UTC), empty for now", { exact: true }).fill("2026-06-01T12:00:05");
  await form.getByLabel("Photo (JPEG, PNG or WebP)").setInputFiles({ name: "net.png", mimeType: "image/png", buffer: PNG });
  await form.getByRole("button", { name: "Write", exact: true }).press("Enter");

  const day = page.getByRole("region", { name: "2026-06-01" });
  const first = day.getByRole("listitem");
  await first.getByText("Swell from west, wind 8 m/s").waitFor();
  await first.getByText("63° 26.400′ N 010° 24.000′ E").waitFor();
  await first.getByText("12:00:05Z").waitFor();
  same(await text.inputValue(), "", "the form is empty again");
  const photo = first.getByRole("img", { name: /^Photo of the note/ });
  await photo.scrollIntoViewIfNeeded();
  await page.waitForFunction(() => document.querySelector(".note-entry img")?.naturalWidth === 1);
  await page.evaluate(() => scrollTo(0, 0));
  await look(page, "logbook");

  // What is no photo is refused, and the note is kept.
  await text.fill("Second note");
  await form.getByLabel("Photo (JPEG, PNG or WebP)").setInputFiles({ name: "x.png", mimeType: "image/png", buffer: Buffer.from("no photo") });
  await form.getByRole("button", { name: "Write", exact: true }).click();
  await page.getByText("The note is kept, its photo is not: not a JPEG, PNG or WebP file").waitFor();
  await page.getByText("2 notes.").waitFor();

  // A photo that came too late is added to the note, which is not corrected by that.
  const second = page.getByRole("listitem").filter({ hasText: "Second note" });
  await second.getByRole("button", { name: /^Correct the note/ }).click();
  await page.getByRole("form", { name: /^Correct the note/ }).getByLabel("Photo (JPEG, PNG or WebP)").setInputFiles({ name: "net.png", mimeType: "image/png", buffer: PNG });
  await page.getByRole("form", { name: /^Correct the note/ }).getByRole("button", { name: "Save" }).press("Enter");
  await second.getByRole("img", { name: /^Photo of the note/ }).waitFor();
  same(await second.getByText(/^Corrected by/).count(), 0, "nothing was corrected");

  // Corrected: what it said before is a press away.
  await first.getByRole("button", { name: /^Correct the note/ }).click();
  const correction = page.getByRole("form", { name: /^Correct the note/ });
  await correction.getByLabel("Text").fill("Swell from west, wind 10 m/s");
  await correction.getByRole("button", { name: "Save" }).press("Enter");
  await first.getByText("Swell from west, wind 10 m/s").waitFor();
  await first.getByText(/^Corrected by admin/).click();
  await first.getByText("Swell from west, wind 8 m/s").waitFor();
  // Where the page is scrolled by a little, its bar covers a part of what lies under it.
  await page.evaluate(() => scrollTo(0, 0));
  await look(page, "logbook-corrected");

  // Found by words, and by its address; taken away as a file.
  await page.getByLabel("Text contains").fill("SWELL");
  await page.getByText("1 note.", { exact: true }).waitFor();
  await page.waitForURL(/\/logbook\?text=SWELL$/);
  await page.reload();
  await page.getByText("1 note.", { exact: true }).waitFor();
  const saved = page.waitForEvent("download");
  await page.getByRole("link", { name: /^Download CSV/ }).click();
  const { head, rows } = table(await readFile(await (await saved).path(), "utf8"));
  same(rows.length, 1, "rows");
  same([rows[0][0], rows[0][1], rows[0][head.indexOf("latitude [deg]")], rows[0][4]], ["2026-06-01T12:00:05.000000Z", "otter-0", "63.44000000", "Swell from west, wind 10 m/s"], "the row");
  await page.getByLabel("Text contains").fill("nowhere");
  await page.getByText("No matching notes. Choose a longer time, or clear the filter.").waitFor();
  await page.getByLabel("Text contains").fill("");

  // Withdrawn in two steps, and still to be read.
  await page.getByText("2 notes.").waitFor();
  await first.getByRole("button", { name: /^Withdraw the note/ }).click();
  await page.keyboard.press("Enter");
  await page.getByText("1 note.", { exact: true }).waitFor();
  await page.getByLabel("Show withdrawn").check();
  await first.getByText(/^Withdrawn by admin/).waitFor();
  same(await first.getByRole("button", { name: /^Correct/ }).count(), 0, "what is withdrawn is not corrected");

  // What others write comes by itself, also while somebody types; the clock of that window is moved.
  const beside = await page.context().newPage();
  await beside.clock.install();
  await beside.goto(`${url}/logbook`);
  await beside.getByText("1 note.", { exact: true }).waitFor();
  const typed = beside.getByRole("form", { name: "Write a note" }).getByRole("textbox").first();
  await typed.fill("half a note");
  const other = await page.request.post(`${url}/api/v1/logbook`, { headers: { "x-csrf-token": csrf, origin: url }, data: { text: "By somebody else", vessel: null, time_us: null, lat_deg: null, lon_deg: null } });
  check(other.ok(), await other.text());
  await beside.clock.fastForward(21_000);
  await beside.getByRole("listitem").filter({ hasText: "By somebody else" }).waitFor();
  same(await typed.inputValue(), "half a note", "what is being typed stays");
  await beside.close();

  // On a phone, from an address that fills the form.
  await page.setViewportSize({ width: 390, height: 844 });
  await page.goto(`${url}/logbook?write=1&about=${BOAT}&at=1780315200000000&lat=63.44&lon=10.4`);
  same(await form.getByLabel("About vessel").inputValue(), String(BOAT), "vessel");
  same(await form.getByLabel("Time (UTC), empty for now", { exact: true }).inputValue(), "2026-06-01 12:00:00", "time");
  same(await form.getByLabel("Latitude, °").inputValue(), "63.44", "place");
  check(await text.evaluate((node) => node === document.activeElement), "to be written at once");
  await page.keyboard.type("From the phone");
  await fits(page, "the form on a phone");
  await form.getByRole("button", { name: "Write", exact: true }).click();
  await page.getByText("From the phone").waitFor();
  await fits(page, "notes on a phone");
  await page.getByRole("listitem").filter({ hasText: "From the phone" }).getByRole("link", { name: "Watch" }).click();
  await page.waitForURL(/\/vessels\/2068\?.*from=\d+&to=\d+/);

  // Among the entries of the vessel's own log book, at its time; from there a note is written with vessel, time and place.
  await page.setViewportSize({ width: 1440, height: 900 });
  const book = page.getByRole("tabpanel", { name: "Log book" });
  const row = book.getByRole("row", { name: /note by admin From the phone/ });
  await row.waitFor();
  same(await row.locator("td").nth(1).textContent(), "✎ note", "told from the vessel's own");
  await page.goto(`${url}/vessels/${BOAT}?tab=Log%20book&from=${Number(from)}&to=${Number(from) + 120_000_000}&t=${Number(from) + 60_000_000}`);
  await page.locator(".replaybar .badge").getByText("REPLAY", { exact: true }).waitFor();
  await page.waitForFunction(() => /63°/.test(document.querySelector(".here").textContent));
  await book.getByRole("link", { name: "Write a note" }).press("Enter");
  await page.waitForURL(/\/logbook\?write=1/);
  same(await form.getByLabel("About vessel").inputValue(), String(BOAT), "its vessel");
  same(await form.getByLabel("Time (UTC), empty for now", { exact: true }).inputValue(), new Date(Number(from) / 1_000 + 60_000).toISOString().slice(0, 19).replace("T", " "), "the time that was looked at");
  check(/^63\.44\d+$/.test(await form.getByLabel("Latitude, °").inputValue()), `the place then: ${await form.getByLabel("Latitude, °").inputValue()}`);
});
