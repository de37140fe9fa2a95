// Two people, one boat: control of a simulated Otter and orders to it: node control.mjs URL PASSWORD. Prints what it
// wants done to processes.

import { check, inBrowser, logIn, look } from "./browser.mjs";

const [url, password] = process.argv.slice(2);
const OTTER = 10449;

await inBrowser(async (open) => {
  const one = await open();
  await logIn(one, url, "admin", password);

  // A second operator and a viewer.
  const people = [];
  for (const [name, role] of [["nils", "operator"], ["vera", "viewer"]]) {
    await one.goto(`${url}/admin`);
    const form = one.locator("main form.card");
    await form.getByLabel("Name").fill(name);
    await form.getByLabel("Role").selectOption(role);
    await form.getByRole("button", { name: "Add" }).click();
    const secret = await one.locator(".secret").innerText();
    const page = await open();
    await logIn(page, url, name, secret, "seven small boats at sea");
    people.push(page);
  }
  const [two, viewer] = people;
  const all = [one, two, viewer];
  const button = (page, name) => page.getByRole("button", { name, exact: true });
  const who = (page, text, options) => page.locator(".control-box .who").getByText(text).waitFor(options);
  const control = async (page, vessel) => {
    await page.goto(`${url}/vessels/${vessel}`);
    await page.getByText("Live", { exact: true }).waitFor();
    await page.getByRole("tab", { name: "Control" }).click();
  };

  for (const page of all) {
    await control(page, OTTER);
    await page.getByText("Nobody has control of this vessel.").waitFor();
  }
  // Which window of a person has control is known to that window and to the server.
  const windows = new Map();
  for (const page of all) page.on("request", (request) => request.url().endsWith("/lease") && request.method() === "POST" && windows.set(page, request.postDataJSON().window));
  check((await viewer.locator(".control-box button").count()) === 0, "a viewer sees and cannot");
  check(await one.getByRole("button", { name: "Stop plan" }).isDisabled(), "nothing without control");
  await look(one, "control-free");

  // Request, notice, grant.
  await button(one, "Take control").press("Enter");
  await who(one, "You have control of this vessel.");
  for (const page of [two, viewer]) await who(page, "admin has control.");
  await two.getByLabel("Reason, for the one who has control").fill("my survey begins");
  await button(two, "Ask for control").click();
  await one.getByText("nils asks for control: my survey begins").waitFor();
  await one.getByText(/Without an answer it is granted in \d+ s/).waitFor();
  await look(one, "control-asked");
  await button(one, "Grant to nils").click();
  await who(two, "You have control of this vessel.");
  await who(one, "nils has control.");

  // A request that is declined, and taking over: two steps, with a reason that the other reads.
  await button(one, "Ask for control").click();
  // Who asks is told on every page, and on every page of the window control is kept.
  const renewed = two.waitForRequest((request) => request.url().endsWith("/lease") && request.postDataJSON()?.action === "renew");
  await two.goto(`${url}/plans`);
  await two.getByText(/^admin asks for control of otter-1\. Granted in \d+ s unless you answer\./).waitFor();
  await look(two, "control-asked-elsewhere");
  await renewed;
  await two.getByRole("button", { name: "Decline: admin, otter-1", exact: true }).click();
  await two.getByText("admin asks for control").waitFor({ state: "hidden" });
  await two.goto(`${url}/vessels/${OTTER}?tab=Control`);
  await who(two, "You have control of this vessel.");
  await button(one, "Take over …").click();
  await one.getByRole("alert").getByText("Enter a reason for taking over: nils will see it.").waitFor();
  await one.getByLabel("Reason, for the one who has control").fill("it drifts ashore");
  await button(one, "Take over …").click();
  await one.getByText(/nils loses control at once/).waitFor();
  await look(one, "control-take-over");
  // The question goes away by itself after a while, as it may during the pictures.
  if (!(await button(one, "Take over now").isVisible())) await button(one, "Take over …").click();
  await button(one, "Take over now").click();
  await who(one, "You have control of this vessel.");
  await who(two, "Taken over from nils: it drifts ashore.");
  check(await two.getByRole("button", { name: "Stop plan" }).isDisabled(), "who lost control cannot command");

  // Stop what runs, then start a plan in two steps, with what will happen in words.
  const row = (page, order) => page.locator(`.commands > li[data-order="${order}"]`).first();
  await button(one, "Stop plan").click();
  await row(one, "plan.stop").getByText(/done/).waitFor();
  await button(one, "Refresh plans aboard").click();
  await one.getByRole("row", { name: /square/ }).waitFor();
  await button(one, "Start square …").click();
  const confirm = one.getByRole("group", { name: "Start square on otter-1?" });
  await confirm.getByText(/First leg: \d{3}° T, \d+ m/).waitFor();
  const words = await confirm.innerText();
  check(/Vessel: otter-1/.test(words) && /Digest: [0-9a-f]{32}/.test(words), words);
  await look(one, "control-confirm");
  await one.keyboard.press("Escape");
  check((await confirm.count()) === 0, "Escape ends it");
  // The demonstration started it before: what is looked at is the order of this person, the newest one.
  const starts = one.locator('.commands > li[data-order="plan.start"]').filter({ hasText: "by admin" });
  const before = await starts.count();
  await button(one, "Start square …").click();
  await button(one, "Start square").click();
  await starts.nth(before).waitFor();
  const started = starts.first();
  await started.getByText(/done executing square/).waitFor();
  const stages = await started.innerText();
  for (const stage of ["accepted", "sent", "done"]) check(stages.includes(stage), `${stage} in ${stages}`);
  // On a busy computer the mode that the vessel reports can overtake its receipt or its answer: a stage is never added behind a later one.
  check(stages.includes("received") || stages.includes("executing"), `received or executing in ${stages}`);
  await viewer.locator('.commands > li[data-order="plan.start"]').filter({ hasText: "by admin" }).first().getByText(/done/).waitFor();

  // Go to a clicked point, and to a typed one.
  await button(one, "Choose on the map").click();
  await one.locator(".map").click({ position: { x: 200, y: 220 } });
  await one.waitForFunction((place) => place.value !== "", await one.getByLabel("Latitude, °").elementHandle());
  await button(one, "Go there …").click();
  await one.getByText(/First leg: \d{3}° T/).waitFor();
  await button(one, "Go").click();
  await row(one, "goto").getByText(/done executing lutra-goto/).waitFor();

  // What the vessel refuses is told with its reason.
  const order = (page, order) =>
    page.evaluate(async ([path, order, window]) => {
      const headers = { "content-type": "application/json", "x-csrf-token": document.querySelector('meta[name="csrf"]').content };
      const body = JSON.stringify({ order, window });
      return (await fetch(path, { method: "POST", headers, body })).status;
    }, [`/api/v1/vessels/${OTTER}/commands`, order, windows.get(page) ?? "another"]);
  check((await order(one, { kind: "plan.start", plan_id: "nowhere" })) === 202, "taken");
  await row(one, "plan.start").getByText(/refused undefined plan/i).waitFor();
  check((await order(viewer, { kind: "plan.stop" })) === 403, "a viewer is refused by the server too");
  await look(one, "control-commands");

  await button(one, "Release control").click();
  await who(two, "Nobody has control of this vessel.");

  // A vessel that is not heard: the missing stage is named.
  await button(two, "Take control").click();
  await who(two, "You have control of this vessel.");
  console.log("silence otter-1");
  await button(two, "Stop plan").click();
  await row(two, "plan.stop").getByText(/timed out|expired/).waitFor();
  await look(two, "control-timed-out");
  console.log("wake otter-1");
  await button(two, "Release control").click();
  await who(two, "Nobody has control of this vessel.");

  // From the page of one vessel the others are stopped too, and what became of that is seen there.
  await two.getByText("Others …", { exact: true }).click();
  await two.getByRole("button", { name: "STOP otter-2", exact: true }).click();
  await two.getByText(/^STOP otter-2: stopped after/).waitFor();
  // On a tablet that stays in sight, with the alarms, and nothing that gets the focus is beneath it.
  await two.setViewportSize({ width: 820, height: 1180 });
  await two.evaluate(() => scrollTo(0, document.body.scrollHeight));
  const inSight = (one) => one.evaluate((node) => {
    const box = node.getBoundingClientRect();
    return node.contains(document.elementFromPoint(box.left + 2, box.top + box.height / 2));
  });
  check(await inSight(two.getByText(/^STOP otter-2: stopped after/)), "what became of the stop is in sight");
  check(await inSight(two.locator(".alarm-bar .worst")), "the alarm bar is in sight");
  check(await two.evaluate(() => scrollY > 200), "the page is scrolled");
  await two.getByLabel("Latitude, °").focus();
  for (let steps = 0; steps < 30; steps++) {
    await two.keyboard.press("Shift+Tab");
    const hidden = await two.evaluate(() => {
      const [one, top] = [document.activeElement, document.getElementById("top")];
      return !top.contains(one) && !one.matches(".skip") && one.getBoundingClientRect().bottom <= top.getBoundingClientRect().bottom + 1 ? one.outerHTML.slice(0, 80) : "";
    });
    check(!hidden, `${hidden} has the focus and is hidden`);
  }
  await two.setViewportSize({ width: 1440, height: 900 });
});
