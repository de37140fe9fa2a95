// A rule of messages is changed in its place: node notices-change.mjs URL ONE-TIME-PASSWORD. Prints nothing.

import { check, inBrowser, logIn, look, same } from "./browser.mjs";

const [url, oneTime] = process.argv.slice(2);

await inBrowser(async (open) => {
  const page = await open();
  await logIn(page, url, "admin", oneTime, "nine grey otters");
  const csrf = await page.evaluate(() => document.querySelector('meta[name="csrf"]').content);
  await page.request.post(`${url}/admin/vessel`, { form: { csrf, name: "otter-0", address: "2068" }, headers: { origin: url } });
  await page.goto(`${url}/account`);
  const part = page.getByRole("region", { name: "Messages about alarms" });
  await part.getByLabel("Address or URL").fill("http://127.0.0.1:9/before");
  await part.getByRole("button", { name: "Add rule" }).click();
  const row = (text) => part.getByRole("list", { name: "Your rules" }).getByRole("listitem").filter({ hasText: text });
  await row("/before").getByText("alarm and worse, all vessels, at once").waitFor();

  // Its form shows what it says, by keyboard too.
  const change = row("/before").locator("summary", { hasText: /^Change/ });
  await change.press("Enter");
  const form = row("/before").locator('form[action$="/change"]');
  same(await form.getByLabel("Address or URL").inputValue(), "http://127.0.0.1:9/before", "where to");
  same(await form.getByLabel("Least priority").inputValue(), "alarm", "how urgent");
  same([await form.getByLabel("Vessel").inputValue(), await form.getByRole("combobox", { name: /^When/ }).inputValue()], ["", "0"], "of which, and when");
  // Where the page is scrolled by a little, its bar covers a part of what lies under it.
  await page.evaluate(() => scrollTo(0, 0));
  await look(page, "notices-change");

  // What cannot be is said, the rule stays, and what was typed stands in its form.
  await form.getByLabel("Address or URL").fill("nowhere");
  await form.getByRole("button", { name: "Save the rule" }).click();
  await page.getByRole("alert").getByText('"nowhere" is not a URL; give one like https://example.org/hook.').waitFor();
  await row("/before").getByText("alarm and worse, all vessels, at once").waitFor();

  same(await form.getByLabel("Address or URL").inputValue(), "nowhere", "what was typed");
  const refused = page.locator('input[aria-invalid="true"]');
  same([await refused.inputValue(), await refused.evaluate((one) => document.activeElement === one)], ["nowhere", true], "the field that was refused, ready to be mended");
  check((await refused.evaluate((one) => document.getElementById(one.getAttribute("aria-describedby")).textContent)).includes("is not a URL"), "and why");
  await form.getByLabel("Address or URL").fill("http://127.0.0.1:9/after");
  await form.getByLabel("Least priority").selectOption("warning");
  await form.getByLabel("Vessel").selectOption("otter-0");
  await form.getByRole("combobox", { name: /^When/ }).selectOption({ label: "not acknowledged for 5 min" });
  await form.getByLabel("Also when it is over").check();
  await form.getByRole("button", { name: "Save the rule" }).click();
  await page.getByRole("status").getByText("The rule is changed.").waitFor();
  await row("/after").getByText("warning and worse, otter-0, not acknowledged for 5 min; and when it is over").waitFor();
  check((await row("http").count()) === 1, "it is the same rule");

  // A new rule that cannot be likewise.
  const adding = part.locator('form[action$="/notice"]');
  await adding.getByLabel("Address or URL").fill("nowhere either");
  await adding.getByLabel("Least priority").selectOption("caution");
  await adding.getByRole("button", { name: "Add rule" }).click();
  await page.getByRole("alert").getByText('"nowhere either" is not a URL').waitFor();
  same([await adding.getByLabel("Address or URL").inputValue(), await adding.getByLabel("Least priority").inputValue()], ["nowhere either", "caution"], "what was typed");
  same(await row("/after").locator("details.change[open]").count(), 0, "the form of another rule");
  await page.goto(`${url}/admin/audit`);
  await page.getByRole("cell", { name: "Change rule for messages" }).waitFor();
});
