// Alarms and administration by keyboard alone: node keyboard-admin.mjs URL ONE-TIME-PASSWORD. Prints what the boat is to do.

import { check, inBrowser, later } from "./browser.mjs";
import { atKeyboard } from "./keys.mjs";

const [url, oneTime] = process.argv.slice(2);
const PASSWORD = "nine grey otters";

await inBrowser(async (open) => {
  const page = await open();
  const { press, to, act, choose, follow, write } = atKeyboard(page);
  const bar = page.locator("#alarms");

  // The first login: a password of one's own.
  await page.goto(`${url}/login`);
  await to(/^Name/);
  await write("admin");
  await to(/^Password/);
  await write(oneTime);
  await press("Enter");
  await page.waitForURL(/\/account/);
  for (const [label, text] of [["One-time password", oneTime], [/^New password, at least/, PASSWORD], ["New password again", PASSWORD]]) {
    await to(label);
    await write(text);
  }
  await press("Enter");
  await page.getByText("Your password is changed").waitFor();

  // A vessel with its link token, and where that goes.
  await to("Admin", "Shift+Tab");
  await follow(/\/admin$/);
  await to("Vessels");
  await follow(/\/admin\/vessels$/);
  await to("Name");
  await write("otter-0");
  await to("IMC address");
  await write("0x0814");
  await press("Enter");
  await page.getByText("otter-0 is known").waitFor();
  await act("Make link token");
  await page.locator(".secret").getByText(/^lutra_link_/).waitFor();
  const lines = await page.locator("pre.lines").innerText();
  check(lines === `[Transports.Lutra]\nEnabled = Always\nURL = ${url.replace("http", "ws")}/link\nToken File = lutra.token`, lines);
  await page.getByText("0x0814", { exact: true }).waitFor();
  await act("Copy");
  await page.getByText(/^(Copied\.|Marked: copy them with Ctrl and C\.)$/).waitFor();

  // A person: added with a role on the vessel, changed, removed.
  await to("People", "Shift+Tab");
  await follow(/\/admin$/);
  await to("Name");
  await write("nils");
  await choose("Role", "researcher");
  await choose("Vessel", "otter-0");
  await act("Add");
  await page.getByText("One-time password of nils").waitFor();
  const person = page.getByRole("row", { name: /^nils/ });
  await person.getByText("researcher").first().waitFor();
  for (let stop = 0; ; stop++) {
    check(stop < 20, "Tab does not come to Change of nils");
    await act("Change");
    if (await person.locator("details[open]").count()) break;
    // Another person's, which is folded again.
    await press("Enter", "Tab");
  }
  await act(/^Remove nils …/);
  await act("Remove nils now");
  await person.waitFor({ state: "detached" });

  // A token of one's own: made and revoked.
  await to("admin", "Shift+Tab");
  await follow(/\/account$/);
  await to("What for");
  await write("R on my desk");
  await act("Make token");
  const token = await page.locator(".secret").innerText();
  const me = () => page.request.get(`${url}/api/v1/me`, { headers: { authorization: `Bearer ${token}` } });
  check((await me()).ok(), "the token opens");
  await to("Admin", "Shift+Tab");
  await follow(/\/admin$/);
  await to("Tokens");
  await follow(/\/admin\/tokens$/);
  // The vessel's is there too.
  for (const left of [2, 1]) {
    await page.waitForFunction((left) => document.querySelectorAll("tbody tr").length === left, left);
    await act(/^Revoke .*…$/);
    await act(/^Revoke .* now$/);
  }
  await page.getByText("No tokens.").waitFor();
  check((await me()).status() === 401, "the token opens nothing");

  // An alarm: opened in the bar, acknowledged; another shelved with a reason; the list closed by Escape.
  const worst = (text) => bar.locator(".alarm-bar .worst").getByText(text);
  console.log("empty");
  await later(worst(/otter-0: 24 % charge left/), 3);
  await act(/otter-0: 24 % charge left/, "Shift+Tab");
  await page.getByRole("region", { name: "Alarms" }).waitFor();
  await act(/^Acknowledge: otter-0: 24 % charge left/);
  await bar.locator('[data-alarm="battery"]').getByText(/acknowledged by admin/).waitFor();
  console.log("full");
  await later(worst("No alarms"), 16);
  console.log("lost");
  await later(worst(/otter-0: Navigation: error/), 2);
  await act("Shelve …");
  await choose(/^For how long: otter-0: Navigation/, "30 min");
  await to(/^Why: otter-0: Navigation/);
  await write("antenna is being changed");
  await act("Shelve");
  await worst("No alarms; 1 shelved").waitFor();
  await bar.locator('[data-alarm="position"]').getByText(/shelved by admin: antenna is being changed/).waitFor();
  await act("Recent events");
  await bar.locator(".alarm-past").getByText(/otter-0: alarm shelved by admin: antenna is being changed/).waitFor();
  await press("Escape");
  await page.getByRole("region", { name: "Alarms" }).waitFor({ state: "hidden" });
});
