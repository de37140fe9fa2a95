// Control of a boat between two people, and steering it by hand, by keyboard alone: node keyboard-control.mjs URL PASSWORD.

import { check, inBrowser, table } from "./browser.mjs";
import { atKeyboard } from "./keys.mjs";

const [url, password] = process.argv.slice(2);
const OTTER = 10449;
const PASSWORD = "seven small boats at sea";

await inBrowser(async (open) => {
  const pages = [await open(), await open()];
  const [one, two] = pages;
  const [admin, nils] = pages.map(atKeyboard);
  await admin.logIn(url, "admin", password);

  // A second operator, added by keys; the first login asks for a password of their own.
  await admin.to("Admin");
  await admin.follow(/\/admin$/);
  await admin.to("Name");
  await admin.write("nils");
  await admin.choose("Role", "operator");
  await admin.act("Add");
  const secret = await one.locator(".secret").innerText();
  await two.goto(`${url}/login`);
  await nils.to(/^Name/);
  await nils.write("nils");
  await nils.to(/^Password/);
  await nils.write(secret);
  await nils.press("Enter");
  await two.waitForURL(/\/account/);
  for (const [label, text] of [["One-time password", secret], [/^New password, at least/, PASSWORD], ["New password again", PASSWORD]]) {
    await nils.to(label);
    await nils.write(text);
  }
  await nils.press("Enter");
  await two.getByText("Your password is changed").waitFor();

  // Both at the boat's Control.
  for (const [page, hands] of [[one, admin], [two, nils]]) {
    await hands.to("Fleet", "Shift+Tab");
    await hands.follow(/:\d+\/$/);
    await hands.to("Open otter-1");
    await hands.follow(/\/vessels\/\d+/);
    await page.locator('[data-tile="mode"]').getByText("Executing plan").waitFor();
    await hands.to("Plots");
    await hands.press("ArrowLeft");
    await page.getByRole("tabpanel", { name: "Control" }).waitFor();
  }
  const who = (page, text) => page.locator(".control-box .who").getByText(text).waitFor();
  await admin.act("Take control");
  await who(one, "You have control of this vessel.");

  // Asked and declined, asked and granted, taken over with a reason.
  await who(two, "admin has control.");
  await nils.act("Ask for control");
  // The panel tells it a moment after the bar, and moves what is below it: nobody is in its fields then.
  await one.locator(".control-box").getByText("nils asks for control").waitFor();
  await admin.act("Decline");
  await two.getByRole("button", { name: "Ask for control", exact: true }).waitFor();
  // The question that was answered is gone before the next: what it took of the page moves what is below it.
  await one.getByText("nils asks for control").first().waitFor({ state: "detached" });
  await nils.act("Ask for control");
  // The panel tells it a moment after the bar, and moves what is below it: nobody is in its fields then.
  await one.locator(".control-box").getByText("nils asks for control").waitFor();
  await admin.act("Grant to nils");
  await who(two, "You have control of this vessel.");
  await who(one, "nils has control.");
  await admin.to("Reason, for the one who has control");
  await admin.write("it drifts ashore");
  await admin.act("Take over …");
  await one.getByText(/nils loses control at once/).waitFor();
  await admin.act("Take over now");
  await who(one, "You have control of this vessel.");
  await who(two, "Taken over from nils: it drifts ashore.");

  // By hand: begun in two steps, the dead-man held, ahead and to a side by arrows; the boat itself tells that it moves.
  /** What the vessel says it gave its motors since a time: when, and how much. */
  const motors = async (sinceMs) => {
    const csv = await one.request.get(`${url}/api/v1/export.csv?message=SetThrusterActuation&vessel=${OTTER}&from=${new Date(sinceMs).toISOString()}`);
    const { head, rows } = table(await csv.text());
    return rows.map((row) => ({ atMs: Number(row[head.indexOf("unix_s")]) * 1e3, value: Number(row.at(-1)) }));
  };
  await admin.act("Steer by hand …");
  await one.getByRole("group", { name: "Steer otter-1 by hand?" }).waitFor();
  await admin.act("Steer by hand");
  await one.locator('.helm[data-phase="ready"]').waitFor();
  // Whoever begins is at the keys already.
  check((await admin.focused()).name.startsWith("Keys:"), (await admin.focused()).html);
  const speed = () => one.locator('[data-tile="speed_mps"] .note-line').innerText();
  await one.waitForFunction(() => Number.parseFloat(document.querySelector('[data-tile="speed_mps"] .note-line').textContent) < 0.3);
  /** Steers until the page shows it; gives since when the dead-man and the arrow were held. Where the computer was too busy for a
   * moment the motors stop, as they must, even before the script has seen that they may turn: then hands let go and hold again. */
  const steer = async (keys, shows, argument) => {
    for (let tries = 0; tries < 20; tries++) {
      const heldMs = Date.now();
      await one.keyboard.down("Space");
      if (await one.locator('.helm[data-phase="steering"]').waitFor({ timeout: 5_000 }).then(() => true, () => false)) {
        const aheadMs = Date.now();
        for (const key of keys) await one.keyboard.down(key);
        const stands = () => document.querySelector(".helm").dataset.phase !== "steering";
        await Promise.race([one.waitForFunction(shows, argument), one.waitForFunction(stands)]);
        if (await one.evaluate(shows, argument)) return { heldMs, aheadMs };
      }
      for (const key of [...keys, "Space"]) await one.keyboard.up(key);
      await one.locator('.helm[data-phase="ready"]').waitFor();
    }
    throw new Error(`steering stops again and again: ${await one.getByRole("region", { name: "Steer by hand" }).innerText()}`);
  };
  const { heldMs, aheadMs } = await steer(["ArrowUp"], () => Number.parseFloat(document.querySelector('[data-tile="speed_mps"] .note-line').textContent) > 0.5);
  let thrust = [];
  for (const end = Date.now() + 20_000; !thrust.length; thrust = (await motors(heldMs)).filter(({ value }) => value !== 0)) check(Date.now() < end, `no motor turned, at ${await speed()}`);
  check(thrust.every(({ atMs, value }) => atMs >= aheadMs && value > 0), `the dead-man alone moves nothing, and ahead is ahead: ${JSON.stringify(thrust[0])}, ahead since ${aheadMs}`);
  // Turning: the heading that the boat tells changes.
  const heading = () => one.locator('[data-tile="heading_rad"] .reading').innerText();
  const before = Number.parseInt(await heading(), 10);
  await steer(["ArrowUp", "ArrowRight"], (before) => Math.abs(((Number.parseInt(document.querySelector('[data-tile="heading_rad"] .reading').textContent, 10) - before + 540) % 360) - 180) > 15, before);
  for (const key of ["ArrowRight", "ArrowUp", "Space"]) await one.keyboard.up(key);
  await one.locator('.helm[data-phase="ready"]').waitFor();
  await one.waitForFunction(() => Number.parseFloat(document.querySelector('[data-tile="speed_mps"] .note-line').textContent) < 0.3);
  await admin.act("End steering by hand");
  await one.locator(".helm").waitFor({ state: "hidden" });
  check((await admin.focused()).name === "Steer by hand …", "the focus goes back to where it began");
  await admin.act("Release control", "Shift+Tab");
  await who(one, "Nobody has control of this vessel.");
});
