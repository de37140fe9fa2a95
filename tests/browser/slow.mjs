// Work behind a slow and lossy link: node slow.mjs URL URL-BEHIND-THE-LINK PASSWORD. Prints what it wants done to the link.

import { PATIENCE_MS, check, inBrowser, logIn, look } from "./browser.mjs";

const [url, slow, password] = process.argv.slice(2);
const OTTER = 10449;
const WORDS = "seven small boats at sea";

await inBrowser(async (open) => {
  const admin = await open();
  await logIn(admin, url, "admin", password);
  await admin.goto(`${url}/admin`);
  const form = admin.locator("main form.card");
  await form.getByLabel("Name").fill("nils");
  await form.getByLabel("Role").selectOption("operator");
  await form.getByRole("button", { name: "Add" }).click();
  const secret = await admin.locator(".secret").innerText();
  const button = (page, name) => page.getByRole("button", { name, exact: true });
  const type = async (page, label, text) => {
    await page.getByLabel(label, { exact: true }).fill(text);
    await page.keyboard.press("Enter");
  };
  const stored = async (page) => (await admin.request.get(`${url}/api/v1/plans/${page.url().split("/").at(-1)}`)).json();

  // The first page comes, and the boat moves on it.
  const page = await open();
  page.context().setDefaultTimeout(3 * PATIENCE_MS);
  await logIn(page, slow, "nils", secret, WORDS);
  const begun = Date.now();
  await page.goto(slow);
  await page.locator('body[data-link="up"]').waitFor();
  console.log(`live ${Date.now() - begun} ms after the first page was asked for`);
  const place = page.getByRole("button", { name: /^otter-1/ }).locator(".place");
  for (let moved = 0; moved < 3; moved++) {
    const before = await place.innerText();
    await page.waitForFunction(([node, before]) => node.textContent !== before, [await place.elementHandle(), before]);
  }

  // Control and an order with all its stages.
  await page.goto(`${slow}/vessels/${OTTER}?tab=Control`);
  await button(page, "Take control").click();
  await page.getByText("You have control of this vessel.").waitFor();
  await button(page, "Stop plan").click();
  const order = page.locator('.commands > li[data-order="plan.stop"]').first();
  const stages = await order.getByText(/done/).waitFor().then(() => order.innerText());
  for (const stage of ["accepted", "sent", "received", "done"]) check(stages.includes(stage), `${stage} in ${stages}`);

  // Steering by hand is told to be slow, and what comes too late moves nothing.
  const refused = page.getByRole("region", { name: "Steer by hand" }).getByRole("alert");
  for (let tries = 0; ; tries++) {
    await button(page, "Steer by hand …").click();
    await button(page, "Steer by hand").click();
    await page.locator(".helm-trip[data-slow]").getByText(/^Round trip \d+ ms .*SLOW: steer with care\./).waitFor();
    await page.locator('.helm[data-phase="locked"]').or(refused).first().waitFor();
    if (!(await refused.isVisible())) break;
    check(tries < 20, `not begun: ${await refused.innerText()}`);
  }
  await page.locator(".helm-keys").focus();
  await page.keyboard.down("Space");
  await page.keyboard.down("ArrowUp");
  await page.locator(".helm-remedy").getByText("Your network is slow at present: wait, or send the vessel by a plan.").waitFor();
  check((await page.locator(".helm").getAttribute("data-phase")) !== "steering", "it is not steered");
  await look(page, "slow-teleop");
  for (const key of ["ArrowUp", "Space"]) await page.keyboard.up(key);
  await button(page, "End steering by hand").click();

  // A tab that is duplicated, with all that the browser keeps of it, is another window.
  const [copy] = await Promise.all([page.context().waitForEvent("page"), page.evaluate(() => void window.open(location.href))]);
  await copy.getByText("You have control in another window.").waitFor();
  check(await button(copy, "Stop plan").isDisabled(), "which commands nothing");
  await button(copy, "Take control here").click();
  await copy.getByText("You have control of this vessel.").waitFor();
  await page.getByText("You have control in another window.").waitFor();
  await copy.close();
  // Through reloading a tab stays the same.
  await button(page, "Take control here").click();
  await page.getByText("You have control of this vessel.").waitFor();
  await page.reload();
  await page.getByText("You have control of this vessel.").waitFor();
  await button(page, "Release control").click();

  // A plan is drawn and kept; the link breaks, and nothing is lost.
  await page.goto(`${slow}/plans`);
  await button(page, "New plan").click();
  await page.getByText("No maneuvers yet.").waitFor();
  await button(page, "Add").click();
  await type(page, "Latitude", "63.44");
  await type(page, "Longitude", "10.4");
  await type(page, "Name of the plan", "by a bad link");
  await page.getByText(/^Kept as draft .*Z, revision \d+$/).waitFor();
  check((await stored(page)).plan.name === "by a bad link", "kept on the server");
  console.log("cut the line");
  await page.getByText("No link to the server").waitFor();
  await type(page, "What for", "while there was no link");
  await page.getByText(/Not on the server: The server cannot be reached. It is kept in this browser; trying again/).waitFor();
  await page.keyboard.press("Control+s");
  await page.getByText(/Not on the server: The server cannot be reached. It is kept in this browser; trying again/).waitFor();
  await look(page, "slow-cut");
  console.log("mend the line");
  await page.getByText(/^(Kept as draft|Saved) .*Z, revision \d+$/).waitFor();
  check((await stored(page)).plan.description === "while there was no link", "brought when the link is back");
  await page.context().close();

  // A session that ends in the middle: the order says that it was not done, and the plan is kept until the next login.
  const two = await open();
  await logIn(two, url, "nils", WORDS);
  await two.goto(`${url}/vessels/${OTTER}?tab=Control`);
  await button(two, "Take control").click();
  await two.getByText("You have control of this vessel.").waitFor();
  const session = await two.context().cookies();
  await two.context().clearCookies();
  await button(two, "Stop plan").click();
  await two.getByRole("alert").getByText("You are not logged in any more: this was not done.").waitFor();
  await look(two, "session-over-order");
  await two.context().addCookies(session);
  await two.goto(`${url}/plans`);
  await two.getByRole("link", { name: "by a bad link" }).click();
  await two.getByText("1 Goto 1").waitFor();
  const address = two.url();
  await two.context().clearCookies();
  await type(two, "What for", "after the session");
  await two.getByText(/Not on the server: You are not logged in any more: .* It is kept in this browser\./).waitFor();
  await look(two, "session-over-plan");
  // The page notices when the server ends the session too, and comes back after the login with what it kept.
  await admin.goto(`${url}/admin/sessions`);
  await admin.getByRole("row", { name: /nils/ }).first().waitFor();
  for (let left = await admin.getByRole("row", { name: /nils/ }).count(); left > 0; left--) {
    const session = admin.getByRole("row", { name: /nils/ }).first();
    await session.getByText(/^End the session of nils/).click();
    await session.getByRole("button", { name: "End the session now" }).click();
    await admin.waitForFunction((left) => [...document.querySelectorAll("main tr")].filter((row) => /nils/.test(row.textContent)).length < left, left);
  }
  await two.waitForURL(/\/login\?next=/);
  await two.getByLabel("Name").fill("nils");
  await two.getByLabel("Password").fill(WORDS);
  await two.getByRole("button", { name: "Log in" }).click();
  await two.waitForURL(address);
  await two.getByText(/This browser has changes to the plan from .* that did not reach the server/).waitFor();
  await button(two, "Go on with it").click();
  await two.getByText(/^Kept as draft .*Z, revision \d+$/).waitFor();
  check((await stored(two)).plan.description === "after the session", "nothing was lost");
});
