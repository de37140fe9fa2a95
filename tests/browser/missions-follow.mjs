// Missions follow what others do: node missions-follow.mjs URL ONE-TIME-PASSWORD FROM TO. Prints nothing.

import { check, inBrowser, logIn, look, same } from "./browser.mjs";

const [url, oneTime, from] = process.argv.slice(2);
const BOAT = 2068;

await inBrowser(async (open) => {
  const page = await open();
  await page.clock.install();
  await logIn(page, url, "admin", oneTime, "nine grey otters");
  await page.goto(`${url}/missions`);
  await page.getByText("No missions yet. Press New mission").waitFor();
  const csrf = await page.evaluate(() => document.querySelector('meta[name="csrf"]').content);
  const headers = { "x-csrf-token": csrf, origin: url };
  const mission = (name) => ({ name, people: "", purpose: "", notes: "", vessels: [BOAT], from_us: Number(from), to_us: null });

  // Somebody else begins a mission: it comes by itself, also while a new one is typed here.
  await page.getByRole("button", { name: "New mission" }).click();
  const name = page.getByRole("form", { name: "New mission" }).getByLabel("Name");
  await name.fill("half a name");
  const made = await page.request.post(`${url}/api/v1/missions`, { headers, data: mission("By somebody else") });
  check(made.ok(), await made.text());
  const { id, revision } = await made.json();
  await page.clock.fastForward(21_000);
  const row = (text) => page.getByRole("row").filter({ hasText: text });
  await row("By somebody else").waitFor();
  same(await name.inputValue(), "half a name", "what is being typed stays");
  await look(page, "missions-follow");

  // It is renamed, then withdrawn.
  const renamed = await page.request.patch(`${url}/api/v1/missions/${id}`, { headers, data: { revision, mission: mission("Renamed") } });
  check(renamed.ok(), await renamed.text());
  await page.clock.fastForward(21_000);
  await row("Renamed").waitFor();
  const gone = await page.request.delete(`${url}/api/v1/missions/${id}`, { headers });
  check(gone.ok(), await gone.text());
  await page.clock.fastForward(21_000);
  await row("Renamed").waitFor({ state: "detached" });
});
