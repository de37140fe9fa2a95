// The pages in Bokmål: node bokmal.mjs URL ONE-TIME-PASSWORD. Of two boats the first stops when it is told to. Nothing is cut
// off at 390 and 1440 px, no English stands where the catalogue has words, and STOP works.

import { check, fits, inBrowser, logIn, look } from "./browser.mjs";

const [url, oneTime] = process.argv.slice(2);
const BOAT = 0x814;
const SIZES = [{ width: 390, height: 844 }, { width: 1440, height: 900 }];

/** Texts of one line that are cut off, or stick out of what holds them. */
const cut = (page) =>
  page.evaluate(() =>
    [...document.querySelectorAll(".tile dt, .tile .reading, .fact > *, .system .doing > *, .system .name, #stop .halt, .vessel-head > *, .bar a, .bar button, .tabs > *, .row > button, .alarm-bar > *, .wide:not(.scroll) th[scope=col]")]
      .filter((node) => node.checkVisibility() && getComputedStyle(node).fontSize !== "0px")
      .filter((node) => {
        const box = node.getBoundingClientRect();
        const clip = node.closest("dd, .tile, .fact, .system, .vessel-head, .bar, .tabs, table, .row, .alarm-bar").getBoundingClientRect();
        return (node.scrollWidth > node.clientWidth + 1 && getComputedStyle(node).display !== "inline") || (!node.closest(".tabs, .bar") && (box.right > clip.right + 1 || box.left < clip.left - 1));
      })
      .map((node) => `${node.className || node.localName}: ${node.textContent}`),
  );

/** Words that are English only, in texts of the page, its labels and what stands beside the pointer; what vessels and the
 * server say stays English. */
const english = (page) =>
  page.evaluate(() => {
    const words = /\b(the|and|with|from|nothing|not|vessel|vessels|show|choose|none|newest|heard|you|your|of|by)\b/i;
    const said = ".said, code, pre, .why, dd, td, option[value*='/'], [data-tile] .note-line, .alarm-bar .worst, #alarms li, [lang=en], .chart-credit, .brand, .num";
    const texts = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
    const found = [];
    for (let node = texts.nextNode(); node; node = texts.nextNode()) {
      const parent = node.parentElement;
      if (words.test(node.data) && parent.checkVisibility() && !parent.closest(`${said}, script, style, noscript`)) found.push(node.data.trim());
    }
    for (const node of document.querySelectorAll("[aria-label], [title], [placeholder]")) {
      for (const name of ["aria-label", "title", "placeholder"]) {
        const text = node.getAttribute(name) ?? "";
        if (words.test(text) && !node.closest(said)) found.push(`${name}: ${text}`);
      }
    }
    return found;
  });

