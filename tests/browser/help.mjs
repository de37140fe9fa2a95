// Help by `?`, and STOP while it is open: node help.mjs URL ONE-TIME-PASSWORD. Prints what the boat does.

import { SIZES, check, inBrowser, logIn, look, until } from "./browser.mjs";

const [url, oneTime] = process.argv.slice(2);

await inBrowser(async (open) => {
  const page = await open();
  await logIn(page, url, "admin", oneTime, "battery horse staple");
  await page.getByText("Live", { exact: true }).waitFor();
  const help = page.getByRole("dialog", { name: "Help" });
  const term = (name) => help.getByRole("term").getByText(name, { exact: true });
  await page.keyboard.press("?");
  await help.waitFor();
  await term("Chart datum").waitFor();
  check((await help.getByText("In replay: play and pause").count()) === 0, "keys of other pages are not listed");
  await look(page, "help");
  // It is searched, and says where it has nothing.
  const search = help.getByRole("textbox", { name: "Search in help" });
  await search.fill("knots");
  check(!(await term("Chart datum").isVisible()), "what does not match is gone");
  await term("Speed over ground (SOG)").waitFor();
  await search.fill("zeppelin");
  await help.getByText("No matching help topics.").waitFor();
  await page.keyboard.press("Escape");
  await help.waitFor({ state: "hidden" });
  // A field keeps its letters; a press on the button does the same as the key.
  await page.goto(`${url}/detections`);
  await page.getByRole("textbox", { name: "Tags" }).press("?");
  check((await page.getByRole("textbox", { name: "Tags" }).inputValue()) === "?", "typed");
  check(!(await help.isVisible()), "no help in the middle of a word");
  await page.getByRole("button", { name: "Help" }).click();
  await help.waitFor();
  await page.keyboard.press("Escape");
  await help.waitFor({ state: "hidden" });
  await page.getByRole("button", { name: "Help" }).and(page.locator(":focus")).waitFor();

  // STOP is never under it, and works by pointer and by keys while it is open, at a desk and on a phone.
  const halt = page.getByRole("button", { name: "STOP otter-0", exact: true });
  const menu = page.getByRole("button", { name: "Menu", exact: true });
  const stops = page.locator("#orders .order");
  for (const size of SIZES) {
    await page.setViewportSize(size);
    await page.goto(`${url}/vessels/2068`);
    await page.locator('body[data-link="up"]').waitFor();
    await halt.waitFor();
    const where = `at ${size.width} px`;
    if (await menu.isVisible()) await menu.click();
    await page.getByRole("button", { name: "Help" }).click();
    await search.and(page.locator(":focus")).waitFor();
    check((await menu.isHidden()) || (await menu.getAttribute("aria-expanded")) === "false", `${where}: the menu is closed`);
    const [top, box] = [await page.locator("#top").boundingBox(), await help.boundingBox()];
    check(box.y >= top.y + top.height && box.y + box.height <= size.height + 1, `${where}: it lies below what stays at the top: ${JSON.stringify([top, box])}`);
    await page.keyboard.press("Control+.");
    await stops.first().waitFor();
    check(await help.isVisible(), `${where}: it stays open`);
    await until(async () => /accepted, sent|NO EFFECT|stopped/.test(await stops.first().innerText()), `${where}: the STOP by keys is answered`);
    await halt.click();
    await until(async () => (await stops.count()) === 2, `${where}: a STOP by pointer`);
    // The keyboard is led back into it, and out of it to where it came from.
    await page.keyboard.press("?");
    await search.and(page.locator(":focus")).waitFor();
    await page.keyboard.press("Escape");
    await help.waitFor({ state: "hidden" });
    await halt.or(menu).or(page.getByRole("button", { name: "Help" })).and(page.locator(":focus")).first().waitFor();
  }

  // On a page that is about no vessel the list of those to stop opens over it.
  await page.goto(`${url}/data`);
  await page.locator('body[data-link="up"]').waitFor();
  await page.keyboard.press("?");
  await search.and(page.locator(":focus")).waitFor();
  await page.keyboard.press("Control+.");
  await page.locator("#stop details[open]").getByRole("button", { name: "STOP otter-0" }).click();
  await stops.first().waitFor();
  check(await help.isVisible(), "it stays open");
});
