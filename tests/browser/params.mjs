// The Parameters tab on a simulated Otter: node params.mjs URL PASSWORD. Prints what it wants done to processes.

import { PATIENCE_MS, check, inBrowser, logIn, look, until } from "./browser.mjs";

const [url, password] = process.argv.slice(2);
const OTTER = 10449;
const NAME = "ILOS Lookahead Distance";

await inBrowser(async (open) => {
  const page = await open();
  await logIn(page, url, "admin", password);
  await page.goto(`${url}/admin`);
  const form = page.locator("main form.card");
  await form.getByLabel("Name").fill("vera");
  await form.getByLabel("Role").selectOption("viewer");
  await form.getByRole("button", { name: "Add" }).click();
  const secret = await page.locator(".secret").innerText();
  const button = (of, name) => of.getByRole("button", { name, exact: true });
  const box = (of) => of.getByRole("tabpanel", { name: "Parameters" });
  const row = (of, name) => box(of).getByRole("row", { name: new RegExp(`^${name}`) });
  const field = (of, name, entity = "Path Control") => of.getByRole("textbox", { name: `${name} of ${entity}` });

  // It is read by itself, with unit, range, default and meaning.
  await page.goto(`${url}/vessels/${OTTER}`);
  await page.getByText("Live", { exact: true }).waitFor();
  await page.getByRole("tab", { name: "Parameters" }).click();
  await field(page, NAME).waitFor();
  const first = await field(page, NAME).inputValue();
  check(Number(first) > 0, `${NAME} is ${first}`);
  const words = await row(page, NAME).innerText();
  check(/1 to 50\b/.test(words) && /\bm\b/.test(words), words);
  await box(page).getByRole("region", { name: "Path Control" }).getByText(/reported \d+(\.\d)? s ago/).waitFor();
  const most = (await row(page, "Maximum Speed").first().innerText()).replace(/\s+/g, " ");
  check(/\bkn\b/.test(most) && /= [\d.]+ m\/s/.test(most), `speeds are read in knots, and beside it as the vessel has them: ${most}`);
  const [knots, mps] = [Number(await field(page, "Maximum Speed", "Operational Limits").inputValue()), Number(/= ([\d.]+) m\/s/.exec(most)[1])];
  check(Math.abs((knots * 1852) / 3600 - mps) < 1e-3, `${knots} kn are ${mps} m/s`);
  check(await field(page, "Maximum Speed", "Operational Limits").evaluate((node) => node.readOnly), "a limit of safety is set in the file only");

  // A viewer reads and cannot write, and the server says so too.
  const viewer = await open();
  await logIn(viewer, url, "vera", secret, "seven small boats at sea");
  // The table's script fails to load once: the tab says so, and loading the page again mends it.
  await viewer.route("**/static/parameters-*.js", (route) => route.abort(), { times: 1 });
  await viewer.goto(`${url}/vessels/${OTTER}?tab=Parameters`);
  await box(viewer).getByText("This part of the page could not be loaded.").waitFor();
  await button(box(viewer), "Load the page again").click();
  await field(viewer, NAME).waitFor();
  check(await field(viewer, NAME).evaluate((node) => node.readOnly), "a viewer cannot type");
  check((await box(viewer).getByRole("button").count()) === 1, "a viewer can read again, and no more");
  await button(viewer, "Read from vessel").click();
  await box(viewer).getByText(/^Read\./).waitFor();
  // Which window has control is known to that window and to the server.
  let mine = "";
  page.on("request", (request) => {
    if (request.url().endsWith("/lease") && request.method() === "POST") mine = request.postDataJSON().window;
  });
  const send = (of, order) =>
    of.evaluate(async ([path, order, window]) => {
      const headers = { "content-type": "application/json", "x-csrf-token": document.querySelector('meta[name="csrf"]').content };
      return (await fetch(path, { method: "POST", headers, body: JSON.stringify({ order, window }) })).status;
    }, [`/api/v1/vessels/${OTTER}/commands`, order, mine]);
  const set = (value) => ({ kind: "parameters.set", entity: "Path Control", values: [{ name: NAME, value }] });
  check((await send(viewer, set("12"))) === 403, "a viewer is refused");
  check((await send(page, set("12"))) === 409, "without control nobody writes");
  await look(viewer, "params-viewer");

  // What is typed is judged at once, kept through a reload, and taken back by a key.
  await field(page, NAME).fill("1000");
  await row(page, NAME).getByText("1000 is not within 1 to 50 m.").waitFor();
  await page.keyboard.press("Escape");
  check((await field(page, NAME).inputValue()) === first, "Escape takes it back");
  await field(page, NAME).fill("17");
  check(await button(page, "Write 1").isDisabled(), "not without control");
  await page.reload();
  await field(page, NAME).waitFor();
  await page.waitForFunction(([name]) => document.querySelector(`input[aria-label="${name} of Path Control"]`)?.value === "17", [NAME]);
  await button(page, "Control …").click();
  await button(page, "Take control").click();
  await page.getByText("You have control of this vessel.").waitFor();
  await page.getByRole("tab", { name: "Parameters" }).click();
  await box(page).getByText("You have control: changes can be written.").waitFor();

  // Searching, by keys alone; Enter goes on to the next one.
  await box(page).getByLabel("Find").fill("corridor");
  await field(page, NAME).waitFor({ state: "hidden" });
  await box(page).getByLabel("Find").fill("no such parameter");
  await box(page).getByText("No matching parameters.").waitFor();
  await box(page).getByLabel("Find").fill("ilos");
  await field(page, NAME).focus();
  await page.keyboard.press("ArrowUp");
  check((await page.evaluate(() => document.activeElement.getAttribute("aria-label"))).startsWith("ILOS Integrator Gain"), "arrows go along");
  await box(page).getByLabel("Find").fill("");

  // What is wrong is not written; then two steps with old and new, and the vessel's word for it.
  await field(page, "Corridor -- Width").fill("x");
  await button(page, "Write 2").click();
  await box(page).getByRole("alert").getByText(/Corridor -- Width of Path Control: “x” is not a number/).waitFor();
  await look(page, "params-wrong");
  await page.keyboard.press("Escape");
  await field(page, "Corridor -- Width").press("Escape");
  await button(page, "Write 1").click();
  const confirm = box(page).getByRole("group", { name: "Write 1 parameter to otter-1?" });
  await confirm.getByText(`Path Control, ${NAME}: ${first} → 17 m`).waitFor();
  await confirm.getByText("Take care: it changes at once how the vessel steers.").waitFor();
  await look(page, "params-confirm");
  if (!(await confirm.isVisible())) await button(page, "Write 1").click();
  await button(page, "Write to vessel").press("Enter");
  await row(page, NAME).getByText(/confirmed: The vessel reports 17\./).waitFor();
  await row(page, NAME).getByText(`≠ saved ${first}`).waitFor();
  await box(page).getByLabel("Show").selectOption("differs from saved");
  check((await box(page).getByRole("textbox").count()) === 1, "one differs from what is saved");
  await look(page, "params-written");
  await box(page).getByLabel("Show").selectOption("all");
  await button(viewer, "Read from vessel").waitFor();
  await viewer.waitForFunction(([name]) => document.querySelector(`input[aria-label="${name} of Path Control"]`)?.value === "17", [NAME]);

  // What the vessel itself refuses comes back in its words.
  check((await send(page, set("1000"))) === 202, "the server lets the vessel judge");
  await page.getByRole("tab", { name: "Control" }).click();
  await page.locator('.commands > li[data-order="parameters.set"]').first().getByText(/refused .*ILOS Lookahead Distance: .*1000/).waitFor();
  await page.getByRole("tab", { name: "Parameters" }).click();

  // Saved, it outlives the vessel's next start.
  await button(page, "Save to vessel …").click();
  await box(page).getByText(`Path Control, ${NAME}: ${first} → 17`).waitFor();
  await button(page, "Save").click();
  await box(page).getByText("Saved: the vessel reports these values for its next start.").waitFor();
  await row(page, NAME).getByText(/≠ saved/).waitFor({ state: "detached" });
  /** How the vessel's link stands, and the how-manieth connection it is. */
  const link = async () => (await (await page.request.get(`${url}/api/v1/links`)).json()).find((one) => one.vessel === OTTER);
  const { connections } = await link();
  console.log("kill otter-1");
  await until(async () => {
    const now = await link();
    return now.up && now.connections !== connections;
  }, "a new connection of the vessel", 90_000);
  await page.locator('[data-tile="link"]').getByText("● live").waitFor({ timeout: 2 * PATIENCE_MS });
  await button(page, "Read from vessel").click();
  await box(page).getByText(/^Read\./).waitFor();
  check((await field(page, NAME).inputValue()) === "17", "it is there after a start");

  // A vessel that does not answer: what was typed stays, and what is shown tells its age.
  await button(page, "Write").waitFor();
  await field(page, NAME).fill("19");
  console.log("silence otter-1");
  await button(page, "Write 1").click();
  await button(page, "Write to vessel").click();
  await row(page, NAME).getByText(/timed out: /).waitFor({ timeout: 2 * PATIENCE_MS });
  check((await field(page, NAME).inputValue()) === "19", "no work is lost");
  await box(page).getByText(/otter-1 is not heard: these are its last known values, .* old\./).waitFor();
  await look(page, "params-offline");
  console.log("wake otter-1");
  await page.locator('[data-tile="link"]').getByText("● live").waitFor({ timeout: 2 * PATIENCE_MS });
  await button(page, "Discard changes").click();
  check((await field(page, NAME).inputValue()) !== "19", "forgotten");

  // Who wrote what, with old and new.
  await page.goto(`${url}/admin/audit`);
  await page.getByText(`otter-1 Path Control: ${NAME} ${first} -> 17`).first().waitFor();
});
