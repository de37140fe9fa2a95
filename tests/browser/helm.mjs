// What scripts that steer a simulated Otter by hand share: taking control, beginning, holding, and what its motors do.

import { check } from "./browser.mjs";

export const [url, password] = process.argv.slice(2);
export const OTTER = 10256;
export const TRIES = 20;
export const PATIENCE_MS = 60_000;

/** Steering by keys, on a page. */
export const keysOf = (page) => ({
  async release() {
    for (const key of ["ArrowUp", "Space"]) await page.keyboard.up(key);
  },
  async hold() {
    await page.locator(".helm-keys").focus();
    await page.keyboard.down("Space");
  },
  steer: () => page.keyboard.down("ArrowUp"),
});
export const tell = (text) => console.log(text);
export const button = (page, name) => page.getByRole("button", { name, exact: true });
export const phase = (page, name, options) => page.locator(`.helm[data-phase="${name}"]`).waitFor(options);
export const within = (wait) => wait.then(() => true, () => false);
export const helmNote = (page) => page.getByRole("region", { name: "Steer by hand" }).getByRole("alert");

/** What the vessel says it gave its motors, since `fromMs`. Whoever asks need not be the one who steers. */
export const motors = async (asker, fromMs) => {
  const from = new Date(fromMs).toISOString();
  const csv = await asker.request.get(`${url}/api/v1/export.csv?message=SetThrusterActuation&vessel=${OTTER}&from=${from}`).catch(() => undefined);
  // Without a server, or without a way to it, nobody tells.
  if (!csv?.ok()) return [];
  const rows = (await csv.text()).trim().split("\n").slice(1).map((row) => row.split(","));
  return rows.map((row) => ({ at: Number(row[1]) * 1e3, motor: Number(row.at(-2)), value: Number(row.at(-1)) }));
};
export const runs = (rows) => [0, 1].every((motor) => (rows.filter((row) => row.motor === motor).at(-1)?.value ?? 0) > 0.1);

export const enter = async (page) => {
  // A server that was killed is back soon, and its old connections are told to be broken one by one.
  for (let tries = 0; !(await within(page.goto(`${url}/vessels/${OTTER}`))); tries++) {
    check(tries < 50, "the server does not come back");
    await page.waitForTimeout(200);
  }
  await page.getByText("Live", { exact: true }).waitFor();
  await page.getByRole("tab", { name: "Control" }).click();
};
export const takeControl = async (page) => {
  await enter(page);
  const take = page.locator(".control").getByRole("button", { name: /^Take (control|control here|over …)$/ });
  const mine = page.getByText("You have control of this vessel.");
  await take.or(mine).first().waitFor();
  if (!(await mine.isVisible())) {
    if ((await take.innerText()) === "Take over …") {
      await page.getByLabel("Reason, for the one who has control").fill("a test");
      await take.click();
      await button(page, "Take over now").click();
    } else await take.click();
  }
  await mine.waitFor();
  const up = async () => (await (await page.request.get(`${url}/api/v1/links`)).json()).some((one) => one.vessel === OTTER && one.up);
  for (const end = Date.now() + 60_000; !(await up()); ) check(Date.now() < end, "the link does not stand");
};
export const begin = async (page) => {
  const note = helmNote(page);
  for (let tries = 0; ; tries++) {
    await button(page, "Steer by hand …").click();
    await button(page, "Steer by hand").click();
    await page.locator('.helm[data-phase="ready"]').or(note).first().waitFor();
    if (!(await note.isVisible())) return;
    check(tries < TRIES, `not begun: ${await note.innerText()}`);
  }
};
/** Takes hold until the vessel itself says that its motors turn. `hands` press and release. */
export const hold = async (page, asker, hands) => {
  for (let tries = 0; ; tries++) {
    check(tries < TRIES, "the motors do not turn");
    await hands.release();
    await phase(page, "ready");
    tell(`may ${Date.now()}`);
    const from = Date.now();
    await hands.hold();
    if (!(await within(phase(page, "steering", { timeout: 5_000 })))) continue;
    await hands.steer();
    const steers = page.locator('.helm[data-phase="steering"]');
    for (const end = Date.now() + 15_000; Date.now() < end && (await steers.isVisible()); ) {
      if (runs(await motors(asker, from))) return;
    }
  }
};
