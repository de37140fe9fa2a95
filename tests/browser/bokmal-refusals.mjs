// Refusals and outcomes in Bokmål: node bokmal-refusals.mjs URL ONE-TIME-PASSWORD. What the server refuses and what became of
// an order is said in the language of who reads it: at the login, in forms, of plans, under commands.

import { check, inBrowser, logIn } from "./browser.mjs";

const [url, oneTime] = process.argv.slice(2);
const BOAT = 0x814;

await inBrowser(async (open) => {
  const guest = await open({ locale: "nb-NO" });
  await guest.goto(`${url}/login`);
  await guest.getByLabel("Navn").fill("nobody");
  await guest.getByLabel("Passord").fill("nothing at all");
  await guest.getByRole("button", { name: "Logg inn" }).click();
  await guest.getByText("Navn eller passord er feil.").waitFor();

  const page = await open();
  await logIn(page, url, "admin", oneTime, "nine grey otters");
  await page.goto(`${url}/account`);
  await page.getByLabel("Language of the pages").selectOption("Norsk bokmål");
  await page.getByRole("button", { name: "Choose language" }).click();
  await page.getByText("Sidene er på språket som du valgte.").waitFor();
  const csrf = await page.evaluate(() => document.querySelector('meta[name="csrf"]').content);

  // Forms of the server: with a value in the words, and without.
  await page.goto(`${url}/admin`);
  const person = page.locator('form[action="/admin/person"]');
  await person.getByLabel("Navn").fill("admin");
  await person.getByRole("button", { name: "Legg til" }).click();
  await page.getByText("Det finnes alt en person admin.").waitFor();
  await page.goto(`${url}/admin/vessels`);
  const vessel = page.locator('form[action="/admin/vessel"]');
  for (const [name, address, told] of [["nord", "here", "here er ikke en IMC-adresse; skriv for eksempel 2068 eller 0x0814."], ["no rd", String(BOAT), "Et fartøys navn har 1 til 64 tegn: bokstaver, sifre og . _ -."]]) {
    await vessel.getByLabel("Navn").fill(name);
    await vessel.getByLabel("IMC-adresse").fill(address);
    await vessel.getByRole("button", { name: "Legg til" }).click();
    await page.getByText(told).waitFor();
  }
  await vessel.getByLabel("Navn").fill("nord");
  await vessel.getByLabel("IMC-adresse").fill(String(BOAT));
  await vessel.getByRole("button", { name: "Legg til" }).click();
  await page.getByRole("link", { name: "nord" }).waitFor();

  // A plan that the API refuses: by template and values, of which the page makes its words.
  const plan = (name) => ({ name, description: "", vessel: null, repeat: false, maneuvers: [] });
  const made = [];
  for (const name of ["nordkysten", "sørkysten"]) made.push(await (await page.request.post(`${url}/api/v1/plans`, { headers: { "x-csrf-token": csrf }, data: plan(name) })).json());
  await page.goto(`${url}/plans/${made[1].id}`);
  await page.locator('body[data-link="up"]').waitFor();
  await page.getByLabel("Planens navn").fill("nordkysten");
  await page.keyboard.press("Enter");
  await page.getByText("En annen plan heter nordkysten; velg et annet navn.").first().waitFor();

  // A table with mistakes: each in Norwegian, a text within a text too. Its words come when they are first needed, and at the
  // next need where that failed.
  await page.route("**/static/nb-rest-*.json", (route) => route.abort(), { times: 1 });
  await page.goto(`${url}/register`);
  await page.getByRole("button", { name: "Importer en tabell" }).click();
  const table = { name: "tags.csv", mimeType: "text/csv", buffer: Buffer.from("protocol,tag_id,animal\nS256,101,Salmon 13\nS256,x,\n") };
  const section = page.getByRole("region", { name: "Importer en tabell" });
  await section.getByLabel("Fil").setInputFiles(table);
  await section.getByText("`x` is not a whole number").waitFor();
  // Once they are here, what stands in English is said again.
  await page.getByRole("button", { name: "Hjelp" }).click();
  await section.getByText("`x` er ikke et helt tall").waitFor();
  await page.keyboard.press("Escape");
  await section.getByLabel("Fil").setInputFiles(table);
  await section.getByText("`Salmon 13` finnes ikke i registeret (dyr); legg det inn i registeret først (dyr), eller la feltet stå tomt").waitFor();
  await section.getByText("`x` er ikke et helt tall").waitFor();

  // What is not there is said by a template too.
  const gone = await page.request.get(`${url}/api/v1/missions/999`);
  const { error } = await gone.json();
  check(error.says?.template === error.text, `a refusal without a template: ${error.text}`);

  // What became of an order: each stage with its reason. English words of the server would be left in it.
  await page.goto(`${url}/vessels/${BOAT}?tab=Control`);
  await page.locator('body[data-link="up"]').waitFor();
  await page.getByRole("button", { name: "STOPP nord", exact: true }).click();
  const stop = page.locator('.commands > li[data-order="vessel.abort"]').first();
  await stop.getByText(/via \w+/).waitFor();
  const said = await stop.locator(".why").allTextContents();
  check(said.every((text) => !/\b(the|by|vessel|it|is)\b/.test(text)), `English is left: ${said.join("; ")}`);
});
