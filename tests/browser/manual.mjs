// The manual: node manual.mjs URL ONE-TIME-PASSWORD. It is read before the login, searched without a script, and reached from an
// alarm; a reader of Bokmål is told that it is English. Prints what the boat is to do.

import { check, inBrowser, later, logIn, look, lookInAll } from "./browser.mjs";

const [url, oneTime] = process.argv.slice(2);

/** Without a login and without scripts. */
async function byAnyone(open) {
  const page = await open({ javaScriptEnabled: false });
  await page.goto(`${url}/login`);
  await page.getByRole("link", { name: "Manual", exact: true }).click();
  await page.getByRole("heading", { level: 1, name: "Lutra, and this manual" }).waitFor();
  const contents = page.getByRole("navigation", { name: "Contents" });
  await contents.getByRole("link", { name: "Alarms, and how to recover" }).click();
  await contents.getByRole("link", { name: "Battery low" }).waitFor();
  await page.getByRole("link", { name: /^Log book, missions, replay/ }).last().click();
  await page.getByRole("heading", { level: 1, name: "Log book, missions, replay" }).waitFor();

  // The search leads to a section; what it has nothing for it says.
  await page.getByRole("searchbox", { name: "Search the manual" }).fill("battery low");
  await page.getByRole("button", { name: "Search", exact: true }).click();
  await page.getByRole("link", { name: "Alarms, and how to recover: Battery low" }).click();
  check(page.url() === `${url}/help/alarms#battery`, page.url());
  await page.goto(`${url}/help?q=zeppelin+%3Cscript%3E`);
  await page.getByText("Nothing in the manual has all of these words.").waitFor();
  check((await page.getByRole("searchbox").inputValue()) === "zeppelin <script>", "what was asked stands there");
  const missing = await page.goto(`${url}/help/no-such-chapter`);
  check(missing.status() === 404, `${missing.status()}`);
}

/** Each picture is there, has words for who does not see it, and no chapter is wider than a phone. */
async function everyChapter(page) {
  await page.goto(`${url}/help`);
  const chapters = await page.locator("#contents > ul > li > a").evaluateAll((all) => all.map((one) => one.getAttribute("href")));
  check(chapters.length > 10, `${chapters.length} chapters`);
  let pictures = 0;
  for (const chapter of chapters) {
    await page.goto(url + chapter);
    await look(page, `manual ${chapter}`);
    const found = await page.locator(".chapter img").evaluateAll((all) => Promise.all(all.map(async (one) => {
      await one.decode();
      return { width: one.naturalWidth, alt: one.alt, src: one.src };
    })));
    for (const { width, alt, src } of found) check(width > 300 && alt.length > 5, `${src}: ${width} px, “${alt}”`);
    pictures += found.length;
  }
  check(pictures >= 8, `${pictures} pictures`);
  await page.goto(`${url}/help/alarms`);
  await lookInAll(page, "manual, alarms");
  await page.goto(`${url}/help?q=battery`);
  await lookInAll(page, "manual, found");
  await page.emulateMedia({ media: "print" });
  check(!(await page.getByRole("navigation", { name: "Contents" }).isVisible()), "contents are not printed");
  await page.emulateMedia({ media: null });
}

await inBrowser(async (open) => {
  await byAnyone(open);
  const page = await open();
  await logIn(page, url, "admin", oneTime, "nine grey otters");
  await everyChapter(page);

  // From the help of a page, and from an alarm to what to do about it.
  await page.goto(url);
  await page.getByRole("button", { name: "Help" }).click();
  await page.getByRole("dialog", { name: "Help" }).getByRole("link", { name: /^The manual/ }).click();
  await page.getByRole("heading", { level: 1, name: "Lutra, and this manual" }).waitFor();
  await page.goto(url);
  await page.getByText("Live", { exact: true }).waitFor();
  console.log("empty");
  await later(page.locator("#alarms .worst").getByText(/charge left/), 2);
  await page.locator("#alarms .open").click();
  await page.locator('#alarms [data-alarm="battery"]').getByRole("link", { name: /^How to recover/ }).click();
  const section = page.getByRole("heading", { level: 2, name: "Battery low" });
  await section.waitFor();
  // The bars stay at the top and hide nothing that was led to.
  const [top, at] = await Promise.all([page.locator("#top").evaluate((one) => one.getBoundingClientRect().bottom), section.evaluate((one) => one.getBoundingClientRect().top)]);
  check(at >= top && at < top + 200, `the heading is at ${at} px, below bars of ${top} px`);

  // Whose pages are in Bokmål is told, and a screen reader reads English as English.
  check(!(await page.getByText("Denne håndboken er på engelsk.").isVisible()), "nothing of language to who reads English");
  await page.goto(`${url}/account`);
  await page.getByLabel("Language of the pages").selectOption("Norsk bokmål");
  await page.getByRole("button", { name: "Choose language" }).click();
  await page.getByText("Sidene er på språket som du valgte.").waitFor();
  await page.goto(`${url}/help/alarms`);
  await page.getByText("Denne håndboken er på engelsk.").waitFor();
  check((await page.locator(".chapter h1").evaluate((one) => one.closest("[lang]").lang)) === "en", "the chapter is English");
  await look(page, "manual in Bokmål");
});
