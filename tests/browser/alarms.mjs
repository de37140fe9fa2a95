// What is wrong with a boat, told on every page: node alarms.mjs URL PASSWORD. Prints what the boat is to do.

import { check, inBrowser, later, logIn, look } from "./browser.mjs";

const [url, password] = process.argv.slice(2);

/** Counts the tones that the page sounds from here on, in `window.tones`, and takes its timers of half a minute. */
const countTones = (page) =>
  page.evaluate(() => {
    window.tones = 0;
    const start = OscillatorNode.prototype.start;
    OscillatorNode.prototype.start = function (...when) {
      window.tones += 1;
      return start.apply(this, when);
    };
    // What the page wants to do in half a minute it does when the script calls it.
    window.inHalfAMinute = [];
    const setTimer = window.setTimeout;
    window.setTimeout = (work, ms, ...rest) => (ms === 30_000 ? -window.inHalfAMinute.push(work) : setTimer(work, ms, ...rest));
  });

await inBrowser(async (open) => {
  const page = await open();
  await logIn(page, url, "admin", password, "seven small boats at sea");

  // A viewer sees and cannot.
  await page.goto(`${url}/admin`);
  const form = page.locator("main form.card");
  await form.getByLabel("Name").fill("vera");
  await form.getByLabel("Role").selectOption("viewer");
  await form.getByRole("button", { name: "Add" }).click();
  const secret = await page.locator(".secret").innerText();
  const viewer = await open();
  await logIn(viewer, url, "vera", secret, "seven small boats at sea");

  const bar = (one) => one.locator("#alarms");
  const worst = (one, text) => bar(one).locator(".alarm-bar .worst").getByText(text);
  const told = (one, text) => worst(one, text).waitFor();
  const row = (one, kind) => bar(one).locator(`[data-alarm="${kind}"]`);
  for (const one of [page, viewer]) {
    await one.goto(url);
    await told(one, "No alarms");
  }

  // The sound is off until somebody turns it on, which lets them hear it.
  const sound = page.getByRole("button", { name: /^Sound/ });
  check((await sound.innerText()) === "Sound off: turn on", "it says that it is muted");
  await sound.click();
  await page.getByRole("button", { name: "Sound on: mute" }).waitFor();
  await countTones(page);
  // Who allowed it is told by the system where the page is not looked at.
  await page.evaluate(() => {
    window.notified = [];
    Object.defineProperty(document, "hidden", { get: () => window.away ?? false });
    Object.defineProperty(Notification, "permission", { get: () => "granted" });
    const registration = { showNotification: async (title, { body, tag }) => window.notified.push({ title, body, tag }) };
    Object.defineProperty(navigator, "serviceWorker", { value: { getRegistration: async () => registration } });
    window.away = true;
  });

  // Silence in a plan: one warning, whatever else stops with it.
  console.log("silence");
  await later(worst(page, /otter-0: not heard since/), 2);
  await told(viewer, /otter-0: not heard since/);
  await page.waitForFunction(() => window.tones === 1);
  const notified = await page.evaluate(() => {
    window.away = false;
    return window.notified;
  });
  check(notified.length === 1 && /^warning: otter-0: not heard since/.test(notified[0].body) && /^alarm-\d+$/.test(notified[0].tag), JSON.stringify(notified));
  await page.getByRole("button", { name: /otter-0: not heard/ }).press("Enter");
  await row(page, "not_heard").getByText("What to do").waitFor();
  check((await bar(page).locator("[data-alarm]").count()) === 1, "one situation, one alarm");
  // It flashes: its text is there also while it is not seen.
  check((await bar(page).locator('.alarm-bar .badge[data-priority="warning"]').textContent()).includes("1"), "counted by priority");
  await look(page, "alarms-silent");
  await bar(viewer).locator(".open").click();
  await row(viewer, "not_heard").getByText(/NOT ACKNOWLEDGED/).waitFor();
  check((await bar(viewer).getByRole("button", { name: /^Acknowledge/ }).count()) === 0, "a viewer cannot");

  // Nobody acknowledges: it becomes an alarm, and sounds as one.
  await later(row(page, "not_heard").getByText("more urgent because it was not acknowledged"), 20);
  await page.waitForFunction(() => window.tones >= 4);
  check((await bar(page).getAttribute("data-priority")) === "alarm", "it is an alarm now");
  const flashing = () => page.evaluate(() => document.querySelector(".alarms .counts").getAnimations({ subtree: true }).length);
  check((await flashing()) === 0, "nothing flashes for who wants no motion");
  await page.emulateMedia({ reducedMotion: "no-preference" });
  check((await flashing()) > 0, "what nobody acknowledged flashes");
  await look(page, "alarms-escalated");
  await page.getByRole("button", { name: /^Acknowledge: otter-0: not heard/ }).press("Enter");
  await row(page, "not_heard").getByText("acknowledged by admin").waitFor();
  await row(viewer, "not_heard").getByText("acknowledged by admin").waitFor();
  check((await bar(page).getAttribute("data-open")) === null, "known: it flashes no more");
  // What the silent vessel will do, in its own words, and when.
  await page.goto(`${url}/vessels/2068`);
  await page.getByRole("tab", { name: "Link loss" }).click();
  await page.getByText("Link lost.").waitFor();
  await page.getByRole("button", { name: "Sound on: mute" }).waitFor();
  await page.getByText(/Without the link it will hold station at \d\d:\d\d:\d\dZ\. That is in \d+ .*Lost Communications reported this/).waitFor();
  await page.getByText(/Last message .* ago · last position .* ago · last command answered never/).waitFor();
  check(!(await page.getByRole("button", { name: "Read its settings" }).isDisabled()), "it can be asked");
  await told(page, /otter-0: not heard since/);
  await look(page, "alarms-link-loss");
  await page.goto(url);
  await page.getByRole("button", { name: /otter-0: not heard/ }).click();
  await look(page, "alarms-fleet");
  console.log("speak");
  await later(worst(page, "No alarms"), 2);
  await told(viewer, "No alarms");

  // Charge runs out and comes back before anybody looked: it stays until somebody knows.
  console.log("empty");
  await later(worst(page, /otter-0: 24 % charge left/), 3);
  console.log("full");
  await later(row(page, "battery").getByText("over, NOT ACKNOWLEDGED"), 16);
  await told(page, /otter-0: 24 % charge left; over since \d\d:\d\d:\d\dZ, not acknowledged/);
  await row(page, "battery").getByText(/from .* to \d\d:\d\d:\d\dZ/).waitFor();
  check(/^● otter-0: 24 % charge left; over .* · Fleet/.test(await page.title()), `the title says it: ${await page.title()}`);
  await page.getByRole("button", { name: /^Acknowledge: otter-0: 24 %/ }).click();
  await told(page, "No alarms");

  // Shelved for a time, with a reason that everybody reads; the history tells it all.
  console.log("lost");
  await later(worst(page, /otter-0: Navigation: error/), 2);
  await row(page, "position").getByText("Shelve …").click();
  await row(page, "position").getByLabel(/^Why/).fill("antenna is being changed");
  await row(page, "position").getByRole("button", { name: "Shelve", exact: true }).click();
  await told(viewer, "No alarms; 1 shelved");
  await row(viewer, "position").getByText("shelved by admin: antenna is being changed").waitFor();
  await bar(page).getByText("Recent events").click();
  await bar(page).locator(".alarm-past").getByText(/otter-0: alarm shelved by admin: antenna is being changed/).waitFor();
  await bar(page).locator(".alarm-past").getByText(/escalated/).waitFor();
  await look(page, "alarms-list");
  await page.keyboard.press("Escape");
  await page.goto(`${url}/admin/audit`);
  await page.getByRole("cell", { name: "Shelve alarm" }).first().waitFor();
  await page.getByRole("cell", { name: "Acknowledge alarm" }).first().waitFor();
  // On a page that is about something else the bar stands too.
  await told(page, "No alarms; 1 shelved");
  await look(page, "alarms-audit");
  // What happened to alarms is kept: by vessel and priority, and where nothing is, that is said.
  await page.goto(`${url}/alarms`);
  const past = page.getByRole("region", { name: "Alarm history" });
  await past.getByRole("row", { name: /otter-0 alarm shelved antenna is being changed admin/ }).waitFor();
  await past.getByRole("row", { name: /escalated/ }).first().waitFor();
  await page.getByLabel("Priority").selectOption("caution");
  await page.getByRole("button", { name: "Show", exact: true }).click();
  check((await page.getByRole("row", { name: /shelved/ }).count()) === 0, "filtered by priority");
  await page.goto(`${url}/alarms?from=2001-01-01T00:00&to=2001-01-02T00:00`);
  await page.getByText("No alarm changed in this time. Choose a longer time, or clear the filter.").waitFor();
  await page.goto(`${url}/alarms?from=yesterday`);
  await page.getByText("Not a valid time. Write it like 2026-06-01 12:00, in UTC.").waitFor();
  await told(page, "No alarms; 1 shelved");
  await look(page, "alarms-history");

  // Without the server nobody knows of alarms: the bar says so, and it sounds until somebody sees to it.
  await page.getByRole("heading", { name: "Alarm history" }).click();
  await page.getByRole("button", { name: "Sound on: mute" }).waitFor();
  await countTones(page);
  console.log("stop the server");
  await told(page, /^Alarms unknown since \d\d:\d\d:\d\dZ: the server is not reached/);
  await page.waitForFunction(() => window.tones === 3);
  // It tries again and again, and does not sound at each try, but again after half a minute.
  for (let tries = 0; tries < 3; tries++) await page.waitForEvent("websocket");
  check((await page.evaluate(() => window.tones)) === 3, "it does not sound at each try");
  await look(page, "alarms-not-known");
  check((await page.evaluate(() => window.inHalfAMinute.length)) === 1, "it sounds again in half a minute");
  await page.evaluate(() => window.inHalfAMinute[0]());
  await page.waitForFunction(() => window.tones === 6);
});