await inBrowser(async (open) => {
  const page = await open();
  const stays = async (where) => {
    for (const size of SIZES) {
      await page.setViewportSize(size);
      await fits(page, `${where} at ${size.width} px`);
      const clipped = await cut(page);
      check(!clipped.length, `${where} at ${size.width} px: cut off: ${clipped.join("; ")}`);
    }
    const left = await english(page);
    check(!left.length, `${where}: English is left: ${left.join("; ")}`);
  };

  // Who has not come in yet is asked in the browser's language.
  const guest = await open({ locale: "nb-NO" });
  await guest.goto(`${url}/login`);
  await guest.getByRole("heading", { name: "Logg inn" }).waitFor();
  await guest.getByLabel("Passord").waitFor();
  await look(guest, "bokmal-login");

  // Chosen on the account page, it goes with the person.
  await logIn(page, url, "admin", oneTime, "nine grey otters");
  const other = await page.context().newPage();
  await other.goto(url);
  await other.locator('body[data-link="up"]').waitFor();
  await page.goto(`${url}/account`);
  await page.getByRole("heading", { name: "Språk" }).waitFor();
  await page.getByLabel("Language of the pages").selectOption("Norsk bokmål");
  await page.getByRole("button", { name: "Choose language" }).click();
  await page.getByText("Sidene er på språket som du valgte.").waitFor();
  check((await page.locator("html").getAttribute("lang")) === "nb", "the page says its language");
  // A page that is open in another tab offers to be loaded again, and is left as it is until then.
  await other.getByText("Another language was chosen in another tab.").waitFor();
  await other.getByRole("button", { name: "Load the page again" }).click();
  await other.getByText("Direkte", { exact: true }).waitFor();
  await other.close();
  await stays("account");
  await look(page, "bokmal-account");
  const csrf = await page.evaluate(() => document.querySelector('meta[name="csrf"]').content);
  for (const [name, address] of [["nord", BOAT], ["sor", BOAT + 1]]) await page.request.post(`${url}/admin/vessel`, { form: { csrf, name, address: String(address) }, headers: { origin: url } });

  // STOP first: in Bokmål whole, and it stops.
  await page.goto(url);
  await page.locator('body[data-link="up"]').waitFor();
  await page.getByRole("list", { name: "Fartøy" }).getByRole("button", { name: /nord/ }).waitFor();
  await page.getByRole("button", { name: "STOPP ALLE", exact: true }).click();
  const question = page.getByRole("alertdialog", { name: "Stopp alle fartøy" });
  await question.getByText("Dette stopper 2 fartøy. Trykk igjen innen 5 s.").waitFor();
  await page.getByRole("button", { name: "BEKREFT STOPP 2" }).waitFor();
  await stays("the question of STOP ALL");
  await look(page, "bokmal-stop-all");
  await page.keyboard.press("Escape");
  await question.waitFor({ state: "hidden" });
  await page.goto(`${url}/vessels/${BOAT}`);
  await page.getByText("Direkte", { exact: true }).waitFor();
  await page.getByRole("button", { name: "STOPP nord", exact: true }).click();
  await page.getByText(/^STOPP nord: stoppet etter \d+\.\d s\. Motorer av, driver\.$/).waitFor();
  await stays("a stop");
  await look(page, "bokmal-stop");

  // A question before a vessel moves is in one language too.
  await page.goto(`${url}/vessels/${BOAT + 1}?tab=Control`);
  await page.getByRole("tab", { name: "Kommando", selected: true }).waitFor();
  await page.getByRole("button", { name: "Ta kommandoen", exact: true }).click();
  await page.getByText("Du har kommandoen over dette fartøyet.").waitFor();
  await page.getByLabel("Breddegrad, °").fill("63.44");
  await page.getByLabel("Lengdegrad, °").fill("10.4");
  await page.getByRole("button", { name: "Gå dit …" }).click();
  const sure = page.getByRole("group", { name: "Sende sor dit?" });
  await sure.getByRole("button", { name: "Avbryt" }).waitFor();
  await stays("the question before a way");
  await look(page, "bokmal-question");
  await page.keyboard.press("Escape");

  // Main pages, and each tab of a vessel.
  for (const path of ["/", "/plans", "/detections", "/logbook", "/missions", "/no-go-areas", "/data", "/explore", "/alarms", "/admin", "/admin/vessels", "/admin/connections", "/admin/storage", "/admin/import", "/admin/tokens", "/admin/sessions", "/admin/audit"]) {
    await page.goto(url + path);
    await page.getByText("Direkte", { exact: true }).waitFor();
    if (path === "/") await page.getByRole("list", { name: "Fartøy" }).getByText("Utfører manøver").first().waitFor();
    await stays(path);
    await look(page, `bokmal${path.replaceAll("/", "-")}`);
  }
  for (const [tab, words] of [["Plots", "Plott"], ["Values", "Verdier"], ["Entities", "Deler"], ["Log book", "Loggbok"], ["Tags", "Merker"], ["Link loss", "Sambandsbrudd"], ["Parameters", "Parametre"]]) {
    await page.goto(`${url}/vessels/${BOAT + 1}?tab=${encodeURIComponent(tab)}`);
    await page.getByRole("tab", { name: words, selected: true }).waitFor();
    await page.locator('[data-tile="mode"]').getByText("Utfører manøver").waitFor();
    await stays(tab);
    await look(page, `bokmal-${tab.toLowerCase().replace(" ", "-")}`);
  }

  // A plan: its names stay what they are for every crew.
  await page.goto(`${url}/plans`);
  await page.getByRole("button", { name: "Ny plan" }).click();
  await page.getByRole("button", { name: "Gå til", exact: true }).waitFor();
  await page.getByRole("button", { name: "Legg til", exact: true }).click();
  await page.getByRole("button", { name: /^1 Goto 1/ }).waitFor();
  await stays("the editor of a plan");
  await look(page, "bokmal-plan");
  await page.keyboard.press("?");
  await page.getByRole("dialog").getByText("Kurs over grunn (COG)").waitFor();
  await look(page, "bokmal-help");
});
