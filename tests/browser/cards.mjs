// Tables whose rows are cards on a phone, as who hears the page meets them: node cards.mjs URL ONE-TIME-PASSWORD. In the
// accessibility tree at 390 px each is still a table, with its rows, the names of its columns, and cells that say theirs; what
// scrolls can be reached by keys and has a name.

import { check, inBrowser, logIn, until } from "./browser.mjs";

const [url, oneTime] = process.argv.slice(2);
const BOAT = 2068;

/** The first table within a role's node, of the tree that Chromium gives assistive technology: its rows as names by role. */
async function heard(page) {
  const session = await page.context().newCDPSession(page);
  await session.send("Accessibility.enable");
  const { nodes } = await session.send("Accessibility.getFullAXTree");
  await session.detach();
  const byId = new Map(nodes.map((node) => [node.nodeId, node]));
  const below = (node, roles) => (node.childIds ?? []).map((id) => byId.get(id)).filter(Boolean).flatMap((child) => (!child.ignored && roles.includes(child.role?.value) ? [child] : below(child, roles)));
  return nodes.filter((node) => !node.ignored && node.role?.value === "table").map((table) => ({
    groups: below(table, ["rowgroup"]).length,
    rows: below(table, ["row"]).map((row) => below(row, ["columnheader", "rowheader", "cell", "gridcell"]).map((cell) => [cell.role.value, cell.name?.value ?? ""])),
  }));
}

await inBrowser(async (open) => {
  const page = await open();
  await logIn(page, url, "admin", oneTime, "nine grey otters");
  const csrf = await page.evaluate(() => document.querySelector('meta[name="csrf"]').content);
  const post = (path, form) => page.request.post(`${url}${path}`, { form: { csrf, ...form }, headers: { origin: url } });
  await post("/admin/vessel", { name: "otter-0", address: String(BOAT) });
  await post("/admin/vessel/token", { address: String(BOAT) });
  await post("/admin/person", { name: "nils", role: "viewer", vessel: "" });
  const plan = { name: "north shore", description: "", vessel: null, repeat: false, maneuvers: [] };
  await page.request.post(`${url}/api/v1/plans`, { headers: { "x-csrf-token": csrf }, data: plan });

  // Something for the history of alarms.
  console.log("empty");
  await page.goto(`${url}/alarms`);
  await until(async () => (await page.reload()) && (await page.locator("main table tbody tr").count()), "an alarm is in the history");

  await page.setViewportSize({ width: 390, height: 844 });
  for (const path of ["/plans", "/admin", "/admin/vessels", "/admin/tokens", "/admin/sessions", "/admin/audit", "/alarms"]) {
    await page.goto(url + path);
    await page.locator('body[data-link="up"]').waitFor();
    await page.locator("main table tbody tr").first().waitFor();
    const seen = await page.locator("main table").first().evaluate((table) => ({
      laidOut: getComputedStyle(table.tBodies[0].rows[0]).display,
      names: [...table.tHead.rows[0].cells].map((cell) => cell.textContent.trim()),
      rows: [...table.tBodies[0].rows].map((row) => [...row.cells].map((cell) => cell.dataset.name ?? "")),
    }));
    check(["grid", "flex"].includes(seen.laidOut), `${path}: rows are cards, not ${seen.laidOut}`);
    const [table] = await heard(page);
    check(table, `${path}: a table is heard`);
    check(table.groups === 2 && table.rows.length === seen.rows.length + 1, `${path}: ${table.groups} groups and ${table.rows.length} rows are heard, of ${seen.rows.length} and their head`);
    const [head, ...rows] = table.rows;
    check(head.every(([role]) => role === "columnheader") && head.map(([, name]) => name).join("|") === seen.names.join("|"), `${path}: columns are heard as ${JSON.stringify(head)}`);
    rows.forEach((row, at) => {
      check(row.length === seen.names.length, `${path}: a row of ${row.length} cells under ${seen.names.length} columns`);
      const silent = row.filter(([, name], column) => !name.startsWith(seen.rows[at][column]));
      check(!silent.length, `${path}: cells without the name of their column: ${JSON.stringify(silent)}`);
    });
  }

  // What scrolls by itself is reached by Tab and says what it is.
  for (const path of ["/admin/connections", "/admin/storage", "/account", `/vessels/${BOAT}?tab=Values`]) {
    await page.goto(url + path);
    await page.locator('body[data-link="up"]').waitFor();
    await page.locator("main table").first().waitFor({ state: "attached" });
    const mute = await page.locator("main table").evaluateAll((all) => all.filter((table) => table.checkVisibility()).filter((table) => !table.closest('[role="region"][tabindex="0"][aria-label]')).map((table) => table.outerHTML.slice(0, 120)));
    check(!mute.length, `${path}: a table that no key and no name leads to: ${mute.join("; ")}`);
  }
});
