// The explorer: node explore.mjs URL ONE-TIME-PASSWORD. Prints nothing. The history has 5,200 detections of seven tags.

import { readFile } from "node:fs/promises";
import { check, fits, inBrowser, logIn, look, same, table } from "./browser.mjs";

const [url, oneTime] = process.argv.slice(2);

await inBrowser(async (open) => {
  const page = await open();
  await logIn(page, url, "admin", oneTime, "battery horse staple");
  await page.getByRole("link", { name: "Data", exact: true }).click();
  await page.getByRole("navigation", { name: "Data" }).getByRole("link", { name: "Explorer" }).click();
  await page.getByText("5,200 detections.", { exact: true }).waitFor();
  const plot = page.getByRole("region", { name: "Tags by time" });
  same(await plot.locator("svg g path.doubted").count(), 7, "rows of tags");
  await page.getByText("These vessels did not report when they listened.").waitFor();
  await page.getByText(/^5,200 rows, about [\d.]+ [kM]B\.$/).waitFor();
  await fits(page, "the explorer");
  await look(page, "explorer");

  // Each plot is a picture, a drawing and its numbers.
  const take = async (region, name) => {
    const saved = page.waitForEvent("download");
    await region.getByRole("button", { name, exact: true }).press("Enter");
    const file = await saved;
    return { name: file.suggestedFilename(), bytes: await readFile(await file.path()) };
  };
  const numbers = table((await take(plot, "CSV")).bytes.toString());
  const count = numbers.head.indexOf("detections");
  same(numbers.rows.reduce((sum, row) => sum + Number(row[count]), 0), 5_200, "detections in the numbers");
  const png = await take(plot, "PNG");
  same([png.name, png.bytes.subarray(1, 4).toString(), png.bytes.readUInt32BE(16) >= 2_400], ["tags-by-time.png", "PNG", true], "the picture");
  const svg = (await take(page.getByRole("region", { name: /^Detections per/ }), "SVG")).bytes.toString();
  check(/^<svg[^>]* xmlns=/.test(svg) && /fill="(rgb|#)/.test(svg), svg.slice(0, 200));

  // The question is the address: it is shared, and the way back leads back.
  const tag = numbers.rows[0][numbers.head.indexOf("tag")];
  await page.getByRole("textbox", { name: "Tags" }).fill(tag);
  await page.getByRole("button", { name: "Show", exact: true }).press("Enter");
  const part = page.getByText(/^74[23] detections\.$/);
  await part.waitFor();
  same(new URL(page.url()).searchParams.get("tag"), tag, "the address");
  await page.reload();
  await part.waitFor();
  await page.goBack();
  await page.getByText("5,200 detections.", { exact: true }).waitFor();
  same(await page.getByRole("textbox", { name: "Tags" }).inputValue(), "", "the tag of the question before");

  // While a new question is asked, nothing of the one before is shown; its numbers come with it.
  let go = () => undefined;
  const held = new Promise((resolve) => { go = resolve; });
  await page.route(/detections\/summary\?.*tag=/, async (route) => { await held; await route.continue(); });
  await page.getByRole("textbox", { name: "Tags" }).fill(tag);
  await page.getByRole("button", { name: "Show", exact: true }).press("Enter");
  await page.getByText("Fetching …", { exact: true }).first().waitFor();
  same(await plot.count(), 0, "plots of the question before");
  go();
  await part.waitFor();
  await page.unroute(/detections\/summary\?.*tag=/);
  await page.goBack();
  await page.getByText("5,200 detections.", { exact: true }).waitFor();

  // An area: numbers 0 to 1299 were heard south of 63.441; then drawn by keyboard on the open sea, where none was.
  await page.goto(`${url}/explore?area=${encodeURIComponent("63.439,10.3;63.441,10.3;63.441,10.5;63.439,10.5")}`);
  await page.getByText(/^1,30[01] detections\.$/).waitFor();
  await page.getByText(/^1,30[01] rows, about [\d.]+ kB\.$/).waitFor();
  await page.getByText("How long was listened within an area is not known. Remove the area to see the hours.").waitFor();
  await page.getByRole("button", { name: "Remove the area" }).press("Enter");
  await page.getByText("5,200 detections.", { exact: true }).waitFor();
  await page.getByRole("button", { name: "Draw an area" }).press("Enter");
  const map = page.locator(".explore-map .map");
  const middle = page.locator("[data-middle]");
  const go1 = async (key) => {
    const before = await middle.textContent();
    await map.press(key);
    await page.waitForFunction((text) => document.querySelector("[data-middle]").textContent !== text, before);
  };
  // Away from where tags were heard: the map shows all of them, and a key moves it by 128 of its 420 px.
  for (let times = 0; times < 5; times++) await go1("ArrowDown");
  for (const key of ["ArrowRight", "ArrowDown", "ArrowLeft"]) {
    await page.getByRole("button", { name: "Corner in the middle of the map" }).press("Enter");
    await go1(key);
  }
  await page.getByText("Click the corners on the map, in order: 3 so far.").waitFor();
  await page.getByRole("button", { name: "Use this area" }).press("Enter");
  await page.waitForURL(/area=/);
  await page.getByText("0 detections.", { exact: true }).waitFor();
  await page.getByText("No tag was heard here in this time.").waitFor();
  await page.getByRole("button", { name: "Remove the area" }).press("Enter");
  await page.getByText("5,200 detections.", { exact: true }).waitFor();

  // An area that crosses itself is refused with what to do.
  await page.goto(`${url}/explore?area=${encodeURIComponent("63.4,10.3;63.5,10.5;63.5,10.3;63.4,10.5")}`);
  await page.getByRole("alert").getByText(/cross or touch; give the corners in the order/).waitFor();

  // The list ends a page without having found any: it is looked further, and said so.
  await page.goto(`${url}/explore`);
  await page.getByRole("heading", { name: "200 newest detections." }).waitFor();
  let pages = 0;
  let last = () => undefined;
  const waits = new Promise((resolve) => { last = resolve; });
  await page.route(/api\/v1\/detections\?/, async (route) => {
    if (pages++ === 0) return route.fulfill({ json: { detections: [], next: { from_us: 0, to_us: 1_795_305_600_000_000, skip: 0 } } });
    await waits;
    return route.continue();
  });
  await page.getByRole("button", { name: "Show", exact: true }).press("Enter");
  await page.getByText("Still looking: 0 found, back to 2026-11-22 00:00:00Z so far.").waitFor();
  last();
  await page.getByRole("heading", { name: "200 newest detections." }).waitFor();
  await page.unroute(/api\/v1\/detections\?/);

  // Vessels are chosen from a list, several at once, and stand in the address; the map is a picture.
  await page.getByText("All vessels", { exact: true }).click();
  await page.getByRole("group", { name: "Vessels" }).getByRole("checkbox").first().check();
  await page.getByRole("button", { name: "Show", exact: true }).click();
  await page.waitForURL(/vessel=\d+/);
  await page.getByText("5,200 detections.", { exact: true }).waitFor();
  const seen = await take(page.getByRole("region", { name: "Where" }), "PNG");
  same([seen.name, seen.bytes.subarray(1, 4).toString()], ["detections-by-place.png", "PNG"], "the picture of the map");
  check(seen.bytes.length > 2_000, `${seen.bytes.length} bytes of map`);

  // On a phone the plots fit, and nothing scrolls sideways.
  await page.setViewportSize({ width: 390, height: 844 });
  await page.waitForFunction(() => [...document.querySelectorAll(".explore-plot")].every((svg) => svg.viewBox.baseVal.width < 390));
  await fits(page, "the explorer on a phone");
  check((await page.locator(".explore-plot .axis text").count()) >= 6, "times below the plots");
  await page.setViewportSize({ width: 1440, height: 900 });

  // What is wrong is said where it stands; nothing found is said with a remedy.
  await page.getByRole("textbox", { name: "Tags" }).fill("fish");
  await page.getByRole("button", { name: "Show", exact: true }).click();
  await page.locator("#tags-wrong").getByText(/is no tag|like S256-101/).waitFor();
  await page.goto(`${url}/explore?tag=999`);
  await page.getByText("No tag was heard here in this time.").waitFor();
  await look(page, "explorer-empty");
});
