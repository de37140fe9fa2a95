// Plans in the list and in the editor: node plans.mjs URL ONE-TIME-PASSWORD. Prints what it wants done to the server.

import { mkdtemp, readFile, writeFile } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { check, inBrowser, logIn, look } from "./browser.mjs";

const [url, oneTime] = process.argv.slice(2);
const HOSTILE = "<img src=x onerror=alert(1)> \"'&æ";

/** What the server holds. */
async function stored(page) {
  const answer = await page.request.get(`${url}/api/v1/plans/${page.url().split("/").at(-1)}`);
  return answer.json();
}

async function kept(page) {
  await page.getByText(/^(Kept as draft|Saved) .*Z, revision \d+$/).waitFor();
}

await inBrowser(async (open) => {
  const page = await open();
  // Each change goes to the disk of a server that shares its machine with other tests.
  await logIn(page, url, "admin", oneTime, "nine grey otters");
  await page.getByRole("link", { name: "Plans" }).click();
  await page.getByText("There are no plans yet").waitFor();
  await look(page, "plans-empty");

  // A plan by mouse: tools, clicks, a drag, a place between, and back and forth.
  await page.getByRole("button", { name: "New plan" }).click();
  await page.getByText("No maneuvers yet.").waitFor();
  await look(page, "plan-empty");
  const map = page.getByRole("application");
  const box = await map.boundingBox();
  const click = (x, y) => page.mouse.click(box.x + box.width * x, box.y + box.height * y);
  const steps = page.getByRole("list", { name: "Maneuvers" }).getByRole("listitem");
  await page.getByRole("button", { name: "Goto", exact: true }).click();
  await click(0.3, 0.7);
  await click(0.3, 0.4);
  await page.getByRole("button", { name: "Path", exact: true }).click();
  for (const [x, y] of [[0.4, 0.3], [0.5, 0.35], [0.6, 0.3]]) await click(x, y);
  await page.getByRole("button", { name: "Loiter", exact: true }).click();
  await click(0.7, 0.5);
  await page.getByRole("button", { name: "Station", exact: true }).click();
  await click(0.6, 0.7);
  await page.getByRole("button", { name: "Rows", exact: true }).click();
  await click(0.45, 0.6);
  check((await page.getByRole("button", { name: "Rows", exact: true }).getAttribute("aria-pressed")) === "false", "a click makes one area and puts the tool away");
  await click(0.2, 0.2);
  await page.waitForFunction(() => document.querySelectorAll(".steps > li").length === 6);
  await page.getByText(/\d+ (m|km) · .* · .* Wh \(estimate\)/).waitFor();
  await kept(page);
  let plan = (await stored(page)).plan;
  check(plan.maneuvers.map((step) => step.task.kind).join() === "goto,goto,follow_path,loiter,station_keeping,rows", JSON.stringify(plan));
  check(plan.maneuvers[2].task.points.length === 3, "the path has three points");

  await page.getByRole("button", { name: "Choose", exact: true }).click();
  const from = [box.x + box.width * 0.3, box.y + box.height * 0.7];
  await page.mouse.move(...from);
  await page.mouse.down();
  await page.mouse.move(from[0] + 60, from[1] + 30, { steps: 6 });
  await page.mouse.up();
  await kept(page);
  const dragged = (await stored(page)).plan.maneuvers[0].task.at;
  check(dragged.lon_deg > plan.maneuvers[0].task.at.lon_deg && dragged.lat_deg < plan.maneuvers[0].task.at.lat_deg, "dragged to the south-east");
  await click(0.35, 0.35);
  check((await steps.count()) === 7, "the handle between two places makes a place");
  await page.keyboard.press("Control+z");
  await page.keyboard.press("Control+z");
  check((await steps.count()) === 6, "undone");
  await kept(page);
  check(JSON.stringify((await stored(page)).plan) === JSON.stringify(plan), "undo brings back what was");
  await page.keyboard.press("Control+y");
  await kept(page);
  check((await stored(page)).plan.maneuvers[0].task.at.lat_deg === dragged.lat_deg, "redo does it again");
  await page.getByRole("button", { name: "Show all" }).click();
  await page.getByLabel("Name of the plan").fill("by mouse");
  await page.keyboard.press("Enter");
  await page.getByRole("button", { name: "Save" }).click();
  await page.getByText(/^Saved .*Z, revision \d+$/).waitFor();
  await steps.nth(5).getByRole("button", { name: /Rows 1/ }).first().click();
  await look(page, "plan-rows");
  await steps.nth(2).getByRole("button", { name: /Path 1/ }).first().click();
  await look(page, "plan-path");

  // A problem is told at its maneuver, and what has problems is no saved plan.
  await page.getByLabel("Speed", { exact: true }).fill("18");
  await page.keyboard.press("Enter");
  await steps.nth(2).getByText(/This speed is not possible\. Choose one above 0 and up to 3\.09 m\/s/).waitFor();
  await page.getByText("1 problem: cannot be sailed as it is").waitFor();
  await look(page, "plan-problem");
  await page.keyboard.press("Control+s");
  await page.getByText("Not saved: the plan has problems. It is kept as a draft.").waitFor();
  await page.getByLabel("Speed", { exact: true }).fill("fast");
  await page.keyboard.press("Enter");
  await page.getByText("a number from 0.01 to 1000").waitFor();
  await page.getByRole("button", { name: "Undo" }).click();
  await kept(page);

  // Another by keyboard alone.
  await page.goto(`${url}/plans`);
  await page.getByRole("button", { name: "New plan" }).focus();
  await page.keyboard.press("Enter");
  await page.getByText("No maneuvers yet.").waitFor();
  const type = async (label, text) => {
    await page.getByLabel(label, { exact: true }).focus();
    await page.keyboard.press("Control+a");
    await page.keyboard.type(text);
    await page.keyboard.press("Enter");
  };
  await page.getByRole("button", { name: "Add", exact: true }).focus();
  await page.keyboard.press("Enter");
  await type("Latitude", "63° 26.4′ N");
  await type("Longitude", "10 24 0 E");
  await page.getByLabel("What to add").focus();
  await page.keyboard.type("Path");
  await page.getByRole("button", { name: "Add", exact: true }).focus();
  await page.keyboard.press("Enter");
  await type("Point 1 Latitude", "63.45");
  await type("Point 1 Longitude", "10,4");
  await page.getByRole("button", { name: "Insert after point 1" }).focus();
  await page.keyboard.press("Enter");
  await type("Point 2 Latitude", "95");
  await page.getByText("like 63.44 or 63° 26.4′ N").waitFor();
  await type("Point 2 Latitude", "63.46");
  await type("Point 2 Longitude", "10.41");
  await map.focus();
  await page.keyboard.press("Shift+ArrowUp");
  await kept(page);
  plan = (await stored(page)).plan;
  check(JSON.stringify(plan.maneuvers[0].task) === '{"kind":"goto","at":{"lat_deg":63.44,"lon_deg":10.4}}', JSON.stringify(plan.maneuvers[0]));
  const [, second] = plan.maneuvers[1].task.points;
  check(Math.abs(second.lat_deg - 63.46009) < 2e-6, `ten metres to the north: ${second.lat_deg}`);
  await page.getByRole("button", { name: /2 Path 1/ }).focus();
  await page.keyboard.press("Alt+ArrowUp");
  await steps.first().getByText("1 Path 1").waitFor();
  check((await page.evaluate(() => document.activeElement.textContent)).includes("Path 1"), "the keyboard stays where it was");
  await page.keyboard.press("ArrowDown");
  await page.keyboard.press("Delete");
  check((await steps.count()) === 1, "deleted by key");
  await page.keyboard.press("Control+z");
  check((await steps.count()) === 2, "and back");
  await type("Name of the plan", HOSTILE);
  await type("Speed of all", "2");
  await kept(page);
  check((await stored(page)).plan.maneuvers.every((step) => step.speed.unit === "mps" && Math.abs(step.speed.value - (2 * 1852) / 3600) < 1e-9), "one speed for all, typed in knots and kept in m/s");
  // In another unit it is the same speed, and the same plan.
  const asKept = JSON.stringify((await stored(page)).plan);
  await page.getByLabel("Unit of all").selectOption("m/s");
  check((await page.getByLabel("Speed of all").inputValue()).startsWith("1.02888"), "in m/s");
  await page.getByLabel("Unit of all").selectOption("kn");
  check((await page.getByLabel("Speed of all").inputValue()) === "2", "and back in knots");
  check(JSON.stringify((await stored(page)).plan) === asKept, "another unit is not a change");

  // The server is away: nothing is lost, not even by closing the page.
  console.log("kill the server");
  await page.getByText("No link to the server").waitFor();
  await type("What for", "drawn while the server was away");
  await page.getByText(/Not on the server: The server cannot be reached. It is kept in this browser; trying again/).waitFor();
  await look(page, "plan-away");
  await type("Speed of all", "2.5");
  console.log("start the server");
  await kept(page);
  check((await stored(page)).plan.description === "drawn while the server was away", "brought when the server is back");
  const address = page.url();
  await page.getByText("Live", { exact: true }).waitFor();
  console.log("kill the server");
  await page.getByText("No link to the server").waitFor();
  await type("What for", "never sent");
  await page.getByText(/Not on the server/).waitFor();
  await page.goto("about:blank");
  console.log("start the server");
  for (let tries = 0; ; tries++) {
    try {
      await page.goto(address);
      break;
    } catch (error) {
      if (tries > 200) throw error;
      await new Promise((done) => setTimeout(done, 100));
    }
  }
  await page.getByText(/This browser has changes to the plan from .* that did not reach the server/).waitFor();
  await look(page, "plan-offered");
  await page.getByRole("button", { name: "Go on with it" }).click();
  await kept(page);
  check((await stored(page)).plan.description === "never sent", "offered again and taken up");

  // An answer that is lost makes no conflict with oneself.
  let lost = 0;
  await page.route("**/api/v1/plans/*", async (route) => {
    if (route.request().method() !== "PUT" || lost++) return route.continue();
    await route.fetch();
    await route.abort();
  });
  await type("What for", "sent, and not answered");
  await page.getByText(/Not on the server: The server cannot be reached/).waitFor();
  await type("What for", "and then more");
  await kept(page);
  check(lost > 1 && (await stored(page)).plan.description === "and then more", "both changes are there");
  check((await page.getByRole("alert").filter({ hasText: "changed this plan" }).count()) === 0, "and nobody is accused");
  await page.unroute("**/api/v1/plans/*");

  // Two tabs: the later one is told, and both states survive.
  const other = await page.context().newPage();
  await other.goto(address);
  await other.getByRole("button", { name: /2 Goto 1/ }).waitFor();
  await type("What for", "of the first tab");
  await kept(page);
  await other.getByLabel("What for").fill("of the second tab");
  await other.keyboard.press("Enter");
  await other.getByRole("alert").getByText(/admin changed this plan at .* Nothing is lost/).waitFor();
  await look(other, "plan-conflict");
  check((await stored(page)).plan.description === "of the first tab", "not overwritten");
  await other.getByRole("button", { name: "Keep mine as a separate plan" }).click();
  await other.waitForURL((now) => now.href !== address && now.pathname.startsWith("/plans/"));
  await other.getByRole("button", { name: /2 Goto 1/ }).waitFor();
  check((await stored(other)).plan.description === "of the second tab", "kept beside it");
  await other.close();

  // Files in and out; what is not a plan is refused with its place; deleting has a way back.
  await page.goto(`${url}/plans`);
  const folder = await mkdtemp(join(tmpdir(), "lutra-plans-"));
  const bring = async (name, text) => {
    await writeFile(join(folder, name), text);
    await page.getByLabel(/^Import/).setInputFiles(join(folder, name));
  };
  await bring("bad.gpx", "<gpx>\n<rte><rtept lat='95' lon='10'/></rte></gpx>");
  await page.getByText(/bad.gpx was not imported: line 2: <rtept> needs lat within ±90/).waitFor();
  await bring("tour.gpx", `<gpx><wpt lat="1" lon="1"/><rte><name>&lt;b&gt;tour</name><rtept lat="63.44" lon="10.4"><name>a</name></rtept><rtept lat="63.45" lon="10.42"/></rte></gpx>`);
  await page.getByText("tour.gpx is imported as <b>tour, 2 maneuvers.").waitFor();
  await page.getByText("way points beside routes and tracks were left out: 1").waitFor();
  const row = page.getByRole("row", { name: /<b>tour/ });
  await row.waitFor();
  await look(page, "plans");
  await row.getByRole("button", { name: "Delete" }).click();
  await page.getByText("<b>tour was deleted.").waitFor();
  await row.waitFor({ state: "detached" });
  await page.keyboard.press("Enter");
  await page.getByText("<b>tour is back.").waitFor();
  await row.getByRole("link").click();
  const download = page.waitForEvent("download");
  await page.getByRole("link", { name: "GPX", exact: true }).click();
  const file = await readFile(await (await download).path(), "utf8");
  check(file.includes('<rtept lat="63.45" lon="10.42"'), file);
  await page.goto(`${url}/plans/999999`);
  await page.getByText("There is no such plan").waitFor();

  // A viewer sees plans and changes nothing.
  await page.goto(`${url}/admin`);
  await page.getByLabel("Name").fill("vera");
  await page.locator("main form.card").getByLabel("Role").selectOption("viewer");
  await page.getByRole("button", { name: "Add" }).click();
  const password = await page.locator(".secret").innerText();
  const viewer = await open();
  await logIn(viewer, url, "vera", password, "seven small boats");
  await viewer.goto(`${url}/plans`);
  await viewer.getByRole("link", { name: "by mouse" }).click();
  await viewer.getByText("You may look at this plan, not change it.").waitFor();
  check((await viewer.getByRole("button", { name: "Save" }).count()) === 0, "a viewer has nothing to save");
  await look(viewer, "plan-viewer");
});
