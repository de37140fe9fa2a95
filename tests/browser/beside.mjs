// Several vessels in one view, on two simulated Otters: node beside.mjs URL PASSWORD.

import { readFile } from "node:fs/promises";
import { check, inBrowser, logIn, look, sameSamples, until } from "./browser.mjs";

const [url, password] = process.argv.slice(2);
const [OWN, OTHER] = [10449, 10450];
/** Farther back than the place in the plot that is clicked at. */
const PAST_MS = 10_000;

await inBrowser(async (open) => {
  const page = await open();
  await logIn(page, url, "admin", password);
  await page.goto(`${url}/vessels/${OWN}?span=60`);
  const vessels = page.getByRole("region", { name: "Vessels", exact: true });
  const plot = page.getByRole("region", { name: "EstimatedState, m/s", exact: true });
  await plot.waitFor();
  check((await page.getByRole("list", { name: "Vessels in this view" }).count()) === 0, "one vessel needs no legend");

  // Another joins by keyboard; the address tells it.
  await vessels.getByRole("button", { name: "+ Vessel" }).focus();
  await page.keyboard.press("Enter");
  const choice = page.getByRole("combobox", { name: "Another vessel in this view" });
  await choice.waitFor();
  check(await choice.evaluate((node) => node === document.activeElement), "what to choose has the focus");
  await choice.selectOption("otter-2");
  await page.waitForURL(/with=10450/);
  const legend = page.getByRole("list", { name: "Vessels in this view" });
  await legend.getByText("otter-1").waitFor();
  await legend.getByRole("link", { name: "otter-2" }).waitFor();

  // Both are in one plot, with values of their own, live and as files.
  const told = (name) => plot.locator(".legend li").filter({ hasText: name });
  for (const name of [/^Navigation forward speed\s*−?\d.* m\/s/, /otter-2 Navigation forward speed\s*−?\d.* m\/s/]) await told(name).waitFor();
  const link = plot.getByRole("link", { name: /Download CSV of otter-2 EstimatedState u/ });
  await link.waitFor();
  check(new URL(await link.getAttribute("href"), url).searchParams.get("vessel") === String(OTHER), "the file is the other's");
  await look(page, "beside-live");

  // The past: one time for both. Their places then are what the history has of each, once it goes back far enough.
  const forwardSpeed = async (timeUs) => {
    const at = await (await page.request.get(`${url}/api/v1/vessels/${OTHER}/at?time_us=${Math.round(timeUs)}`)).json();
    return at.values.find((one) => one.abbrev === "EstimatedState")?.fields.find(({ name }) => name === "u").value;
  };
  await until(async () => (await forwardSpeed((Date.now() - PAST_MS) * 1e3)) !== undefined, "a past of some seconds");
  await page.getByRole("button", { name: "Zoom out" }).click();
  const over = plot.locator(".u-over");
  await over.scrollIntoViewIfNeeded();
  const box = await over.boundingBox();
  await over.click({ position: { x: box.width - 30, y: 60 } });
  await page.locator(".replaybar .badge").getByText("REPLAY", { exact: true }).waitFor();
  await page.mouse.move(5, 5);
  await page.waitForURL(/t=\d+.*with=10450|with=10450.*t=\d+/);
  const query = new URL(page.url()).searchParams;
  const t = Number(query.get("t"));
  const u = await forwardSpeed(t);
  const then = async () => Number.parseFloat((await told(/otter-2 Navigation forward speed\s*−?\d.* m\/s/).locator(".num").innerText()).replace("−", "-"));
  await until(async () => Math.abs((await then()) - u) < 0.3, `the other's speed of then, about ${u} m/s`);
  // Its file holds what the history has of it in the time that is shown.
  const saved = page.waitForEvent("download");
  const [fromMs, toMs] = ["from", "to"].map((end) => Number(query.get(end)) / 1e3);
  await link.click();
  const csv = await readFile(await (await saved).path(), "utf8");
  const entity = new URL(await link.getAttribute("href"), url).searchParams.get("entity");
  const asked = `from_us=${Math.floor(fromMs) * 1e3}&to_us=${Math.ceil(toMs) * 1e3}`;
  const samples = await page.request.get(`${url}/api/v1/vessels/${OTHER}/samples?message=EstimatedState&entity=${entity}&fields=u&limit=10000&${asked}`);
  sameSamples(csv, await samples.json(), "u");
  await page.getByRole("button", { name: "Show all", exact: true }).click();
  await look(page, "beside-replay");

  // The address shows the same again; each can be taken out.
  await page.reload();
  await legend.getByRole("link", { name: "otter-2" }).waitFor();
  check(new URL(page.url()).searchParams.get("t") === String(t), page.url());
  await legend.getByRole("button", { name: "Remove otter-2 from this view" }).click();
  await page.waitForURL((now) => !now.searchParams.has("with"));
  await plot.waitFor();
  check((await plot.locator(".legend").innerText()).includes("otter-2") === false, "only the page's own is plotted");
});
