// Steering a simulated Otter towards land by hand: node teleop-guard.mjs URL PASSWORD. The vessel's guard blocks it until the
// operator lifts it, in two steps and in their name.

import { check, inBrowser, logIn, look } from "./browser.mjs";
import { begin, button, hold, keysOf, motors, password, PATIENCE_MS, runs, takeControl, TRIES, url } from "./helm.mjs";

await inBrowser(async (open) => {
  const page = await open();
  page.setDefaultTimeout(2 * PATIENCE_MS);
  await logIn(page, url, "anna", password);
  const keys = keysOf(page);
  const shows = (state) => page.locator(`.helm-guard[data-guard="${state}"]`);
  const guard = (state) => shows(state).waitFor();
  const still = async (from) => {
    for (const end = Date.now() + PATIENCE_MS; ; ) {
      const rows = await motors(page, from);
      const last = [0, 1].map((motor) => rows.filter((row) => row.motor === motor).at(-1)?.value);
      if (last.every((value) => value === 0)) return;
      check(Date.now() < end, `the motors run on: ${last}`);
    }
  };

  await takeControl(page);
  await begin(page);
  await guard("watches");
  // Full ahead until it is blocked; whatever else stops it on a busy computer is started over.
  for (let tries = 0; !(await shows("blocks").isVisible()); tries++) {
    check(tries < TRIES, "it is not blocked");
    await hold(page, page, keys);
    await shows("blocks").or(page.locator('.helm:not([data-phase="steering"])')).first().waitFor();
  }
  // The keys are still held, and nothing goes ahead.
  await still(Date.now() - 2_000);
  await look(page, "teleop-blocked");
  await keys.release();

  await button(page, "Steer unguarded …").click();
  const confirm = page.getByRole("group", { name: "Steer otter-1 unguarded?" });
  const words = await confirm.innerText();
  check(/The sea chart aboard says: .+; by chart /.test(words) && /audit log in your name/.test(words), words);
  await page.keyboard.press("Escape");
  await button(page, "Steer unguarded …").click();
  await button(page, "Steer unguarded for 60 s").click();
  await guard("lifted");
  await hold(page, page, keys);
  check(runs(await motors(page, Date.now() - 3_000)), "unguarded, the vessel obeys");
  await keys.release();
  await button(page, "Guard again").click();
  await shows("blocks").or(shows("watches")).waitFor();

  const audit = await (await page.request.get(`${url}/api/v1/audit`)).json();
  const asked = audit.filter((one) => one.action === "parameters.set" && one.actor === "anna").map((one) => one.subject);
  for (const what of ["Override Request", "Override Confirmation"]) check(asked.some((one) => one.includes(what)), `${what} in ${asked}`);
});
