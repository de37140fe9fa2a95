// Alarms for who reads Bokmål: node alarms-nb.mjs URL ONE-TIME-PASSWORD. Bar, list, advice, card, notification and history say
// them in it. Prints what the boat is to do.

import { check, inBrowser, later, logIn, look } from "./browser.mjs";

const [url, oneTime] = process.argv.slice(2);

await inBrowser(async (open) => {
  const page = await open();
  await logIn(page, url, "admin", oneTime, "nine grey otters");
  await page.goto(`${url}/account`);
  await page.getByLabel("Language of the pages").selectOption("Norsk bokmål");
  await page.getByRole("button", { name: "Choose language" }).click();
  await page.getByText("Sidene er på språket som du valgte.").waitFor();
  await page.goto(url);
  const bar = page.locator("#alarms");
  const worst = (text) => bar.locator(".alarm-bar .worst").getByText(text);
  await worst("Ingen alarmer").waitFor();
  await page.evaluate(() => {
    window.notified = [];
    Object.defineProperty(document, "hidden", { get: () => window.away ?? false });
    Object.defineProperty(Notification, "permission", { get: () => "granted" });
    Object.defineProperty(navigator, "serviceWorker", { value: { getRegistration: async () => ({ showNotification: async (_, { body }) => window.notified.push(body) }) } });
    window.away = true;
  });

  // Little charge: a figure in words.
  console.log("empty");
  await later(worst(/otter-0: 24 % lading igjen$/), 2);
  await page.waitForFunction(() => window.notified.length > 0);
  const notified = await page.evaluate(() => {
    window.away = false;
    return window.notified;
  });
  check(/^advarsel: otter-0: 24 % lading igjen$/.test(notified[0]), JSON.stringify(notified));
  await page.locator(".system").getByText(/advarsel: 24 % lading igjen/).waitFor();
  await bar.locator(".open").click();
  const row = (kind) => bar.locator(`[data-alarm="${kind}"]`);
  await row("battery").getByText("Ta det hjem eller stopp det der det kan hentes.").waitFor();
  await row("battery").getByText("Fartøyet kommer kanskje ikke hjem på egen hånd.").waitFor();
  await look(page, "alarms-bokmal");
  await row("battery").getByRole("button", { name: /^Kvitter/ }).click();
  console.log("full");

  // Silence: a time in words. What happened is kept in codes, and the history says it in the same words.
  console.log("silence");
  await later(worst(/otter-0: ikke hørt siden \d\d:\d\d:\d\dZ/), 2);
  console.log("speak");
  await later(worst(/; over siden \d\d:\d\d:\d\dZ, ikke kvittert/), 2);
  const history = async (text) => {
    for (let times = 0; !(await page.getByRole("cell", { name: text }).count()); times++) {
      check(times < 40, `${text} in the history`);
      console.log("advance 1");
      await page.goto(`${url}/alarms`);
    }
  };
  await history(/^ikke hørt siden \d\d:\d\d:\d\dZ$/);
  await page.getByRole("cell", { name: "24 % lading igjen", exact: true }).first().waitFor();
  check(!/not heard|charge left/.test(await page.locator("main").innerText()), "no English is left");
  await look(page, "alarms-history-bokmal");
});
