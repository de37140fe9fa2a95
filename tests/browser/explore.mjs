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
  await page.getByText(/^(About )?5,200 rows, (about )?[\d.]+ [kM]B\.$/).waitFor();
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

  // Drag over the plot of tags, then over that of hours: the address follows. Escape undoes a drag under way, and the last choice;
  // the button undoes any.
  const bars = page.getByRole("region", { name: /^Detections (per|by)/ });
  const drag = async (region, from, to, let_go = true) => {
    const svg = region.locator("svg");
    await svg.scrollIntoViewIfNeeded();
    const { x, y, width } = await svg.boundingBox();
    await page.mouse.move(x + width * from, y + 20);
    await page.mouse.down();
    await page.mouse.move(x + width * to, y + 30, { steps: 4 });
    await region.locator("svg rect.brush").waitFor();
    if (let_go) await page.mouse.up();
  };
  const whole = page.getByText("5,200 detections.", { exact: true });
  const span = () => ["from", "to"].map((name) => new URL(page.url()).searchParams.get(name));
  await drag(plot, 0.4, 0.7, false);
  await page.keyboard.press("Escape");
  await page.mouse.up();
  same([await page.locator("svg rect.brush").count(), new URL(page.url()).search], [0, ""], "a drag that Escape ended");
  await drag(plot, 0.4, 0.7);
  await page.waitForURL(/from=.*to=/);
  await whole.waitFor({ state: "detached" });
  const some = page.getByText(/^[1-4],?\d\d\d detections\.$/);
  await some.waitFor();
  const [first, second] = span();
  check(first < second && (await page.getByLabel("From (UTC)", { exact: true }).inputValue()).startsWith(first.slice(0, 16)), `${first} to ${second}`);
  await look(page, "explorer-drawn");
  await page.reload();
  await some.waitFor();
  await page.locator("h1").click();
  await page.keyboard.press("Escape");
  await whole.waitFor();
  same(span(), [null, null], "the time after Escape");
  // Escape that closes the list of alarms or the menu undoes nothing; the next one undoes the last of two drags, not both.
  await drag(plot, 0.3, 0.8);
  await page.waitForURL(/from=.*to=/);
  await whole.waitFor({ state: "detached" });
  await some.waitFor();
  const outer = span();
  await drag(plot, 0.4, 0.7);
  await page.waitForFunction((from) => new URL(location.href).searchParams.get("from") !== from, outer[0]);
  await some.waitFor();
  await page.locator(".alarm-bar button.open").click();
  await page.locator("#alarm-list").waitFor();
  await page.keyboard.press("Escape");
  await page.locator("#alarm-list").waitFor({ state: "hidden" });
  await page.setViewportSize({ width: 390, height: 844 });
  await page.locator("#menu-button").click();
  await page.locator("#menu-button[aria-expanded=true]").waitFor();
  await page.keyboard.press("Escape");
  await page.locator("#menu-button[aria-expanded=false]").waitFor();
  await page.setViewportSize({ width: 1440, height: 900 });
  await page.keyboard.press("Escape");
  await page.waitForFunction((from) => new URL(location.href).searchParams.get("from") === from, outer[0]);
  same(span(), outer, "the time of the drag before");
  await page.keyboard.press("Escape");
  await whole.waitFor();
  await drag(bars, 0.2, 0.95);
  await page.waitForURL(/from=.*to=/);
  await page.getByRole("button", { name: "Back to the question before" }).press("Enter");
  await whole.waitFor();
  same([span(), await page.getByLabel("From (UTC)", { exact: true }).inputValue()], [[null, null], ""], "the time after the way back");
  // Where it was not drawn, Escape undoes nothing.
  await page.keyboard.press("Escape");
  same(new URL(page.url()).pathname, "/explore", "the page");

  // A server without room for a question is asked again, as it says when: numbers, then how large the file will be.
  let busy = 0;
  for (const path of [/detections\/summary/, /detections\/size/]) {
    let times = 0;
    await page.route(path, async (route) => {
      if (times++ > 0) return route.continue();
      busy += 1;
      return route.fulfill({ status: 503, headers: { "retry-after": "1" }, json: { error: { code: "busy", text: "Ask again in a moment." } } });
    });
  }
  await page.reload();
  await page.getByText("The server counts for others; it is asked again in a moment …").waitFor();
  await whole.waitFor();
  await page.getByText(/5,200 rows, /).waitFor();
  same(busy, 2, "questions that were refused");
  for (const path of [/detections\/summary/, /detections\/size/]) await page.unroute(path);

  // Near a cut nothing is called whole, and what lies outside the axis is named with the way to see it.
  await page.route(/detections\/summary/, async (route) => {
    const answer = await (await route.fetch()).json();
    const more = new URL(route.request().url()).searchParams.has("whole_axis") ? {} : { outside: 2, listened_outside_s: 5_400, left_out_before_us: 1_795_248_000_000_000, confirmed_from_us: 1_795_334_400_000_000 };
    return route.fulfill({ json: { ...answer, ...more } });
  });
  await page.reload();
  await page.getByText("At least 5,200 detections.", { exact: true }).waitFor();
  await page.getByText(/^How large it will be is not known: /).waitFor();
  await page.getByText(/2 detections lie outside the plots: .* 2 h of listening lie outside/).waitFor();
  await look(page, "explorer-cut");
  const cut = table((await take(plot, "CSV")).bytes.toString());
  check(cut.rows.every((row) => row[cut.head.indexOf("unconfirmed")] === ""), "what nothing confirms is not known within a day of the cut");
  await page.getByRole("link", { name: "Show all times" }).press("Enter");
  await page.waitForURL(/axis=whole/);
  await whole.waitFor();
  await page.unroute(/detections\/summary/);
  await page.goto(`${url}/explore`);
  await whole.waitFor();

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
  await page.getByText(/^(About )?1,30[01] rows, (about )?[\d.]+ kB\.$/).waitFor();
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
  const drawn = await take(page.getByRole("region", { name: "Where" }), "SVG");
  const dots = (drawn.bytes.toString().match(/<circle /g) ?? []).length;
  // The sea has its colour in both: a corner of the picture is not transparent.
  const corner = await page.evaluate(async (bytes) => {
    const image = await createImageBitmap(new Blob([new Uint8Array(bytes)]));
    const pen = new OffscreenCanvas(1, 1).getContext("2d");
    pen.drawImage(image, 0, 0);
    return pen.getImageData(0, 0, 1, 1).data[3];
  }, [...seen.bytes]);
  same(corner, 255, "how opaque the picture is");
  check(drawn.name === "detections-by-place.svg" && /<image href="data:image\/png;base64,/.test(drawn.bytes.toString()) && dots > 5, `${drawn.name}: ${dots} dots`);

  // On a phone the plots fit, and nothing scrolls sideways.
  await page.setViewportSize({ width: 390, height: 844 });
  await page.waitForFunction(() => [...document.querySelectorAll(".explore-plot")].every((svg) => svg.viewBox.baseVal.width < 390));
  await fits(page, "the explorer on a phone");
  check((await page.locator(".explore-plot .axis text").count()) >= 6, "times below the plots");
  await page.setViewportSize({ width: 1440, height: 900 });

  // What is wrong is said where it stands; nothing found is said with a remedy.
  await page.getByRole("textbox", { name: "Tags" }).fill("fish");
  await page.getByRole("button", { name: "Show", exact: true }).click();
  await page.locator("#tags-wrong").getByText(/is not a tag|like S256-101/).waitFor();
  await page.goto(`${url}/explore?tag=999`);
  await page.getByText("No tag was heard here in this time.").waitFor();
  await look(page, "explorer-empty");
});
