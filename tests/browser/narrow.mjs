// Small screens: node narrow.mjs URL ONE-TIME-PASSWORD. One line above with STOP in it, nothing cut off, the map in the first
// screen, and all that has no room opens from the menu.

import { check, fits, inBrowser, logIn, look } from "./browser.mjs";

const [url, oneTime] = process.argv.slice(2);
const BOAT = 2068;
const SIZES = [{ width: 390, height: 844 }, { width: 1024, height: 768 }];

/** Texts that are cut off, of those that have one line. */
const cut = (page) =>
  page.evaluate(() =>
    [...document.querySelectorAll(".tile dt, .tile .reading, .fact > *, .system .doing > *, .system .name, #stop .halt, .vessel-head > *")]
      .filter((node) => node.checkVisibility() && getComputedStyle(node).fontSize !== "0px")
      .filter((node) => {
        const box = node.getBoundingClientRect();
        const clip = node.closest("dd, .tile, .fact, .system, .vessel-head, .bar").getBoundingClientRect();
        return node.scrollWidth > node.clientWidth + 1 && getComputedStyle(node).display !== "inline" || box.right > clip.right + 1 || box.left < clip.left - 1;
      })
      .map((node) => `${node.className}: ${node.textContent}`),
  );
/** How much of an element is in the first screen. */
const share = (page, selector) =>
  page.locator(selector).first().evaluate((node) => {
    const { top, bottom, height } = node.getBoundingClientRect();
    return (Math.min(bottom, innerHeight) - Math.max(top, 0)) / height;
  });

await inBrowser(async (open) => {
  const page = await open({ hasTouch: true });
  await logIn(page, url, "admin", oneTime, "nine grey otters");
  const csrf = await page.evaluate(() => document.querySelector('meta[name="csrf"]').content);
  for (const [name, address] of [["otter-0", BOAT], ["otter-9", 0x0900]]) await page.request.post(`${url}/admin/vessel`, { form: { csrf, name, address: String(address) }, headers: { origin: url } });

  for (const size of SIZES) {
    await page.setViewportSize(size);
    for (const path of ["/", `/vessels/${BOAT}?tab=Control`]) {
      const where = `${path} at ${size.width} px`;
      await page.goto(url + path);
      await page.locator('body[data-link="up"]').waitFor();
      await page.locator(path === "/" ? ".system" : '[data-tile="mode"]:not([data-old])').first().waitFor();
      await page.getByText("Executing maneuver").first().waitFor();
      await fits(page, where);
      const clipped = await cut(page);
      check(!clipped.length, `${where}: cut off: ${clipped.join("; ")}`);
      check((await page.locator(".bar").boundingBox()).height < 64, `${where}: the bar is one line`);
      check((await share(page, "#stop .halt")) === 1, `${where}: STOP is in the first screen`);
      check((await share(page, ".map")) > 0.7, `${where}: ${await share(page, ".map")} of the map is in the first screen`);
      const small = await page.locator(".bar button, .bar summary, .alarm-bar button, .vessel-head button, .vessel-card a").evaluateAll((all) => all.filter((one) => one.checkVisibility()).map((one) => [one.textContent, one.getBoundingClientRect()]).filter(([, box]) => box.height < 44 || box.width < 44).map(([text, box]) => `${text} ${box.width} x ${box.height}`));
      check(!small.length, `${where}: too small for a thumb: ${small}`);
      // The time bar is where time is chosen.
      if (path !== "/") check(!(await page.locator(".timebar").isVisible()), `${where}: no time bar on Control`);
    }
    // The page of a vessel is open. Longitudes stand between the words at the map's lower edge and its scales.
    const { credit, figures, scale } = await page.evaluate(() => {
      const above = (selector, edge) => document.querySelector(".map").getBoundingClientRect().bottom - document.querySelector(selector).getBoundingClientRect()[edge];
      return { credit: document.querySelector(".chart-credit").checkVisibility() ? above(".chart-credit", "top") : 0, figures: [40, 56], scale: above(".ol-scale-line", "bottom") };
    });
    check(credit <= figures[0] && scale >= figures[1], `${size.width} px: longitudes under ${credit} px of words or under the scale ${scale} px above the edge`);
    const lines = new Set(await page.getByRole("tab").evaluateAll((all) => all.map((one) => one.getBoundingClientRect().top)));
    check(size.width < 1024 || lines.size === 1, `tabs on ${lines.size} lines at ${size.width} px`);
    if (size.width === 390) check((await page.locator(".tiles").first().evaluate((node) => getComputedStyle(node).gridTemplateColumns.split(" ").length)) === 2, "two columns of tiles");
  }

  // What a table or a line says beside its window nobody finds: ages of the link take several lines, plans are cards.
  await page.setViewportSize(SIZES[0]);
  await page.goto(`${url}/vessels/${BOAT}?tab=${encodeURIComponent("Link loss")}`);
  await page.locator(".linkloss").getByText(/Last message/).waitFor();
  const beside = (selector) => page.locator(selector).first().evaluate((node) => node.scrollWidth - node.clientWidth);
  check((await beside(".tabpanel:not([hidden])")) <= 0, "ages of the link are not cut off");
  const one = { name: "a plan of the narrow kind", description: "", vessel: null, repeat: false, maneuvers: [] };
  await page.request.post(`${url}/api/v1/plans`, { headers: { "x-csrf-token": csrf }, data: one });
  await page.goto(`${url}/plans`);
  await page.getByRole("link", { name: one.name }).waitFor();
  check((await beside(".wide")) <= 0, "all that is said of a plan is in its card");
  for (const path of ["/account", "/admin/connections", "/admin/storage"]) {
    await page.goto(url + path);
    await page.locator('body[data-link="up"]').waitFor();
    const cutOff = await page.locator(".wide").evaluateAll((all) => all.filter((one) => one.scrollWidth > one.clientWidth).map((one) => one.getAttribute("aria-label")));
    check(!cutOff.length, `${path}: tables are cut off: ${cutOff.join(", ")}`);
  }
  await page.goto(`${url}/vessels/${BOAT}?tab=Control`);
  await page.locator('[data-tile="mode"]:not([data-old])').waitFor();

  // The menu holds pages, palette and account; Escape closes it and gives the focus back.
  await page.setViewportSize(SIZES[0]);
  const menu = page.getByRole("button", { name: "Menu" });
  check(!(await page.getByRole("link", { name: "Plans" }).isVisible()), "folded");
  await menu.press("Enter");
  check((await menu.getAttribute("aria-expanded")) === "true", "it says that it is open");
  for (const name of ["Fleet", "Plans", "Admin", "admin"]) await page.getByRole("link", { name, exact: true }).waitFor();
  for (const name of ["Day", "Dusk", "Night", "Log out"]) await page.getByRole("button", { name, exact: true }).waitFor();
  await fits(page, "the menu");
  await page.keyboard.press("Escape");
  check(!(await page.getByRole("link", { name: "Plans" }).isVisible()) && (await menu.evaluate((node) => node === document.activeElement)), "closed, and the focus is back");

  // Further instruments are behind More, and the browser keeps whether they are wanted.
  const voltage = page.locator('[data-tile="voltage"]');
  check(!(await voltage.isVisible()), "behind More");
  await page.getByRole("button", { name: "More instruments" }).click();
  await voltage.waitFor();
  await page.reload();
  await voltage.waitFor();
  const clipped = await cut(page);
  check(!clipped.length, `with more instruments: cut off: ${clipped.join("; ")}`);
  await page.setViewportSize({ width: 1440, height: 900 });
  await look(page, "vessel-more");
});
