// What vessels may say, as nobody should believe it: node hostile.mjs URL ONE-TIME-PASSWORD ROUNDS. Prints which round of
// texts it wants. On every page, at every width: STOP is on the screen, nothing is executed, nothing sticks out.

import { check, fits, inBrowser, logIn } from "./browser.mjs";

const [url, oneTime, rounds] = process.argv.slice(2);
const NAMED = 0x0814;
const FOREIGN = 0x0815;
const WIDTHS = [390, 820, 1440];
const TABS = ["Control", "Plots", "Values", "Entities", "Log book", "Tags", "Link loss", "Parameters"];

/** All that is wrong in a round. */
const wrong = [];
const holdsTrue = async (work) => {
  try {
    await work();
  } catch (error) {
    wrong.push(error.message);
  }
};

/** STOP of the page is whole within the window, and nothing lies over it; also when the page is scrolled. */
async function stopIsThere(page, where) {
  for (const scrolled of [false, true]) {
    const hidden = await page.evaluate((scrolled) => {
      scrollTo(0, scrolled ? document.body.scrollHeight : 0);
      const buttons = [...document.querySelectorAll("#stop .halt")].filter((one) => one.checkVisibility());
      if (!buttons.length) return "there is none";
      for (const one of buttons) {
        const { left, right, top, bottom } = one.getBoundingClientRect();
        const place = `${one.textContent.slice(0, 50)}: ${Math.round(left)} to ${Math.round(right)}, ${Math.round(top)} to ${Math.round(bottom)}`;
        if (left < 0 || right > innerWidth || top < 0 || bottom > innerHeight) return `${place} in ${innerWidth} x ${innerHeight}`;
        const above = document.elementFromPoint((left + right) / 2, (top + bottom) / 2);
        if (!one.contains(above)) return `${place} lies under ${above?.outerHTML.slice(0, 100)}`;
      }
      return "";
    }, scrolled);
    check(!hidden, `${where}${scrolled ? ", scrolled" : ""}: STOP: ${hidden}`);
  }
}

async function holds(page, where, widths = WIDTHS) {
  for (const width of widths) {
    await page.setViewportSize({ width, height: width < 820 ? 844 : 900 });
    // As drawn for this width.
    await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
    const at = `${where} at ${width} px`;
    await holdsTrue(() => fits(page, at));
    await holdsTrue(() => stopIsThere(page, at));
    check((await page.evaluate(() => window.executed)) === undefined, `${at}: a text was executed`);
  }
}

await inBrowser(async (open) => {
  const fleet = await open();
  await logIn(fleet, url, "admin", oneTime, "nine grey otters");
  const context = fleet.context();
  const another = async (path) => {
    const page = await context.newPage();
    page.on("pageerror", (error) => check(false, String(error)));
    page.on("dialog", () => check(false, "a dialog opened"));
    await page.goto(`${url}${path}`);
    await page.locator('body[data-link="up"]').waitFor();
    return page;
  };
  await fleet.goto(url);
  const vessels = [];
  for (const address of [NAMED, FOREIGN]) vessels.push(await another(`/vessels/${address}`));
  const plans = await another("/plans");
  const transports = await another("/admin/connections");

  for (let round = 1; round <= Number(rounds); round++) {
    console.log(`round ${round}`);
    await fleet.bringToFront();
    await fleet.setViewportSize({ width: 1440, height: 900 });
    // Those without a name are folded while there are others.
    const fold = fleet.locator(".fold");
    await fold.waitFor();
    if ((await fold.getAttribute("aria-expanded")) === "false") await fold.click();
    await fleet.getByText(`round-${round} · USV`).waitFor();
    await holds(fleet, `round ${round}, fleet`);
    // Each system in turn is the one whose values are shown, and whose STOP stands in the bar.
    const cards = fleet.locator(".systems button.system");
    for (let at = 0; at < (await cards.count()); at++) {
      await cards.nth(at).click();
      await holds(fleet, `round ${round}, system ${at} of the fleet`, [390]);
    }
    await fleet.setViewportSize({ width: 390, height: 844 });
    await fleet.locator("#stop summary").click();
    await holdsTrue(() => fits(fleet, `round ${round}, the others`));
    const others = await fleet.locator("#stop .others button").evaluateAll((all) => all.map((one) => one.getBoundingClientRect()).map(({ left, right }) => [left, right, innerWidth]));
    check(others.length >= 5, `${others.length} others under STOP`);
    for (const [left, right, wide] of others) check(left >= 0 && right <= wide, `a STOP reaches from ${left} to ${right} px of ${wide}`);
    await fleet.locator("#stop summary").click();

    for (const [which, page] of vessels.entries()) {
      await page.bringToFront();
      await page.setViewportSize({ width: 1440, height: 900 });
      for (const tab of which ? TABS : ["Control"]) {
        await page.getByRole("tab", { name: tab, exact: true }).click();
        await holds(page, `round ${round}, vessel ${which}, ${tab}`);
      }
    }
    await plans.bringToFront();
    await holds(plans, `round ${round}, plans`);
    await transports.bringToFront();
    await transports.reload();
    await transports.locator('body[data-link="up"]').waitFor();
    await holds(transports, `round ${round}, transports`);
    check(!wrong.length, `${wrong.length} times wrong:\n${wrong.slice(0, 20).join("\n")}`);
  }

  // What became of a stop names the vessel, on the smallest window too.
  await vessels[1].bringToFront();
  await vessels[1].setViewportSize({ width: 390, height: 844 });
  await vessels[1].locator("#stop .halt").first().click();
  await vessels[1].locator("#orders .order").waitFor();
  await holds(vessels[1], "after STOP");
  check(!wrong.length, wrong.join("\n"));
});
