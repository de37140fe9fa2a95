// A note and a mission on a bad link: node logbook-retry.mjs URL ONE-TIME-PASSWORD FROM TO. The server takes them and the answer
// is lost: the form sends it again by itself, and there is one. Prints nothing.

import { check, fits, inBrowser, logIn, look, same } from "./browser.mjs";

const [url, oneTime] = process.argv.slice(2);

await inBrowser(async (open) => {
  const page = await open();
  await logIn(page, url, "admin", oneTime, "nine grey otters");
  const keys = [];
  /** Loses the answers to so many notes from here on; what the server did is done. */
  let lost = 0;
  /** The second and the third try wait until they are let go, so that there is time to look. */
  const gates = new Map([2, 3].map((number) => {
    let open;
    const opened = new Promise((done) => (open = done));
    return [number, { open, opened }];
  }));
  await page.route(/\/api\/v1\/logbook\?key=/, async (route) => {
    keys.push(new URL(route.request().url()).searchParams.get("key"));
    await gates.get(keys.length)?.opened;
    if (lost-- <= 0) return route.continue();
    const answer = await route.fetch();
    check(answer.ok(), `the server took it: ${answer.status()}`);
    await route.abort("connectionreset");
  });
  await page.goto(`${url}/logbook`);
  const form = page.getByRole("form", { name: "Write a note" });
  const text = form.getByLabel("Text");
  const write = form.getByRole("button", { name: "Write", exact: true });

  lost = 2;
  await text.fill("Receiver 12 moved 40 m west");
  await write.click();
  const status = form.getByRole("status");
  await status.getByText("No answer yet. Trying again; what you wrote is kept here …").waitFor();
  await look(page, "logbook-no-answer");
  await page.setViewportSize({ width: 390, height: 844 });
  await fits(page, "the form while it waits");
  await page.setViewportSize({ width: 1440, height: 900 });
  gates.get(2).open();
  await status.getByText("No answer after 2 tries. Trying again; what you wrote is kept here …").waitFor();
  // The form is empty when it was answered.
  gates.get(3).open();
  await page.waitForFunction((node) => node.value === "", await text.elementHandle());
  await page.getByRole("listitem").filter({ hasText: "Receiver 12 moved" }).waitFor();
  await page.getByText("1 note.", { exact: true }).waitFor();
  same([keys.length, new Set(keys).size], [3, 1], "three times by one key");

  // The same words on purpose are another note.
  await text.fill("Receiver 12 moved 40 m west");
  await write.click();
  await page.getByText("2 notes.", { exact: true }).waitFor();
  same([keys.length, new Set(keys).size], [4, 2], "by another key");

  // A mission likewise.
  const missionKeys = [];
  await page.route(/\/api\/v1\/missions\?key=/, async (route) => {
    missionKeys.push(new URL(route.request().url()).searchParams.get("key"));
    if (missionKeys.length > 1) return route.continue();
    check((await route.fetch()).ok(), "the server took the mission");
    await route.abort("connectionreset");
  });
  await page.goto(`${url}/missions`);
  await page.getByRole("button", { name: "New mission" }).click();
  const mission = page.getByRole("form", { name: "New mission" });
  await mission.getByLabel("Name").fill("Sent twice");
  await mission.getByRole("checkbox").first().check();
  await mission.getByRole("button", { name: "Save" }).click();
  await page.getByRole("heading", { name: "Sent twice" }).waitFor();
  await page.goto(`${url}/missions`);
  await page.getByRole("link", { name: "Sent twice" }).waitFor();
  same([await page.getByRole("link", { name: "Sent twice" }).count(), missionKeys.length, new Set(missionKeys).size], [1, 2, 1], "missions");
});
