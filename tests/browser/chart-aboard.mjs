// The sea chart that a vessel holds, on its page: node chart-aboard.mjs URL NAME PASSWORD VESSEL.

import { check, inBrowser, logIn, look } from "./browser.mjs";

const [url, name, password, vessel] = process.argv.slice(2);

await inBrowser(async (open) => {
  const page = await open();
  await logIn(page, url, name, password);
  await page.goto(`${url}/vessels/${vessel}`);
  const tile = page.locator('[data-tile="chart"]');
  await page.getByRole("button", { name: "More instruments" }).click();
  await tile.getByText("up to date").waitFor();
  check(/2 charts, the newest XX\dLUTRA/.test(await tile.innerText()), await tile.innerText());
  check((await tile.getAttribute("data-old")) === null, "told over a link that stands");
  await page.locator(".chart-credit").getByText("safety depth 8 m, the vessel's own").waitFor();
  await look(page, "vessel-chart-aboard");
});
