// Parameters of a vessel of another program, with hostile names and values: node foreign.mjs URL ONE-TIME-PASSWORD.

import { check, inBrowser, later, logIn, look } from "./browser.mjs";

const [url, oneTime] = process.argv.slice(2);

await inBrowser(async (open) => {
  const page = await open();
  await logIn(page, url, "admin", oneTime, "nine grey otters");
  await page.goto(`${url}/vessels/2068?tab=Parameters`);
  const box = page.getByRole("tabpanel", { name: "Parameters" });
  await box.getByRole("textbox", { name: "Sample Rate of Navigation" }).waitFor();
  await box.getByText("Read. 1 part of the vessel reported no parameters.").waitFor();
  check((await box.getByText("no description: not a parameter known to Lutra").count()) > 4, "nothing is made up");
  check((await box.locator("img, script, b").count()) === 0, "text from a vessel stays text");
  await box.getByText("<img src=x onerror=alert(1)>").first().waitFor();
  const long = box.getByRole("textbox", { name: /^nnnn/ }).first();
  check((await long.getAttribute("aria-label")).length < 150 && (await long.inputValue()).length === 1_000, "what is enormous is cut");
  check(await long.evaluate((node) => node.readOnly && node.title.includes("Too long")), "what was cut is not written back");
  const wide = await page.evaluate(() => document.documentElement.scrollWidth <= window.innerWidth);
  check(wide, "the page is not wider than its window");
  await look(page, "params-foreign");

  // It is written only after a second look, and what comes of it is told: this vessel never answers.
  await page.getByRole("tab", { name: "Control" }).click();
  await page.getByRole("button", { name: "Take control", exact: true }).click();
  await page.getByText("You have control of this vessel.").waitFor();
  await page.getByRole("tab", { name: "Parameters" }).click();
  await box.getByRole("textbox", { name: "Sample Rate of Navigation" }).fill("6");
  await box.getByRole("button", { name: "Write 1" }).click();
  await box.getByText("Take care: its meaning is unknown to Lutra.").waitFor();
  await box.getByRole("button", { name: "Write to vessel" }).click();
  await later(box.getByText(/timed out: .*The vessel reports 5\./), 5);
  check((await box.getByRole("textbox", { name: "Sample Rate of Navigation" }).inputValue()) === "6", "what was typed stays");
});
