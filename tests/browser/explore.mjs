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
  same([png.name, png.bytes.subarray(1, 4).toString(), png.bytes.readUInt32BE(16)], ["tags-by-time.png", "PNG", 2_400], "the picture");
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

  // An area by keyboard, around nothing, then none.
  await page.getByRole("button", { name: "Draw an area" }).press("Enter");
  const map = page.locator(".explore-map .map");
  for (const key of ["ArrowRight", "ArrowDown", "ArrowLeft"]) {
    await page.getByRole("button", { name: "Corner in the middle of the map" }).press("Enter");
    await map.focus();
    for (let times = 0; times < 3; times++) await page.keyboard.press(key);
    await page.waitForTimeout(400);
  }
  await page.getByText("Click the corners on the map, in order: 3 so far.").waitFor();
  await page.getByRole("button", { name: "Use this area" }).press("Enter");
  await page.waitForURL(/area=/);
  await page.getByText("How long was listened within an area is not known.").or(page.getByText("No tag was heard here")).first().waitFor();
  await page.getByRole("button", { name: "Remove the area" }).press("Enter");
  await page.getByText("5,200 detections.", { exact: true }).waitFor();

  // What is wrong is said where it stands; nothing found is said with a remedy.
  await page.getByRole("textbox", { name: "Tags" }).fill("fish");
  await page.getByRole("button", { name: "Show", exact: true }).click();
  await page.locator("#tags-wrong").getByText(/is no tag|like S256-101/).waitFor();
  await page.goto(`${url}/explore?tag=999`);
  await page.getByText("No tag was heard here in this time.").waitFor();
  await look(page, "explorer-empty");
});
