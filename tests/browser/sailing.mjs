// What a fleet sails: the list sorted, the route on the map, and plans ashore beside those aboard: node sailing.mjs URL PASSWORD.

import { PATIENCE_MS, check, inBrowser, logIn, look } from "./browser.mjs";

const [url, password] = process.argv.slice(2);
const OTTER = 10449;
const LONG = "a plan with a rather long name for a tile, north basin 2";

await inBrowser(async (open) => {
  const page = await open();
  await logIn(page, url, "admin", password);

  // A vessel that has a name stands in the list before it is heard; the list can be sorted.
  await page.goto(`${url}/admin/vessels`);
  await page.getByLabel("Name").first().fill("brand-new");
  await page.getByLabel("Address").first().fill("0x2A00");
  await page.getByRole("button", { name: /Add/ }).first().click();
  await page.getByRole("link", { name: "Fleet" }).click();
  const list = page.getByRole("list", { name: "Vessels" });
  await list.getByRole("button", { name: /brand-new/ }).getByText("not heard since the server started").waitFor();
  await list.getByRole("button", { name: /otter-1/ }).getByText(/Executing plan square \d of 4/).waitFor();
  await list.getByRole("button", { name: /brand-new/ }).getByText("state of its parts unknown").waitFor();
  const names = () => list.locator(".name").allInnerTexts();
  check((await names())[0].startsWith("brand-new"), "by name");
  await page.getByLabel("Sort by").selectOption("plan");
  await page.waitForFunction(() => document.querySelector(".systems .name").textContent.startsWith("otter-2"));
  check((await names()).at(-1).startsWith("brand-new"), "what is not known comes last");
  await page.getByLabel("Sort by").selectOption("longest silence first");
  await page.waitForFunction(() => document.querySelector(".systems .name").textContent.startsWith("brand-new"));
  await look(page, "fleet-sorted");
  await page.reload();
  await page.waitForFunction(() => document.querySelector(".systems .name")?.textContent.startsWith("brand-new"));
  check((await page.getByLabel("Sort by").inputValue()) === "heard", "the choice stays");
  await page.getByLabel("Sort by").selectOption("name");

  // The route of the plan that the vessel sails, and the maneuver that it is at.
  await page.goto(`${url}/vessels/${OTTER}`);
  const line = page.locator(".under-way");
  await line.getByText(/^Sails square: maneuver \d of 4, /).waitFor();
  await look(page, "route");

  // Somebody else starts another one: it is drawn as well.
  const orders = (of, path, body) =>
    of.evaluate(async ([path, body]) => {
      const headers = { "content-type": "application/json", "x-csrf-token": document.querySelector('meta[name="csrf"]').content };
      const answer = await fetch(path, { method: "POST", headers, body: JSON.stringify(body) });
      return [answer.status, await answer.json()];
    }, [path, body]);
  const other = await open();
  await logIn(other, url, "admin", password);
  await other.goto(`${url}/account`);
  const base = `/api/v1/vessels/${OTTER}`;
  /** Nobody renews what this window has: pictures take longer than it lasts. */
  const control = async () => check((await orders(other, `${base}/lease`, { action: "request", window: "z" }))[0] === 200, "control");
  await control();
  const fix = (await (await page.request.get(`${url}/api/v1/vessels`)).json()).find((one) => one.address === OTTER).fix;
  const there = { kind: "goto", lat_deg: fix.lat_deg + 0.002, lon_deg: fix.lon_deg, speed_mps: 1 };
  check((await orders(other, `${base}/commands`, { order: there, window: "z" }))[0] === 202, "goes");
  await line.getByText("Sails lutra-goto: maneuver 1 of 2, go").waitFor();

  // Plans ashore beside those aboard: same, only there, differs.
  await page.goto(`${url}/plans`);
  const row = (name) => page.getByRole("row", { name: new RegExp(`^${name} `) });
  await row("square").locator('[data-copy="same"]').first().waitFor();
  await row("lutra-goto").locator('[data-copy="only aboard"]').first().waitFor();
  const place = (north) => ({ lat_deg: fix.lat_deg + north, lon_deg: fix.lon_deg });
  const step = (id, north) => ({ id, speed: { value: 1, unit: "mps" }, task: { kind: "goto", at: place(north) } });
  const plan = { name: LONG, description: "", vessel: null, repeat: true, maneuvers: [step("one", 0.000_25), step("<b>two</b>", 0.002)] };
  const [, made] = await orders(page, "/api/v1/plans", plan);
  const saved = await page.evaluate(async ([path, body]) => {
    const headers = { "content-type": "application/json", "x-csrf-token": document.querySelector('meta[name="csrf"]').content };
    return (await fetch(path, { method: "PUT", headers, body: JSON.stringify(body) })).json();
  }, [`/api/v1/plans/${made.id}`, { revision: made.revision, draft: false, plan }]);
  await page.reload();
  await row(LONG).locator('[data-copy="only ashore"]').first().waitFor();
  await control();
  const [status, sent] = await orders(other, `/api/v1/plans/${made.id}/upload`, { vessel: OTTER, revision: saved.revision, window: "z" });
  check(status === 202, JSON.stringify(sent));
  const ended = await page.evaluate(async ([path]) => {
    for (;;) {
      const command = await (await fetch(path)).json();
      if (command.over) return command;
      await new Promise((done) => setTimeout(done, 100));
    }
  }, [`${base}/commands/${sent.id}`]);
  check(ended.steps.at(-1).stage === "effect seen", JSON.stringify(ended.steps));
  await page.getByRole("button", { name: "Compare with the vessels again" }).click();
  await row(LONG).locator('[data-copy="same"]').getByText(/same [0-9a-f]{8}/).waitFor();
  plan.maneuvers[0].speed.value = 2;
  await page.evaluate(async ([path, body]) => {
    const headers = { "content-type": "application/json", "x-csrf-token": document.querySelector('meta[name="csrf"]').content };
    await fetch(path, { method: "PUT", headers, body: JSON.stringify(body) });
  }, [`/api/v1/plans/${made.id}`, { revision: saved.revision, draft: false, plan }]);
  await page.reload();
  await row(LONG).locator('[data-copy="differs"]').getByText(/DIFFERS [0-9a-f]{8}/).waitFor();
  await look(page, "plans-copies");

  // A long name is whole on the tile, and a plan that does not run has no progress.
  await control();
  check((await orders(other, `${base}/commands`, { order: { kind: "plan.start", plan_id: LONG }, window: "z" }))[0] === 202, "starts");
  await page.goto(`${url}/vessels/${OTTER}`);
  // The mark goes on with the vessel: its first maneuver ends after some metres.
  await line.getByText(`Sails ${LONG}: maneuver 1 of 2, one`).waitFor();
  await line.getByText(`Sails ${LONG}: maneuver 2 of 2, <b>two</b>`).waitFor({ timeout: 3 * PATIENCE_MS });
  const tile = page.locator('[data-tile="plan"] .reading');
  await tile.getByText(LONG).waitFor();
  check(await tile.evaluate((node) => node.scrollHeight <= node.clientHeight + 1), "the tile holds the whole name");
  await look(page, "route-long");
  await control();
  check((await orders(other, `${base}/commands`, { order: { kind: "plan.stop" }, window: "z" }))[0] === 202, "stops");
  await page.locator('[data-tile="progress"]').getByText("no plan runs").waitFor();
  await line.waitFor({ state: "hidden" });
});
