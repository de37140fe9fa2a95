// Control that somebody left by closing the page: node lease-left.mjs URL ONE-TIME-PASSWORD. Prints how far the clock goes on.

import { BUSY, inBrowser, later, logIn } from "./browser.mjs";

const [url, oneTime] = process.argv.slice(2);
const BOAT = 2068;

await inBrowser(async (open) => {
  const watcher = await open();
  await logIn(watcher, url, "admin", oneTime, "nine grey otters");
  const leaver = await watcher.context().newPage();
  const who = (page, text) => page.locator(".control-box .who").getByText(text);
  for (const page of [watcher, leaver]) {
    await page.goto(`${url}/vessels/${BOAT}?tab=Control`);
    await page.getByText("Live", { exact: true }).waitFor();
  }
  await leaver.getByRole("button", { name: "Take control", exact: true }).click();
  await who(leaver, "You have control of this vessel.").waitFor();
  await who(watcher, /has control|in another window/).first().waitFor();
  // Who goes from page to page keeps it: each page renews it at once, and not only after its first ten seconds.
  for (const path of ["/plans", "/"]) {
    const renewed = leaver.waitForResponse((answer) => answer.url().includes("/lease") && answer.request().postData()?.includes("renew") === true, { timeout: 6_000 * BUSY });
    await leaver.goto(`${url}${path}`);
    await renewed;
  }
  await leaver.close();
  // Nobody keeps it, and the other window of the same person is not the one that had it.
  await later(who(watcher, "Nobody has control of this vessel. Last: expired (admin)."), 10);
});
