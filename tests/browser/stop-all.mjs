// STOP of all vessels in two steps: node stop-all.mjs URL ONE-TIME-PASSWORD. Of two boats the first stops when it is told to.

import { check, inBrowser, logIn, look } from "./browser.mjs";

const [url, oneTime] = process.argv.slice(2);

await inBrowser(async (open) => {
  const page = await open();
  await logIn(page, url, "admin", oneTime, "nine grey otters");
  const csrf = await page.evaluate(() => document.querySelector('meta[name="csrf"]').content);
  // Besides the two that are heard there is one with a name that nobody hears.
  for (const [name, address] of [["northern", 0x0814], ["southern", 0x0815], ["unheard", 0x0900]]) {
    const named = await page.request.post(`${url}/admin/vessel`, { form: { csrf, name, address: String(address) }, headers: { origin: url } });
    check(named.ok(), await named.text());
  }
  const asked = [];
  page.on("request", (request) => /\/vessels\/\d+\/abort/.test(request.url()) && asked.push(request.url()));
  await page.goto(url);
  const all = page.getByRole("button", { name: "STOP ALL", exact: true });
  const confirm = page.getByRole("button", { name: "CONFIRM STOP 3" });
  const question = page.getByRole("alertdialog", { name: "Stop all vessels" });
  await page.getByRole("list", { name: "Vessels" }).getByRole("button", { name: /northern/ }).waitFor();
  await all.waitFor();

  // The first step stops nothing: it names whom it is about, in the same place, and is over by itself.
  const before = await all.boundingBox();
  await all.click();
  await confirm.waitFor();
  const after = await confirm.boundingBox();
  check(after.x === before.x && after.width === before.width && after.y === before.y, `it stands where it stood: ${JSON.stringify([before, after])}`);
  check((await question.getByRole("listitem").allInnerTexts()).join() === "northern,southern,unheard (not heard)", await question.innerText());
  await question.getByText("This stops 3 vessels.").waitFor();
  await look(page, "stop-all");
  await all.waitFor();
  await question.waitFor({ state: "hidden" });
  // So it is by Escape, by Cancel, and by a press that only bounced.
  await all.click();
  await page.keyboard.press("Escape");
  await question.waitFor({ state: "hidden" });
  await all.click();
  await question.getByRole("button", { name: "Cancel" }).click();
  await question.waitFor({ state: "hidden" });
  await all.dblclick();
  await confirm.waitFor();
  check(asked.length === 0 && (await page.locator("#orders .order").count()) === 0, `nothing is stopped by one press: ${asked}`);

  // The second step stops each of them, by keys too, and tells what became of each.
  await page.waitForTimeout(500);
  await page.keyboard.press("Enter");
  await page.getByText(/^STOP northern: stopped after \d+\.\d s\. Motors off, drifting\.$/).waitFor();
  await page.getByText(/^STOP unheard: NOT SENT YET\. No way leads to the vessel\./).waitFor();
  await page.getByText(/^STOP southern: sent, but NO EFFECT SEEN in 8 s; it reports: Executing maneuver\./).waitFor();
  check(new Set(asked.map((one) => /\d+(?=\/abort)/.exec(one)[0])).size === 3, `a request for each: ${asked}`);
  await look(page, "stop-all-told");

  // STOP of one vessel is one press, as ever.
  await page.getByRole("button", { name: "Close: STOP northern" }).click();
  await page.locator("#stop .aim button").click();
  await page.getByText(/^STOP northern: stopped after \d+\.\d s\. Motors off, drifting\.$/).waitFor();
});
