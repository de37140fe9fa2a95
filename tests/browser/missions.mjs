// Missions: node missions.mjs URL ONE-TIME-PASSWORD FROM TO. Prints nothing. The history has one vessel: 40 places, one every
// 3 s, and 5,200 tags of 7 numbers, one a second from FROM on (µs since 1970 UTC).

import { check, fits, inBrowser, logIn, look, same } from "./browser.mjs";

const [url, oneTime, from] = process.argv.slice(2);
const BOAT = 2068;
const picked = (us) => new Date(us / 1_000).toISOString().slice(0, 19);

await inBrowser(async (open) => {
  const page = await open();
  await logIn(page, url, "admin", oneTime, "battery horse staple");
  const csrf = await page.evaluate(() => document.querySelector('meta[name="csrf"]').content);
  await page.request.post(`${url}/admin/vessel`, { form: { csrf, name: "otter-0", address: String(BOAT) }, headers: { origin: url } });
  const note = (text, time_us, vessel) => page.request.post(`${url}/api/v1/logbook`, { headers: { "x-csrf-token": csrf }, data: { text, time_us, vessel } });
  await note("In the mission", Number(from) + 5_000_000, BOAT);
  await note("For all", Number(from) + 6_000_000, null);
  await note("Before it", Number(from) - 5_000_000, BOAT);
  await page.getByRole("link", { name: "Log book", exact: true }).click();
  await page.getByRole("navigation", { name: "Log book" }).getByRole("link", { name: "Missions" }).click();
  await page.getByText("No missions yet. Press New mission").waitFor();
  await look(page, "missions-empty");

  // Errors stand at their field, which has the focus.
  await page.getByRole("button", { name: "New mission" }).press("Enter");
  const form = page.getByRole("form", { name: "New mission" });
  const name = form.getByLabel("Name");
  check(await name.evaluate((node) => node === document.activeElement), "the name is typed first");
  await form.getByRole("button", { name: "Save" }).press("Enter");
  await form.getByText("Give it a name.").waitFor();
  await page.keyboard.type("Salmon, autumn");
  await form.getByRole("button", { name: "Save" }).press("Enter");
  await form.getByText("Choose a vessel.").waitFor();
  check(await form.getByLabel("otter-0").evaluate((node) => node === document.activeElement), "the vessels have the focus");
  await page.keyboard.press("Space");
  await form.getByLabel("People").fill("Kari, Nils");
  await form.getByLabel("Purpose").fill("Where they winter");
  await form.getByLabel("From (UTC)", { exact: true }).fill(picked(Number(from)));
  await form.getByLabel("To (UTC), empty while it goes on", { exact: true }).fill(picked(Number(from) - 1_000_000));
  await form.getByRole("button", { name: "Save" }).press("Enter");
  await form.getByText("The end is not after the beginning.").waitFor();
  await look(page, "mission-wrong");
  await form.getByLabel("To (UTC), empty while it goes on", { exact: true }).fill(picked(Number(from) + 600_000_000));
  await form.getByRole("button", { name: "Save" }).press("Enter");
  await page.waitForURL(/\/missions\/\d+$/);

  // What the history tells: 39 steps of 3 s, and the tags of ten minutes.
  await page.getByRole("heading", { level: 1, name: "Salmon, autumn" }).waitFor();
  const row = page.getByRole("region", { name: "Summary" }).locator("tbody tr");
  await row.getByText("2 min", { exact: true }).waitFor();
  const cells = await row.locator("th, td").allTextContents();
  same(cells[0], "otter-0", "vessel");
  check(/^1\d\d m /.test(cells[3]), `distance: ${cells[3]}`);
  same(cells.slice(6), ["—", "600", "7", "—"], "energy, detections, tags and plans");
  await page.getByText("In the mission").waitFor();
  await page.getByText("For all").waitFor();
  same(await page.getByText("Before it").count(), 0, "a note of another time");
  await look(page, "mission");

  // Its files are of its vessel and time.
  const href = async (label) => decodeURIComponent(await page.getByRole("link", { name: label }).getAttribute("href"));
  check((await href("Positions, one a second (CSV)")).includes(`from=${picked(Number(from))}Z&to=${picked(Number(from) + 600_000_000)}Z&vessel=${BOAT}`), await href("Positions, one a second (CSV)"));
  const files = ["Positions, one a second (CSV)", "Track of otter-0 (GPX)", "Track of otter-0 (NetCDF)", "Detections (CSV)", "Everything, as a log (LSF)", "Log book (CSV)"];
  for (const file of files) {
    const answer = await page.request.get(url + (await page.getByRole("link", { name: file }).getAttribute("href")));
    same(answer.status(), 200, file);
    if (file.endsWith("(NetCDF)")) same((await answer.body()).subarray(0, 3).toString(), "CDF", "a NetCDF file");
    if (file.startsWith("Detections")) same((await answer.text()).trim().split("\n").length, 601, "a row for each, and the header");
    if (file.startsWith("Log book")) same((await answer.text()).trim().split("\n").length, 3, "two notes, and the header");
  }

  // Changed, and on paper without anything to press.
  await page.getByRole("button", { name: "Change" }).click();
  const change = page.getByRole("form", { name: "Change the mission" });
  await change.getByLabel("Name").fill("Salmon, winter");
  await change.getByRole("button", { name: "Save" }).press("Enter");
  await page.getByRole("heading", { level: 1, name: "Salmon, winter" }).waitFor();
  await page.getByText(/changed by admin/).waitFor();
  await page.emulateMedia({ media: "print" });
  same(await page.locator("button:visible, form:visible, header:visible").count(), 0, "nothing to press on paper");
  check(await page.getByText("In the mission").isVisible() && (await row.isVisible()), "what is read is there");
  await page.emulateMedia({ media: null });

  // On a phone; watched by one press; in the list; withdrawn.
  await page.setViewportSize({ width: 390, height: 844 });
  await fits(page, "a mission on a phone");
  check((await page.getByRole("region", { name: "Summary" }).evaluate((node) => node.scrollWidth - node.clientWidth)) <= 0, "all of the summary is in its cards");
  await page.getByRole("link", { name: "Replay otter-0" }).click();
  await page.waitForURL(new RegExp(`/vessels/${BOAT}\\?.*from=${from}&to=${Number(from) + 600_000_000}`));
  await page.goto(`${url}/missions`);
  await page.getByRole("link", { name: "Salmon, winter" }).waitFor();
  await fits(page, "missions on a phone");
  await page.goto(`${url}/data`);
  await page.getByRole("region", { name: "Missions" }).getByRole("link", { name: "Salmon, winter" }).waitFor();
  await fits(page, "missions among the data on a phone");
  await page.goto(`${url}/missions`);
  await look(page, "missions");
  await page.getByRole("link", { name: "Salmon, winter" }).click();
  await page.getByRole("button", { name: "Withdraw …" }).click();
  await page.getByRole("group", { name: "Withdraw this mission" }).getByRole("button", { name: "Withdraw", exact: true }).press("Enter");
  await page.waitForURL(/\/missions$/);
  await page.getByText("No missions yet.").waitFor();
  await page.getByLabel("Show withdrawn").check();
  await page.getByText("(withdrawn)").waitFor();
});
