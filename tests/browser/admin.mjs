// Login, account and administration: node admin.mjs URL ONE-TIME-PASSWORD

import { check, inBrowser, logIn, look } from "./browser.mjs";

const [url, oneTime] = process.argv.slice(2);

await inBrowser(async (open) => {
  const page = await open();

  // Whoever is not logged in gets to the login, and from there to where they wanted.
  await page.goto(`${url}/admin/audit`);
  check(page.url().includes("/login?next="), `anonymous at ${page.url()}`);
  await look(page, "login");
  await page.getByLabel("Name").fill("admin");
  await page.getByLabel("Password").fill("a guess");
  await page.keyboard.press("Enter");
  await page.getByRole("alert").getByText("Name or password is wrong").waitFor();

  await logIn(page, url, "admin", oneTime);
  check(page.url().endsWith("/account"), "a one-time password must be changed first");
  await page.goto(`${url}/admin`);
  check(page.url().endsWith("/account"), "nothing else is open before that");
  await look(page, "one-time");
  await logIn(await open(), url, "admin", oneTime, "nine grey otters");
  await page.goto(`${url}/account`);
  check(page.url().includes("/login"), "the other session ended with the old password");
  await logIn(page, url, "admin", "nine grey otters");

  // A vessel with its link token, a person with a role on it.
  await page.getByRole("link", { name: "Admin", exact: true }).click();
  await page.getByRole("link", { name: "Vessels" }).click();
  await page.getByText("No vessel has a name yet").waitFor();
  await page.getByLabel("Name").fill("otter-1");
  await page.getByLabel("IMC address").fill("0x0814");
  await page.getByRole("button", { name: "Add" }).click();
  await page.getByText("otter-1 is known").waitFor();
  await page.getByRole("button", { name: "Make link token" }).click();
  check((await page.locator(".secret").innerText()).startsWith("lutra_link_"), "the link token is shown");
  await look(page, "admin-vessels");
  await page.getByRole("link", { name: "People" }).click();
  await page.getByLabel("Name").fill("nils");
  await page.locator("main form.card").getByLabel("Role").selectOption("researcher");
  await page.locator("main form.card").getByLabel("Vessel").selectOption("otter-1");
  await page.getByRole("button", { name: "Add" }).click();
  const password = await page.locator(".secret").innerText();
  await look(page, "admin-people");
  await page.getByRole("row", { name: /^admin/ }).getByText("Change", { exact: true }).click();
  // What is lost for ever is asked for first, with what goes.
  const remove = page.getByRole("button", { name: "Remove admin now" });
  check(!(await remove.isVisible()), "nobody is removed by one click");
  await page.getByText("Remove admin …", { exact: true }).click();
  await page.getByText(/^Remove admin\? This ends at once and cannot be brought back: admin on all vessels; \d sessions?; no tokens\./).waitFor();
  await look(page, "admin-remove");
  await remove.click();
  await page.getByRole("alert").getByText("the last admin stays until another person is one").waitFor();

  // The other person comes in, makes a token and sees no administration.
  const other = await open();
  await logIn(other, url, "nils", password, "seven small boats");
  check((await other.getByRole("link", { name: "Admin", exact: true }).count()) === 0, "a researcher sees no Admin");
  for (const path of ["/admin", "/admin/connections", "/admin/storage"]) {
    check((await other.goto(url + path)).status() === 403, `and is refused at ${path}`);
  }
  await other.goto(`${url}/account`);
  await other.getByLabel("What for").fill("R on my desk");
  await other.getByRole("button", { name: "Make token" }).click();
  const token = await other.locator(".secret").innerText();
  const me = await other.request.get(`${url}/api/v1/me`, { headers: { authorization: `Bearer ${token}` } });
  check((await me.json()).name === "nils", "the token acts for its person");
  await look(other, "account");

  // The admin ends that session and revokes the token.
  await page.getByRole("link", { name: "Sessions" }).click();
  await look(page, "admin-sessions");
  const session = page.getByRole("row", { name: /nils/ });
  await session.getByText("End the session of nils from 127.0.0.1 …").click();
  await session.getByText(/End this session\? nils is logged out there at once, from 127\.0\.0\.1, login 20/).waitFor();
  await look(page, "admin-end");
  await session.getByRole("button", { name: "End the session now" }).click();
  // Its page notices by itself.
  await other.waitForURL(/\/login/);
  await page.getByRole("link", { name: "Tokens" }).click();
  await look(page, "admin-tokens");
  const script = page.getByRole("row", { name: /R on my desk/ });
  check(!(await script.getByRole("button").isVisible()), "no token is revoked by one click");
  await script.getByText("Revoke R on my desk …").click();
  await script.getByText("Scripts that use it in the name of nils are refused at once.").waitFor();
  await look(page, "admin-revoke");
  await script.getByRole("button", { name: "Revoke R on my desk now" }).click();
  await page.getByRole("row", { name: /R on my desk/ }).waitFor({ state: "detached" });
  const gone = await other.request.get(`${url}/api/v1/me`, { headers: { authorization: `Bearer ${token}` } });
  check(gone.status() === 401, "the token opens nothing");
  await page.getByRole("link", { name: "Audit" }).click();
  for (const action of ["Name vessel", "Add person", "Make token", "End session", "Revoke token"]) {
    await page.getByRole("cell", { name: action, exact: true }).first().waitFor();
  }
  await page.getByRole("combobox", { name: /^What/ }).selectOption("Make token");
  await page.getByRole("button", { name: "Show", exact: true }).click();
  check((await page.getByRole("cell", { name: "Add person" }).count()) === 0, "filtered by what was done");
  await look(page, "admin-audit");

  // The transports: the link is open, the others say what opens them; whoever comes without a token is counted.
  await page.getByRole("link", { name: "Connections" }).click();
  const transports = page.getByRole("region", { name: "Transports" });
  await transports.getByRole("row", { name: /Vessel link ws:\/\/127\.0\.0\.1:\d+\/link 0 0 0 0 none none/ }).waitFor();
  await transports.getByRole("row", { name: /IMCProxy closed set transports\.imcproxy\.listen/ }).waitFor();
  await page.getByText("No vessel has come in by its link").waitFor();
  const stranger = await page.request.get(`${url}/link`, { headers: { authorization: "Bearer lutra_link_guess" } });
  check(stranger.status() === 401, `a guessed token: ${stranger.status()}`);
  await page.getByRole("link", { name: "Refresh" }).click();
  await transports.getByRole("row", { name: /\/link 0 0 1 0 20.*Z: 127\.0\.0\.1: no token of a vessel's link/ }).waitFor();
  await look(page, "admin-transports");

  // Storage: an empty one says what to do; what would go is told by dates, with the command.
  await page.getByRole("link", { name: "Storage" }).click();
  // No vessel was here; the server's own words may be.
  await page.getByText(/^(Nothing is recorded yet|this server)/).first().waitFor();
  await page.getByRole("row", { name: /Free on its disk .* of .*, \d+ % full/ }).waitFor();
  await page.getByRole("row", { name: /people ● well 2 accounts/ }).waitFor();
  await page.getByText(/lutra-server --data .* backup/).waitFor();
  await page.getByLabel(/^Months of the history/).fill("tomorrow");
  await page.getByRole("button", { name: "Show what would be removed" }).click();
  await page.getByRole("alert").getByText("tomorrow: no time in ISO 8601").waitFor();
  await page.getByLabel(/^Months of the history/).fill("2026-01-01");
  await page.getByRole("button", { name: "Show what would be removed" }).click();
  await page.getByText("Nothing is as old as that.").waitFor();
  await look(page, "admin-storage");

  // Palette and logout are remembered by the server.
  await page.getByRole("button", { name: "Night" }).click();
  check((await page.locator("html").getAttribute("data-palette")) === "night", "the palette is kept");
  await page.getByRole("button", { name: "Log out" }).click();
  // By the form, or by the page that notices first that the session is over.
  await page.waitForURL((url) => url.pathname === "/login");

  // All of this is forms: it works without scripts.
  const plain = await open({ javaScriptEnabled: false });
  await logIn(plain, url, "admin", "nine grey otters");
  await plain.getByRole("link", { name: "Admin", exact: true }).click();
  await plain.getByRole("heading", { name: "People" }).waitFor();
  await plain.getByRole("row", { name: /^nils/ }).getByText("Change", { exact: true }).click();
  await plain.getByText("Remove nils …", { exact: true }).click();
  await plain.getByText("researcher on otter-1; 0 sessions; no tokens").waitFor();
  await plain.getByRole("button", { name: "Remove nils now" }).click();
  await plain.getByText("nils is removed.").waitFor();
  await plain.getByRole("link", { name: "Audit" }).click();
  await plain.getByRole("cell", { name: "Remove person" }).first().waitFor();
});
