// A vessel's page on simulated Otters: node vessel.mjs URL PASSWORD. Prints what it wants done to processes.

import { readFile } from "node:fs/promises";
import { PATIENCE_MS, check, inBrowser, logIn, look, sameSamples } from "./browser.mjs";

const [url, password] = process.argv.slice(2);
const OTTER = 10449;

await inBrowser(async (open) => {
  const page = await open();
  await logIn(page, url, "admin", password);
  await page.getByRole("link", { name: "Open otter-1" }).click();
  await page.getByText("Live", { exact: true }).waitFor();
  check(page.url().startsWith(`${url}/vessels/${OTTER}`), page.url());

  // Instruments have value, unit and age, and none is old on a vessel that speaks.
  const tile = (name) => page.locator(`[data-tile="${name}"]`);
  await tile("mode").getByText("Executing plan").waitFor();
  await tile("plan").getByText("square").waitFor();
  await tile("link").getByText(/by link/).waitFor();
  await tile("progress").getByText(/^\d of 4$/).waitFor();
  await page.getByText("In control: nobody", { exact: true }).waitFor();
  // Further instruments are behind More.
  await page.getByRole("button", { name: "More instruments" }).click();
  await tile("chart").getByText("up to date").waitFor();
  for (const name of ["link", "mode", "plan", "speed_mps", "heading_rad", "port_rpm", "starboard_rpm", "battery", "voltage"]) {
    await page.waitForFunction((name) => !document.querySelector(`[data-tile="${name}"]`).hasAttribute("data-old"), name);
    check(/\d/.test(await tile(name).locator(".age").innerText()), `${name} has an age`);
  }
  check(/^\d\.\d$/.test(await tile("speed_mps").locator(".reading").innerText()), "speed in knots");

  // Plots of the field: the present grows, hovering tells the value and where the boat was.
  const plot = page.getByRole("region", { name: "EstimatedState, m/s", exact: true });
  await plot.waitFor();
  const legend = plot.locator(".legend .num").first();
  await page.waitForFunction((node) => /m\/s/.test(node.textContent), await legend.elementHandle());
  await page.getByRole("combobox", { name: "Stretch of time" }).selectOption("last 5 min");
  check(new URL(page.url()).searchParams.get("span") === "300", "the address tells the time");
  const over = plot.locator(".u-over");
  // A plot that is redrawn for another stretch of time has no pointer over it until that moves: somebody would move it.
  const told = () => page.locator(".here").getByText(/63° .*N 010° .*E/).waitFor({ timeout: 3_000 }).then(() => true, () => false);
  for (let turn = 0; ; turn += 1) {
    const box = await over.boundingBox();
    await over.hover({ position: { x: box.width - 4 - (turn % 2), y: 40 } });
    if (await told()) break;
    check(turn < 5, `the pointer tells no place: ${await page.locator(".here").textContent()}`);
  }
  await page.mouse.move(5, 5);
  await page.waitForFunction(() => document.querySelector(".here").textContent === "");
  // The same by keys.
  const canvas = plot.locator(".canvas");
  await canvas.focus();
  await page.keyboard.press("ArrowLeft");
  await page.locator(".here").getByText(/Z/).waitFor();
  await page.keyboard.press("Escape");

  // A field from the values joins the plots.
  await page.getByRole("tab", { name: "Plots" }).focus();
  await page.keyboard.press("ArrowRight");
  const values = page.getByRole("tabpanel", { name: "Values" });
  await values.getByLabel("Filter").fill("voltage battery 0");
  await values.getByRole("row", { name: /Voltage Battery 0 value .* V/ }).waitFor();
  await look(page, "vessel-values");
  await values.getByRole("button", { name: "Plot Voltage Battery 0 value" }).click();
  const voltage = page.getByRole("region", { name: /^Voltage/ });
  await voltage.waitFor();
  await page.getByRole("button", { name: "Add a field" }).click();
  await page.getByLabel("Words of quantity, message, entity or field").fill("heading estimatedstate");
  await page.keyboard.press("Enter");
  await page.getByRole("region", { name: "EstimatedState, °", exact: true }).waitFor();
  await look(page, "vessel-plots");

  // Drag to zoom: the time stands still, and CSV holds just what is shown.
  await over.scrollIntoViewIfNeeded();
  const wide = await over.boundingBox();
  const late = wide.x + wide.width - 2;
  await page.mouse.move(late - 60, wide.y + 60);
  await page.mouse.down();
  await page.mouse.move(late, wide.y + 60, { steps: 5 });
  await page.mouse.up();
  await page.getByText("stands still").waitFor();
  const shown = new URL(page.url()).searchParams;
  const [from, to] = [Number(shown.get("from")), Number(shown.get("to"))];
  check(to > from && to - from < 120e6, `zoomed to ${(to - from) / 1e6} s`);
  const counted = page.waitForResponse((response) => response.url().includes("/buckets?") && response.url().includes("field=u"));
  await page.getByRole("button", { name: "Zoom out" }).click();
  await page.getByRole("button", { name: "Zoom in" }).click();
  await counted;
  const link = plot.getByRole("link", { name: /Download CSV of EstimatedState u/ });
  await page.waitForFunction((node) => new URL(node.href).searchParams.get("from") !== null, await link.elementHandle());
  const query = new URL(await link.getAttribute("href"), url).searchParams;
  const download = page.waitForEvent("download");
  await link.click();
  const csv = await readFile(await (await download).path(), "utf8");
  check(csv.includes("u [m/s]") && !csv.includes("psi"), csv.slice(0, 200));
  const asked = `from_us=${Date.parse(query.get("from")) * 1000}&to_us=${Date.parse(query.get("to")) * 1000}`;
  const samples = await page.request.get(`${url}/api/v1/vessels/${OTTER}/samples?message=EstimatedState&entity=${query.get("entity")}&fields=u&limit=10000&${asked}`);
  sameSamples(csv, await samples.json(), "u");
  await page.getByRole("combobox", { name: "Stretch of time" }).selectOption("last 15 min");
  await page.getByText("follows the present").waitFor();

  // All entities with their state; the log book.
  await page.getByRole("tab", { name: "Entities" }).click();
  await page.getByRole("row", { name: /Motor Port ● normal/ }).waitFor();
  await look(page, "vessel-entities");
  await page.getByRole("tab", { name: "Log book" }).click();
  await page.getByRole("row", { name: /warning .*square: the plan never ends by itself/ }).waitFor();
  await page.getByRole("row", { name: /square: the plan never ends/ }).getByRole("button").focus();
  await page.locator(".here").getByText(/Z/).waitFor();
  await look(page, "vessel-log-book");

  // STOP: one press, no question, and what became of it.
  await page.getByRole("button", { name: "STOP otter-1" }).click();
  await page.getByText(/STOP otter-1: stopped after \d/).waitFor();
  // Somebody starts the plan again as soon as the vessel takes one (it refuses while it is aborting), and the page does not go on
  // saying that it stopped.
  await page.getByText("Ready", { exact: true }).waitFor();
  await page.getByRole("tab", { name: "Control" }).click();
  await page.getByRole("button", { name: "Take control", exact: true }).click();
  await page.getByRole("button", { name: "Start square …" }).click();
  await page.getByRole("button", { name: "Start square", exact: true }).click();
  await page.getByText(/STOP otter-1: stopped .* GOES ON since/).waitFor();
  await look(page, "vessel-stopped");

  // By now its hydrophone has heard tags.
  await page.getByRole("tab", { name: "Tags" }).click();
  await page.getByRole("row", { name: /S256-10\d/ }).first().waitFor();
  await look(page, "vessel-tags");
  // From the agent to the page the next one comes by itself, with all that the vessel knows of it.
  const tagRows = page.getByRole("tabpanel", { name: "Tags" }).locator("tbody tr");
  const questions = [];
  page.on("request", (request) => request.url().includes("/detections?") && questions.push(request.url()));
  const rowsBefore = await tagRows.count();
  await page.waitForFunction((count) => document.querySelectorAll("#panel-5 tbody tr").length > count, rowsBefore, { timeout: 2 * PATIENCE_MS });
  check(questions.length === 0, `asked for tags: ${questions}`);
  const [last] = (await (await page.request.get(`${url}/api/v1/vessels/${OTTER}/detections?order=newest&limit=1&from_us=0&to_us=4000000000000000`)).json()).detections;
  check(last.clock === "set" && last.raw.startsWith("$") && last.pose_age_s < 5 && last.pose_sigma_m > 0, JSON.stringify(last));
  await page.getByRole("button", { name: "Close: STOP otter-1" }).click();
  await page.keyboard.press("Control+.");
  await page.getByText(/STOP otter-1: /).waitFor();

  // From any page; a vessel that does not hear is not said to have stopped.
  await page.goto(`${url}/admin/audit`);
  await page.getByRole("cell", { name: "STOP", exact: true }).first().waitFor();
  console.log("silence otter-2");
  await page.goto(`${url}/vessels/10450`);
  await page.locator('[data-tile="link"][data-old]').getByText(/stale|lost/).waitFor();
  await page.locator('[data-tile="speed_mps"][data-old]').getByText(/^old: /).waitFor();
  await page.locator('[data-tile="mode"][data-old]').waitFor();
  await look(page, "vessel-lost");
  await page.goto(`${url}/admin`);
  await page.getByText("STOP …").click();
  await page.getByRole("button", { name: "STOP otter-2" }).click();
  await page.getByText(/STOP otter-2: (NOT SENT|sent, but NO EFFECT SEEN)/).waitFor();
  await look(page, "stop-unheard");
  console.log("wake otter-2");

  // Without the server the page greys.
  await page.goto(`${url}/vessels/${OTTER}`);
  await page.getByText("Live", { exact: true }).waitFor();
  await page.waitForFunction(() => !document.querySelector('[data-tile="mode"]').hasAttribute("data-old"));
  console.log("stop the server");
  await page.getByText("No link to the server").waitFor();
  await page.locator('[data-tile="mode"][data-old]').waitFor();
  await page.getByRole("button", { name: "STOP otter-1" }).click();
  await page.getByText(/STOP otter-1: NOT SENT/).waitFor();
});
