// What the demo has beside Otters that sail: node demo.mjs URL PASSWORD PAST. PAST is the address of a replay. Prints
// "until yesterday is in" and goes on; the caller waits there.

import { PATIENCE_MS, check, inBrowser, logIn, look } from "./browser.mjs";

const [url, password, past] = process.argv.slice(2);
const CUT = 10450;

await inBrowser(async (open) => {
  const page = await open();
  await logIn(page, url, "admin", password);

  // The link that is cut: its panel, the alarm on every page; then the link is back, and so is what was missed.
  await page.goto(`${url}/vessels/${CUT}?tab=Link+loss`);
  const panel = page.locator(".linkloss");
  await panel.getByText("Link up.").waitFor();
  await panel.getByText("Link lost.").waitFor({ timeout: 2 * PATIENCE_MS });
  const lost = Date.now();
  await page.locator("#alarms").getByText(/otter-2/).first().waitFor();
  await page.locator('[data-tile="speed_mps"][data-old]').waitFor();
  await look(page, "demo-link-cut");
  await panel.getByText("Link up.").waitFor({ timeout: 2 * PATIENCE_MS });
  const [from, to] = [(lost - 5_000) * 1e3, (lost + 5_000) * 1e3];
  const series = await (await page.request.get(`${url}/api/v1/series?system=${CUT}`)).json();
  const { entity } = series.find((one) => one.message === "EstimatedState");
  for (;;) {
    const asked = `message=EstimatedState&entity=${entity}&fields=u&limit=1000&from_us=${from}&to_us=${to}`;
    const { rows } = await (await page.request.get(`${url}/api/v1/vessels/${CUT}/samples?${asked}`)).json();
    if (rows.length >= 10) break;
    await page.waitForTimeout(200);
  }
  await page.goto(`${url}/vessels/${CUT}?span=120`);
  await page.getByRole("region", { name: "EstimatedState, m/s", exact: true }).waitFor();
  await look(page, "demo-link-back");

  // What they sail is ashore too, each for its vessel.
  await page.goto(`${url}/plans`);
  for (const [name, vessel] of [["rows", "otter-2"], ["square", "otter-1"]]) {
    await page.getByRole("row", { name: new RegExp(`${name}.*${vessel}`) }).waitFor();
  }
  await look(page, "demo-plans");

  // Transports and storage of a server that works.
  await page.goto(`${url}/admin/connections`);
  await page.getByRole("region", { name: "Links of vessels" }).getByRole("row", { name: /otter-2 ● up/ }).waitFor();
  await page.getByRole("region", { name: "Open connections" }).getByRole("row", { name: /link of .* otter-1/ }).waitFor();
  await look(page, "demo-transports");
  await page.goto(`${url}/admin/storage`);
  await page.getByRole("region", { name: "By vessel" }).getByRole("row", { name: /otter-1 .*iB 1 20/ }).waitFor();
  await page.getByLabel(/^Days of the archive/).fill("2100-01-01");
  await page.getByRole("button", { name: "Show what would be removed" }).click();
  await page.getByText(/ prune --archive-before 2100-01-01 --yes/).waitFor();
  await look(page, "demo-storage");

  // Yesterday's mission is replayed, with the tags that were heard.
  console.log("until yesterday is in");
  await page.goto(`${past}&tab=Tags`);
  await page.locator(".replaybar .badge").getByText("REPLAY", { exact: true }).waitFor();
  await page.getByRole("row", { name: /S256-10\d/ }).first().waitFor();
  await page.locator('[data-tile="plan"]').getByText("rows").waitFor();
  check(new URL(page.url()).searchParams.get("speed") === "10", page.url());
  await page.getByRole("button", { name: "Play", exact: true }).click();
  await page.getByRole("button", { name: "Pause", exact: true }).click();
  await look(page, "demo-yesterday");
});
