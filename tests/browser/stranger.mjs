// Whose STOP stands in the bar: node stranger.mjs URL ONE-TIME-PASSWORD. Prints what it wants the boat to do, which nobody
// has registered.

import { check, inBrowser, logIn } from "./browser.mjs";

const [url, oneTime] = process.argv.slice(2);

await inBrowser(async (open) => {
  const page = await open();
  const context = page.context();
  await logIn(page, url, "admin", oneTime, "nine grey otters");
  const main = (on) => on.locator("#stop .aim button");
  const another = async () => {
    const made = await context.newPage();
    await made.goto(url);
    await made.locator('body[data-link="up"]').waitFor();
    return made;
  };

  // While it is heard it is a vessel like others; who looks at it when it falls silent can stop it when it comes back.
  await page.goto(url);
  await page.getByRole("button", { name: "STOP otter-0", exact: true }).waitFor();
  console.log("silence");
  await page.locator('.system[data-liveness="stale"], .system[data-liveness="lost"]').waitFor();
  check((await main(page).innerText()) === "STOP otter-0", "it keeps its place");

  // Who comes later finds it among the others only, also when it is chosen.
  const later = await another();
  const card = later.locator('.system[data-liveness="stale"], .system[data-liveness="lost"]');
  await card.waitFor();
  check((await main(later).count()) === 0, "a stranger that is gone takes no place");
  await card.click();
  await later.waitForFunction(() => document.querySelector(".system[aria-pressed=true]"));
  check((await main(later).count()) === 0, "nor when it is chosen");
  await later.getByText("STOP …", { exact: true }).click();
  await later.getByRole("button", { name: "STOP otter-0", exact: true }).waitFor();

  // A vessel with a name from its people has the place, heard or not.
  await later.goto(`${url}/admin/vessels`);
  const form = later.locator("main form.card").first();
  await form.getByLabel("Name").fill("northern");
  await form.getByLabel(/address/i).fill("0x0900");
  await form.getByRole("button", { name: "Add" }).click();
  await later.getByText("northern").first().waitFor();
  const ours = await another();
  await main(ours).getByText("STOP northern", { exact: true }).waitFor();
  // Also where the stranger is heard again.
  console.log("speak");
  await ours.getByRole("button", { name: /^1 system not registered here/ }).click();
  await ours.locator('.system[data-liveness="live"]').waitFor();
  check((await main(ours).innerText()) === "STOP northern", "it keeps its place");
});
