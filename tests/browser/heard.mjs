// Tags that a boat hears: node heard.mjs URL ONE-TIME-PASSWORD. Prints what the boat hears.

import { readFile } from "node:fs/promises";
import { check, inBrowser, logIn, look, same, table } from "./browser.mjs";

const [url, oneTime] = process.argv.slice(2);
const BOAT = 2068;

/** In the page: its live socket can be closed, and made to leave out detections, as a server that started again does. */
function watch() {
  const [real, parse] = [window.WebSocket, JSON.parse];
  window.WebSocket = class extends real {
    constructor(...asked) {
      super(...asked);
      window.live = this;
    }
  };
  JSON.parse = (...asked) => {
    const frame = parse(...asked);
    if (window.forgetful && frame?.samples) frame.detections = [];
    return frame;
  };
}

await inBrowser(async (open) => {
  const page = await open();
  await page.addInitScript(watch);
  const asked = [];
  page.on("request", (request) => request.url().includes("/detections?") && asked.push(new URL(request.url())));
  await logIn(page, url, "admin", oneTime, "battery horse staple");
  await page.goto(`${url}/vessels/${BOAT}?tab=Tags`);
  const panel = page.getByRole("tabpanel", { name: "Tags" });
  await panel.getByText("No tag was heard in this time.").waitFor();
  const row = (tag) => panel.getByRole("row", { name: new RegExp(tag) });
  const rows = async () => (await panel.locator("tbody tr td:nth-child(2)").allTextContents()).sort();
  const hear = async (number, how, tag) => {
    console.log(`hear ${number} ${how}`);
    await row(tag).waitFor();
  };
  const before = asked.length;

  // By the message that every vessel sends, by both of Lutra's, of a coding without a number, and late.
  await hear(101, "brief", "R64K-101");
  await hear(102, "whole", "R64K-102");
  await hear(103, "nameless", "OPi-103");
  await row("OPi-103").getByText("time of arrival: the receiver's clock is not set").waitFor();
  await page.getByRole("button", { name: "More instruments" }).click();
  await page.locator('[data-tile="snr"]').getByText("OPi-103").waitFor();
  await hear(104, "late", "R64K-104");
  same(await rows(), ["OPi-103", "R64K-101", "R64K-102", "R64K-104"], "each once");
  check(await panel.locator("tbody tr").last().getByText("R64K-104").isVisible(), "the one of ten minutes ago is the oldest");

  // Nothing of it is asked for again and again: neither tags nor log book nor track.
  const again = [];
  const past = (request) => /\/(logbook|track|detections)\?/.test(request.url()) && again.push(request.url());
  page.on("request", past);
  for (let times = 0; times < 3; times++) await page.waitForRequest((request) => request.url().endsWith("/links"));
  page.off("request", past);
  same(again, [], "questions about the past");
  same(asked.length, before, "questions for tags");

  // They lie on the map: zoomed out far enough, as one group in the middle.
  const map = page.locator(".map");
  await page.getByRole("button", { name: "Show all", exact: true }).click();
  await page.waitForTimeout(400);
  await map.focus();
  for (let at = 0; at < 12; at++) await page.keyboard.press("-", { delay: 200 });
  await page.waitForTimeout(600);
  const middle = await map.boundingBox();
  await page.mouse.click(middle.x + middle.width / 2, middle.y + middle.height / 2);
  await page.getByText("4 of 4 detections: those at the chosen place on the map.").waitFor();
  await page.getByRole("button", { name: "Show all tags" }).click();

  // The legend lists them by protocol and number with their counts; a click, or a key, hides one on the map and in the table.
  const legend = page.getByRole("region", { name: "Tag legend" });
  const tool = page.getByRole("group", { name: "Map tools" }).getByRole("button", { name: "Tag legend", exact: true });
  check(!(await legend.isVisible()), "it takes no room of a map that has little");
  await tool.click();
  await legend.waitFor();
  same((await legend.getByRole("listitem").allInnerTexts()).map((text) => text.trim().replace(/\s+/g, " ")).sort(), ["OPi-103 1", "R64K-101 1", "R64K-102 1", "R64K-104 1"], "the legend");
  const colour = (one) => one.evaluate((node) => getComputedStyle(node, "::before").backgroundColor);
  for (const tag of ["R64K-101", "R64K-102", "OPi-103"]) {
    const [here, there] = [await colour(legend.locator("[data-tag]", { hasText: tag })), await colour(row(tag).locator("[data-tag]"))];
    check(here === there && here !== "", `${tag} is ${here} in the legend and ${there} in the table`);
  }
  await legend.getByRole("checkbox", { name: /R64K-101/ }).click();
  await row("R64K-101").waitFor({ state: "detached" });
  await panel.getByText("3 of 4 detections; the legend on the map hides the others.").waitFor();
  await legend.getByRole("checkbox", { name: /R64K-102/ }).focus();
  await page.keyboard.press("Space");
  await row("R64K-102").waitFor({ state: "detached" });
  await legend.getByText("2 of 4 shown").waitFor();
  // What is left is on the map: the group in the middle has two.
  await page.mouse.click(middle.x + middle.width / 2, middle.y + middle.height / 2);
  await panel.getByText("2 of 4 detections: those at the chosen place on the map.").waitFor();
  await page.getByRole("button", { name: "Show all tags" }).click();
  await look(page, "vessel-tags");
  // It is remembered for the window, here and on the page of all detections; another window has all.
  await page.reload();
  await legend.getByText("2 of 4 shown").waitFor();
  same(await rows(), ["OPi-103", "R64K-104"], "after a reload");
  await page.goto(`${url}/detections`);
  await page.getByRole("checkbox", { name: /R64K-101/ }).and(page.locator(":not(:checked)")).waitFor();
  await page.goto(`${url}/vessels/${BOAT}?tab=Tags`);
  await legend.getByRole("button", { name: "All tags" }).click();
  await row("R64K-101").waitFor();
  same((await rows()).length, 4, "all again");
  // The tool folds it, and so does Escape.
  await tool.click();
  await legend.waitFor({ state: "hidden" });
  await tool.press("Enter");
  await legend.getByRole("checkbox").first().press("Escape");
  await legend.waitFor({ state: "hidden" });
  check(await tool.evaluate((node) => node === document.activeElement && node.getAttribute("aria-expanded") === "false"), "the keyboard is back on the tool");
  // On a phone it is folded until somebody opens it.
  const phone = await open({ viewport: { width: 390, height: 844 }, storageState: await page.context().storageState() });
  await phone.goto(`${url}/vessels/${BOAT}?tab=Tags`);
  await phone.getByRole("group", { name: "Map tools" }).getByRole("button", { name: "Tag legend", exact: true }).and(phone.locator('[aria-expanded="false"]')).waitFor();
  check(await phone.getByRole("region", { name: "Tag legend" }).isHidden(), "folded on a phone");
  await phone.getByRole("button", { name: "Tag legend", exact: true }).click();
  await phone.getByRole("checkbox", { name: /R64K-101/ }).waitFor();
  await look(phone, "vessel-tags-phone");
  await phone.close();

  // A file has what the messages carried, and nothing else.
  const saved = page.waitForEvent("download");
  await page.getByRole("link", { name: "Download CSV of tags heard" }).click();
  const file = table(await readFile(await (await saved).path(), "utf8"));
  const cells = (tag, ...names) => names.map((name) => file.rows.find((one) => one[file.head.indexOf("tag")] === tag)[file.head.indexOf(name)]);
  const names = ["sensor_value [count]", "clock", "position_age [s]", "position_deviation [m]", "raw_line"];
  same(cells("R64K-101", ...names), ["", "set", "", "", ""], "by TBRFishTag alone");
  same(cells("R64K-102", ...names), ["", "set", "0.4", "0.8", "$001024,a line"], "by both messages");
  same(cells("OPi-103", ...names, "heard_utc", "clock_count [s]"), ["", "not set", "0.4", "0.8", "$001024,a line", "", "600.250"], "without a clock");

  // One that no frame brought is asked for when the connection starts over, from the last word on, and the others stay.
  await page.evaluate(() => (window.forgetful = true));
  console.log("hear 105 whole");
  const path = `${url}/api/v1/vessels/${BOAT}/detections?from_us=0&to_us=4000000000000000`;
  const recorded = async () => (await (await page.request.get(path)).json()).detections.some((one) => one.tag_id === 105);
  for (let times = 0; !(await recorded()); times++) {
    check(times < 100, "it is recorded");
    await page.waitForTimeout(100);
  }
  same(await row("R64K-105").count(), 0, "rows of what no frame brought");
  const questions = asked.length;
  await page.evaluate(() => window.live.close());
  await row("R64K-105").waitFor();
  same(await rows(), ["OPi-103", "R64K-101", "R64K-102", "R64K-104", "R64K-105"], "none twice");
  same(asked.length, questions + 1, "questions for what was missed");
  const since = Number(asked.at(-1).searchParams.get("received_since_us"));
  check(Math.abs(since / 1e3 - Date.now()) < 600_000, `since ${since}`);

  // And it goes on by itself.
  await page.evaluate(() => (window.forgetful = false));
  await hear(106, "whole", "R64K-106");
  same(asked.length, questions + 1, "questions in the end");
});
