// The register: node register.mjs URL ONE-TIME-PASSWORD. Prints nothing. A biologist registers an animal and its tag, and brings in a
// table with a mistake, then without.

import { check, fits, inBrowser, logIn, look, same } from "./browser.mjs";

const [url, oneTime] = process.argv.slice(2);
const file = (text) => ({ name: "tags.csv", mimeType: "text/csv", buffer: Buffer.from(text) });

await inBrowser(async (open) => {
  const page = await open();
  await logIn(page, url, "admin", oneTime, "battery horse staple");
  await page.getByRole("link", { name: "Data", exact: true }).click();
  await page.getByRole("navigation", { name: "Data" }).getByRole("link", { name: "Register" }).click();
  await page.getByText("No tags yet. Add one, or import a table").waitFor();
  await look(page, "register-empty");

  // The animal first; what is missing is said at its field, which has the focus.
  await page.getByRole("navigation", { name: "Kinds of entries" }).getByRole("link", { name: "Animals" }).click();
  await page.getByRole("button", { name: "Add an animal" }).press("Enter");
  const animal = page.getByRole("form", { name: "Add an animal" });
  await animal.getByRole("button", { name: "Save" }).press("Enter");
  await animal.getByText("This is needed.").waitFor();
  check(await animal.getByLabel("Name", { exact: true }).evaluate((node) => node === document.activeElement), "the name has the focus");
  await page.keyboard.type("Salmon 12");
  await animal.getByLabel("Scientific name").fill("Salmo salar");
  await animal.getByLabel("Length, mm").fill("512,5");
  await animal.getByRole("button", { name: "Save" }).press("Enter");
  await page.getByRole("rowheader", { name: "Salmon 12" }).waitFor();

  await page.getByRole("navigation", { name: "Kinds of entries" }).getByRole("link", { name: "Tags" }).click();
  await page.getByRole("button", { name: "Add a tag" }).click();
  const tag = page.getByRole("form", { name: "Add a tag" });
  await tag.getByLabel("Protocol, such as R64K").fill("S256");
  await tag.getByLabel("Number", { exact: true }).fill("101");
  await tag.getByLabel("Animal", { exact: true }).selectOption("Salmon 12");
  await look(page, "register-form");
  await fits(page, "the form of a tag");
  await tag.getByRole("button", { name: "Save" }).click();
  await page.getByRole("rowheader", { name: "S256-101" }).waitFor();

  // A file with mistakes changes nothing and tells all of them.
  await page.getByRole("button", { name: "Import a table" }).click();
  const section = page.getByRole("region", { name: "Import a table" });
  await section.getByLabel("File").setInputFiles(file("protocol,tag_id,animal,sensor_slope\nS256,101,Salmon 13,0.2\nS256,x,,\n"));
  await section.getByText("2 problems: correct them").waitFor();
  await section.getByText("no animal is called `Salmon 13`; did you mean `Salmon 12`?").waitFor();
  await look(page, "register-problems");
  same(await section.getByRole("button", { name: "Import into the register" }).count(), 0, "nothing to take");
  await section.getByLabel("File").setInputFiles(file("protocol,tag_id,animal,sensor_slope\nS256,101,Salmon 12,0.2\nS256,102,,\n"));
  await section.getByText("1 new. 1 changed.").waitFor();
  await section.getByText("sensor_slope: – → 0.2").waitFor();
  await section.getByRole("button", { name: "Import into the register" }).click();
  await section.getByText("Imported. 1 new. 1 changed.").waitFor();
  await page.getByRole("rowheader", { name: "S256-102" }).waitFor();

  // What another refers to is not deleted, and why is told.
  await page.getByRole("navigation", { name: "Kinds of entries" }).getByRole("link", { name: "Animals" }).click();
  await page.getByRole("button", { name: "Change Salmon 12" }).click();
  const question = page.getByRole("group", { name: "Delete Salmon 12 from the register?" });
  await page.getByRole("button", { name: "Delete", exact: true }).click();
  await question.getByText("Delete Salmon 12 from the register?").and(page.locator(":focus")).waitFor();
  // It is the page's own: STOP works while it stands.
  await page.keyboard.press("Control+.");
  await page.locator("#stop details[open] button").first().waitFor();
  await page.locator("#stop summary").click();
  await page.keyboard.press("Escape");
  await question.getByRole("button", { name: "Cancel" }).click();
  await question.waitFor({ state: "hidden" });
  await page.getByRole("button", { name: "Delete", exact: true }).and(page.locator(":focus")).waitFor();
  await page.keyboard.press("Enter");
  await question.getByRole("button", { name: "Delete" }).click();
  await page.getByText(/tag `S256-101`: no animal is called `Salmon 12`/).waitFor();
});
