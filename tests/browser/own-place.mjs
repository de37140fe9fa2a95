// The place of the person at this device on the map: node own-place.mjs URL ONE-TIME-PASSWORD.

import { check, inBrowser, logIn, look } from "./browser.mjs";

const [url, oneTime] = process.argv.slice(2);
const BOAT = 2068;

await inBrowser(async (open) => {
  const page = await open({ geolocation: { latitude: 63.44, longitude: 10.4, accuracy: 8 }, permissions: ["geolocation"] });
  const sent = [];
  page.on("request", (request) => sent.push(`${request.url()} ${request.postData() ?? ""}`));
  await logIn(page, url, "admin", oneTime, "battery horse staple");
  await page.goto(`${url}/vessels/${BOAT}`);
  await page.getByText("Live", { exact: true }).waitFor();
  const button = page.getByRole("button", { name: "My position" });
  const told = page.locator(".own-told");

  // Nobody is asked before somebody wants it.
  check((await told.textContent()) === "", "nothing is said before it is wanted");
  await button.click();
  await told.getByText(/^You ±8 m · otter-0 [\d.]+ m .*, \d{3}° T$/).waitFor();
  await look(page, "own-place");
  // It goes on with the next page of this window, and moves.
  await page.goto(url);
  await told.getByText(/^You ±8 m/).waitFor();
  await page.context().setGeolocation({ latitude: 63.45, longitude: 10.4, accuracy: 20 });
  await told.getByText(/^You ±20 m/).waitFor();
  check(!sent.some((one) => /63\.4[45]\d*.*10\.4/.test(one)), "it is sent nowhere");
  await button.click();
  check((await told.textContent()) === "", "and goes when it is not wanted any more");

  // Who does not allow it is told what to do.
  const other = await open();
  await other.context().clearPermissions();
  await logIn(other, url, "admin", "battery horse staple");
  await other.getByRole("button", { name: "My position" }).click();
  await other.locator(".own-told").getByText("This browser may not show your position: allow it in its settings for this site.").waitFor();
  check((await other.getByRole("button", { name: "My position" }).getAttribute("aria-pressed")) === "false", "it is off");
});
