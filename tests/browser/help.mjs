// Help by `?`: node help.mjs URL ONE-TIME-PASSWORD. Prints what the boat does.

import { check, inBrowser, logIn, look } from "./browser.mjs";

const [url, oneTime] = process.argv.slice(2);

await inBrowser(async (open) => {
  const page = await open();
  await logIn(page, url, "admin", oneTime, "battery horse staple");
  await page.getByText("Live", { exact: true }).waitFor();
  const help = page.getByRole("dialog", { name: "Help" });
  const term = (name) => help.getByRole("term").getByText(name, { exact: true });
  await page.keyboard.press("?");
  await help.waitFor();
  await term("Chart datum").waitFor();
  check((await help.getByText("In replay: play and pause").count()) === 0, "keys of other pages are not listed");
  await look(page, "help");
  // It is searched, and says where it has nothing.
  const search = help.getByRole("textbox", { name: "Search in help" });
  await search.fill("knots");
  check(!(await term("Chart datum").isVisible()), "what does not match is gone");
  await term("Speed over ground (SOG)").waitFor();
  await search.fill("zeppelin");
  await help.getByText("No matching help topics.").waitFor();
  await page.keyboard.press("Escape");
  await help.waitFor({ state: "hidden" });
  // A field keeps its letters; a press on the button does the same as the key.
  await page.goto(`${url}/detections`);
  await page.getByRole("textbox", { name: "Tags" }).press("?");
  check((await page.getByRole("textbox", { name: "Tags" }).inputValue()) === "?", "typed");
  check(!(await help.isVisible()), "no help in the middle of a word");
  await page.getByRole("button", { name: "Help" }).click();
  await help.waitFor();
});
