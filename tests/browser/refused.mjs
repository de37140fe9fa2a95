// Where an order was refused: node refused.mjs URL ONE-TIME-PASSWORD. A boat lies in deep water of the archipelago. The server
// refuses what leads off the chart; the boat refuses all else with a sentence of its own. Prints nothing.

import { check, inBrowser, logIn, look, same } from "./browser.mjs";

const [url, oneTime] = process.argv.slice(2);
const BOAT = 2068;
/** Nothing is charted there, land is on the way, and no route leads there. */
const BEYOND = ["63.6", "10.7"];
const DEEP = ["63.4465", "10.3500"];

await inBrowser(async (open) => {
  const page = await open();
  await logIn(page, url, "admin", oneTime, "nine grey otters");
  const asked = [];
  page.on("request", (request) => asked.push(new URL(request.url()).pathname));
  const where = page.locator(".control .guard");
  const goTo = async (words, [lat, lon]) => {
    await page.getByLabel(words.lat).fill(lat);
    await page.getByLabel(words.lon).fill(lon);
    const go = page.getByRole("button", { name: words.there });
    await page.waitForFunction((button) => !button.disabled, await go.elementHandle());
    await go.click();
    await page.getByRole("button", { name: words.go, exact: true }).click();
  };
  /** What the map has in its middle is where the mark is, to some metres. */
  const leads = async (button, [lat, lon]) => {
    await button.click();
    const map = await page.locator(".map").boundingBox();
    await page.mouse.move(map.x + map.width / 2 + 1, map.y + map.height / 2);
    await page.mouse.move(map.x + map.width / 2, map.y + map.height / 2);
    const told = await page.locator(".ol-mouse-position").innerText();
    const [north, east] = [...told.matchAll(/(\d+)° (\d+\.\d+)′/g)].map(([, whole, minutes]) => Number(whole) + Number(minutes) / 60);
    check(Math.abs(north - lat) < 1e-3 && Math.abs(east - lon) < 2e-3, `led to ${told} in place of ${lat} ${lon}`);
  };

  const english = { lat: "Latitude, °", lon: "Longitude, °", there: "Go there …", go: "Go" };
  await page.goto(`${url}/vessels/${BOAT}?tab=Control`);
  await page.getByRole("button", { name: "Take control" }).click();
  const answered = page.waitForResponse((response) => response.url().endsWith("/commands") && response.status() === 422);
  await goTo(english, BEYOND);
  const { error } = await (await answered).json();
  const [leg] = error.guard.reasons;
  check(error.code === "grounding" && leg.code === "land" && leg.from && leg.to, JSON.stringify(error));
  await page.getByRole("alert").getByText(/^The chart shows danger: the way to the chosen place crosses land, and 1 more leg$/).waitFor();
  await leads(where.getByRole("button", { name: "the way to the chosen place crosses land", exact: true }).first(), [leg.lat_deg, leg.lon_deg]);
  await where.getByRole("button", { name: "the chosen place has no chart", exact: true }).waitFor();
  await look(page, "refused-by-the-server");
  check(!asked.some((path) => path.endsWith("/plans/check")), "the refusal has the place: nobody asks the guard again");

  // A vessel has a sentence only. Its leg, its reason and its place are shown just so.
  await where.getByRole("button", { name: "Remove the marks" }).click();
  await goTo(english, DEEP);
  const told = where.getByRole("button", { name: "the way to the chosen place is too shallow, 2.5 m" });
  await told.waitFor();
  same(await where.getByRole("button").count(), 2, "the one leg that it named, and the way to remove the mark");
  await leads(told, [63.4475, 10.3488]);
  await look(page, "refused-by-the-vessel");
  check(!asked.some((path) => path.endsWith("/plans/check")), "nor of what a vessel said");

  // The same for who reads Bokmål.
  await page.goto(`${url}/account`);
  await page.getByLabel("Language of the pages").selectOption("Norsk bokmål");
  await page.getByRole("button", { name: "Choose language" }).click();
  await page.getByText("Sidene er på språket som du valgte.").waitFor();
  await page.goto(`${url}/vessels/${BOAT}?tab=Control`);
  const nb = { lat: "Breddegrad, °", lon: "Lengdegrad, °", there: /^Gå dit/, go: "Gå" };
  // Control is the window's: it is kept from page to page.
  await goTo(nb, BEYOND);
  await page.getByRole("alert").getByText(/^Kartet viser fare: veien til det valgte stedet krysser land/).waitFor();
  await look(page, "refused-bokmal");
});
