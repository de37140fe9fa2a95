// Datasets and links: node datasets.mjs URL ONE-TIME-PASSWORD. Prints nothing. A biologist makes a dataset of what the explorer shows,
// publishes it, and gives it to a colleague without an account; then takes the link back, and gives it to an account without a role.

import { createHash } from "node:crypto";
import { readFile } from "node:fs/promises";
import { check, fits, inBrowser, logIn, look, same, table } from "./browser.mjs";

const [url, oneTime] = process.argv.slice(2);
const PASSWORD = "nine grey otters";

const fetched = async (page, press) => {
  const saved = page.waitForEvent("download");
  await press();
  return readFile(await (await saved).path());
};
/** In two steps, which are of the page and hold nothing else up. */
const publish = async (page) => {
  const main = await page.locator('section[aria-label="Draft"] .main').allTextContents();
  check(main.length === 1, `one main button: ${main}`);
  await page.getByRole("button", { name: "Publish version 1" }).click();
  await page.getByRole("group", { name: "Publish it? What is published never changes." }).getByRole("button", { name: "Publish version 1" }).click();
};
const sha256 = (bytes) => createHash("sha256").update(bytes).digest("hex");

await inBrowser(async (open) => {
  const page = await open();
  await logIn(page, url, "admin", oneTime, "battery horse staple");
  await page.getByRole("link", { name: "Data", exact: true }).click();
  await page.getByRole("navigation", { name: "Data" }).getByRole("link", { name: "Datasets" }).click();
  await page.getByText(/^No datasets yet\. A dataset is a selection of detections/).waitFor();
  await look(page, "datasets-empty");
  const csrf = await page.evaluate(() => document.querySelector('meta[name="csrf"]').content);
  const add = (record) => page.request.post(`${url}/api/v1/register`, { headers: { "x-csrf-token": csrf }, data: record });
  for (const name of ["Nordmann, Kari", "Hansen, Ola"]) await add({ kind: "person", name, affiliation: "NTNU" });

  // What the explorer shows becomes the question of a draft.
  await page.goto(`${url}/explore?tag=101`);
  await page.getByText(/^74[23] detections\.$/).waitFor();
  await page.getByRole("link", { name: "Make a dataset of this" }).click();
  const form = page.getByRole("form", { name: "New dataset" });
  await form.waitFor();
  same(await form.getByLabel("Tags", { exact: true }).inputValue(), "101", "the explorer's tag");
  await form.getByRole("button", { name: "Save the draft" }).click();
  await form.getByText("Give it a title.").waitFor();
  check(await form.getByLabel("Title").evaluate((node) => node === document.activeElement), "the title has the focus");
  await page.keyboard.type("Salmon in the fjord");
  await form.getByLabel(/^Description/).fill("Heard by one boat in 2026.\nReceivers were not synchronised.");
  for (const name of ["Hansen, Ola", "Nordmann, Kari"]) await form.getByLabel(/^Authors/).selectOption(name);
  await form.getByRole("button", { name: "Nordmann, Kari one place up" }).click();
  await form.getByLabel("DOI, where it has one").fill("10.5281");
  await form.getByRole("button", { name: "Save the draft" }).click();
  await form.getByText("`10.5281` is not a DOI; write it like 10.5281/zenodo.1234, or leave it empty").waitFor();
  await form.getByLabel("DOI, where it has one").fill("https://doi.org/10.5281/zenodo.1234");
  await look(page, "dataset-form");
  await form.getByRole("button", { name: "Save the draft" }).click();
  await page.getByRole("heading", { name: "Salmon in the fjord" }).waitFor();

  // What it lacks is said before anything is published.
  const draft = page.getByRole("form", { name: "Draft" });
  await draft.waitFor();
  await publish(page);
  await page.getByText("a citation names who publishes it: write the institution").waitFor();
  await draft.getByLabel("Publisher, the institution").fill("NTNU");
  await draft.getByRole("button", { name: "Save the draft" }).click();
  await page.getByText("Saved.", { exact: true }).waitFor();
  await publish(page);
  const version = page.getByRole("region", { name: "Version 1" });
  await version.getByText(/^Nordmann, Kari; Hansen, Ola \(\d{4}\): Salmon in the fjord\. Version 1\. NTNU\. Dataset\. https:\/\/doi\.org\/10\.5281\/zenodo\.1234$/).waitFor();
  await page.getByText(/^Checked .*: the archive gives exactly these bytes\.$/).waitFor();
  const hash = await version.locator(".hash").innerText();
  const own = await fetched(page, () => page.getByRole("link", { name: /^Download CSV/ }).click());
  same([sha256(own), own.toString().trimEnd().split("\n").length > 700], [hash, true], "what the biologist downloads");
  await page.getByText("In a notebook").click();
  await page.getByText(/hashlib\.sha256/).waitFor();
  await look(page, "dataset");
  await fits(page, "a dataset");

  // A link with a password; its address is shown once.
  await page.getByRole("button", { name: "Make a link" }).click();
  const link = page.getByRole("form", { name: "Make a link" });
  await link.getByRole("button", { name: "Make the link" }).click();
  await link.getByText("Name the recipient.").waitFor();
  await link.getByLabel("Recipient").fill("Ola at IMR");
  await link.getByLabel("Password (empty for none)").fill(PASSWORD);
  await look(page, "dataset-link-form");
  await link.getByRole("button", { name: "Make the link" }).click();
  await page.getByText("The link for Ola at IMR. Copy it now: it is shown this once.").waitFor();
  const address = await page.locator(".secret").innerText();
  check(address.startsWith(`${url}/s/`), address);
  await look(page, "dataset-link");

  // A colleague without an account.
  const other = await open();
  await other.goto(address);
  await other.getByRole("heading", { name: "A link with a password" }).waitFor();
  check(!(await other.content()).includes("Salmon"), "without the password nothing is told");
  await other.getByLabel("Password").fill("a guess");
  await other.getByRole("button", { name: "Open" }).click();
  await other.getByText("The password is wrong.").waitFor();
  await look(other, "link-password");
  await other.getByLabel("Password").fill(PASSWORD);
  await other.getByRole("button", { name: "Open" }).click();
  await other.getByRole("heading", { name: "Salmon in the fjord" }).waitFor();
  await other.getByText("Checked: the archive gives exactly these bytes.").waitFor();
  same(await other.locator(".hash").innerText(), hash, "the SHA-256 that is said");
  same(await other.locator('script[type="application/ld+json"]').count(), 0, "JSON-LD of a link with a password");
  const theirs = await fetched(other, () => other.getByRole("link", { name: /^Download CSV/ }).click());
  same(sha256(theirs), hash, "the bytes that the colleague gets");
  const { head, rows } = table(theirs.toString());
  same(rows.every((row) => row[head.indexOf("tag_id")] === "101"), true, "of the one tag");
  await other.getByText("Other formats, and descriptions for programs").click();
  await look(other, "link");
  await fits(other, "what a link shows");

  // Each use is told; taken back, the link says so.
  await page.getByRole("button", { name: "Uses of the link for Ola at IMR" }).click();
  await page.getByText(/wrong password, from 127\.0\.0\.1/).waitFor();
  await page.getByText(/downloaded: detections\.csv, from 127\.0\.0\.1/).waitFor();
  await look(page, "dataset-uses");
  await page.getByRole("button", { name: "Revoke the link for Ola at IMR" }).click();
  await page.getByRole("group", { name: "Revoke the link for Ola at IMR? It stops working at once." }).getByRole("button", { name: "Revoke" }).click();
  await page.getByRole("cell", { name: "revoked" }).waitFor();
  await other.reload();
  await other.getByRole("heading", { name: "This link was revoked" }).waitFor();
  await other.getByText("Those who made this link have taken it back. Ask them for a new one.").waitFor();
  await look(other, "link-revoked");
  same((await other.request.get(`${address}/detections.csv`)).status(), 410, "its file");

  // A colleague whose account has no role: it opens to them alone, and they see nothing else.
  const dataset = page.url();
  await page.goto(`${url}/admin`);
  const people = page.getByRole("region", { name: "Add a person" });
  await people.getByLabel("Name").fill("ola");
  await people.getByLabel("Role").selectOption("none");
  await people.getByRole("button", { name: "Add", exact: true }).click();
  const first = await page.locator(".secret").innerText();
  await page.goto(dataset);
  await page.getByRole("button", { name: "Make a link" }).click();
  await link.getByLabel("Recipient").fill("Ola at IMR");
  await link.getByLabel(/^Only for this account/).fill("olla");
  await link.getByRole("button", { name: "Make the link" }).click();
  await link.getByText("there is no account olla; ask an admin to make one").waitFor();
  await link.getByLabel(/^Only for this account/).fill("ola");
  await link.getByRole("button", { name: "Make the link" }).click();
  await page.getByText("It opens after logging in as ola, who also finds it under Shared with you.").waitFor();
  const theirOwn = await page.locator(".secret").innerText();
  await page.getByText(/for the account ola alone/).waitFor();
  const guest = await open();
  await logIn(guest, url, "ola", first, "ten grey otters");
  await guest.getByRole("link", { name: "Shared with you" }).click();
  await guest.getByText("shared by admin").waitFor();
  await look(guest, "shared");
  await fits(guest, "what is shared");
  same(await guest.getByRole("navigation", { name: "Pages" }).getByRole("link").allTextContents(), ["Shared with you", "Help"], "what a guest may see");
  await guest.getByRole("link", { name: "Salmon in the fjord" }).click();
  await guest.getByRole("heading", { name: "Salmon in the fjord" }).waitFor();
  same(guest.url(), theirOwn, "the same address as the researcher sent");
  same(sha256(await fetched(guest, () => guest.getByRole("link", { name: /^Download CSV/ }).click())), hash, "the bytes that the guest gets");
  await other.goto(theirOwn);
  await other.getByRole("button", { name: "Log in" }).waitFor();
  check(!(await other.content()).includes("Salmon"), "before the login nothing is told");

  // The list names it.
  await page.goto(`${url}/datasets`);
  await page.getByRole("rowheader", { name: "Salmon in the fjord" }).waitFor();
  await look(page, "datasets");
});
