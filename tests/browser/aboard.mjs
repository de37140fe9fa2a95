// A plan that is drawn, brought aboard a simulated Otter and sailed: node aboard.mjs URL PASSWORD OTTER.

import { check, inBrowser, logIn, look } from "./browser.mjs";

const [url, password, otter] = process.argv.slice(2);

await inBrowser(async (open) => {
  const page = await open();
  await logIn(page, url, "admin", password);
  const vessels = await (await page.request.get(`${url}/api/v1/vessels`)).json();
  const { address, fix } = vessels.find((one) => one.name === otter);

  // A plan near the boat, typed.
  await page.goto(`${url}/plans`);
  await page.getByRole("button", { name: "New plan" }).click();
  await page.getByText("No maneuvers yet.").waitFor();
  const type = async (label, text) => {
    await page.getByLabel(label, { exact: true }).fill(String(text));
    await page.keyboard.press("Enter");
  };
  for (const north of [0.0005, 0.001]) {
    await page.getByRole("button", { name: "Add", exact: true }).click();
    await type("Latitude", (fix.lat_deg + north).toFixed(6));
    await type("Longitude", fix.lon_deg.toFixed(6));
  }
  await type("Name of the plan", "from ashore");
  await page.locator(".plan-aboard").getByRole("combobox").selectOption({ label: otter });
  await page.getByText("What is shown is not saved: save it, then it can go aboard.").waitFor();
  check(await page.getByRole("button", { name: "Upload" }).isDisabled(), "a draft does not go aboard");
  await page.getByRole("button", { name: "Save", exact: true }).click();
  await page.getByText(/^Saved .*Z, revision \d+$/).waitFor();

  // Without control it is refused and stays here; with it the vessel's digest is ours.
  await page.getByRole("button", { name: "Upload" }).click();
  await page.getByRole("alert").getByText(/Not uploaded: .* The plan stays here as it is/).waitFor();
  check(await page.getByRole("button", { name: "Start …", exact: true }).isDisabled(), "what is not aboard is not started");
  await page.getByRole("button", { name: "Take control" }).click();
  await page.getByText("You have control of this vessel.").waitFor();
  await page.getByRole("button", { name: "Upload" }).click();
  await page.locator('.commands > li[data-order="plan.upload"]').first().getByText(/done/).waitFor();
  await page.getByText(new RegExp(`Same digest ashore and aboard ${otter}: [0-9a-f]{8}`)).waitFor();
  await look(page, "plan-aboard");

  // Another state ashore is not what is aboard.
  await type("Speed of all", "4");
  await page.getByText("What is shown is not saved").waitFor();
  await page.getByRole("button", { name: "Save", exact: true }).click();
  await page.getByText(new RegExp(`DIFFERENT: ashore [0-9a-f]{8}, aboard ${otter} [0-9a-f]{8}`)).waitFor();
  await page.getByRole("button", { name: "Upload" }).click();
  await page.getByText(new RegExp(`Same digest ashore and aboard ${otter}`)).waitFor();

  // The bar that stays in sight asks the same, and starts nothing by itself.
  const bar = page.getByRole("region", { name: "Plan, verdict, and what to do with it" });
  await bar.getByText(`For ${otter}`).waitFor();
  await bar.getByText("Same aboard", { exact: true }).waitFor();
  check(await page.getByRole("button", { name: `STOP ${otter}`, exact: true }).isVisible(), "the STOP of the vessel that is commanded");
  // The demonstration started its own plan before.
  const started = page.locator('.commands > li[data-order="plan.start"]');
  const before = await started.count();
  await bar.getByRole("button", { name: "Start …" }).click();
  await page.getByText(/Digest: [0-9a-f]{32}/).waitFor();
  await page.getByRole("button", { name: "Cancel", exact: true }).click();
  await page.getByText(/Digest: [0-9a-f]{32}/).waitFor({ state: "detached" });
  check((await started.count()) === before, "nothing was started");

  // From here it is started, in two steps with the digest in words, and sailed.
  await page.getByRole("button", { name: "Start from ashore …" }).click();
  await page.getByText(/Digest: [0-9a-f]{32}/).waitFor();
  await page.getByRole("button", { name: "Start from ashore", exact: true }).click();
  await page.locator('.commands > li[data-order="plan.start"]').first().getByText(/done/).waitFor();
  await page.goto(`${url}/vessels/${address}`);
  await page.locator('[data-tile="plan"]').getByText("from ashore").waitFor();
});
