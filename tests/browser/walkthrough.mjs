// Tasks of an operator and of a biologist with their clicks counted and pictures of each step: node walkthrough.mjs LUTRA-SERVER
// [TASK ...], as `scripts/walkthrough` starts it. Says what each task took; judges nothing.

import { mkdir } from "node:fs/promises";
import { join } from "node:path";
import { inBrowser, logIn, SIZES } from "./browser.mjs";
import { withDemo } from "./demoserver.mjs";

const [program, ...only] = process.argv.slice(2);
const [FOLDER, VESSEL, PATIENCE_MS] = ["target/walkthrough", "otter-1", 60_000];

/** Begins at the first page; `press` counts, `picture` shows. */
const TASKS = {
  "see how a vessel is": async ({ page, press, picture }) => {
    await page.locator(".vessel-card", { hasText: VESSEL }).getByText("Executing plan").waitFor();
    await picture("fleet");
    await press(page.getByRole("link", { name: `Open ${VESSEL}` }));
    await page.locator('[data-tile="mode"]').getByText("Executing plan").waitFor();
    await picture("vessel");
  },
  "stop a vessel and start its plan again": async ({ page, press, picture }) => {
    await page.locator(".vessel-card", { hasText: VESSEL }).getByText("Executing plan").waitFor();
    await press(page.locator("#stop").getByRole("button", { name: `STOP ${VESSEL}`, exact: true }));
    await page.getByText(new RegExp(`^STOP ${VESSEL}: stopped after`)).waitFor();
    await picture("stopped");
    await press(page.getByRole("link", { name: `Open ${VESSEL}` }));
    await press(page.getByRole("tab", { name: "Control" }));
    await press(page.getByRole("button", { name: "Take control", exact: true }));
    await press(page.getByRole("button", { name: "Start square …" }));
    await picture("sure");
    await press(page.getByRole("button", { name: "Start square", exact: true }));
    await page.locator('[data-tile="mode"]').getByText("Executing plan").waitFor();
    await picture("sails");
    await page.getByRole("button", { name: "Release control" }).click();
  },
  "draw a plan": async ({ page, press, picture }) => {
    await press(page.getByRole("link", { name: "Plans", exact: true }));
    await press(page.getByRole("button", { name: "New plan" }));
    await press(page.getByRole("button", { name: "Path", exact: true }));
    const box = await page.locator(".map").boundingBox();
    for (const [x, y] of [[0.4, 0.4], [0.6, 0.4], [0.6, 0.6]]) await press(page.locator(".map"), { position: { x: box.width * x, y: box.height * y } });
    await page.getByText(/^(Safe|Partly checked|Not safe)/).first().waitFor();
    await picture("drawn");
    await press(page.getByRole("button", { name: "Save", exact: true }));
    await page.getByText(/^Saved/).waitFor();
  },
  "take a day's detections": async ({ page, press, picture }) => {
    await press(page.getByRole("link", { name: "Detections", exact: true }));
    await page.getByRole("region", { name: "Detections" }).getByRole("row").nth(1).waitFor();
    await press(page.getByRole("button", { name: "Today", exact: true }));
    await picture("detections");
    const saved = page.waitForEvent("download");
    await press(page.getByRole("link", { name: "Download all detections" }));
    await saved;
  },
  "take the positions of a recorded day": async ({ page, press, picture }) => {
    await press(page.getByRole("link", { name: "Data", exact: true }));
    await press(page.getByRole("button", { name: "Choose" }).first());
    await page.getByText(/ rows, about /).waitFor();
    await picture("data");
    const saved = page.waitForEvent("download");
    await press(page.getByRole("link", { name: "Download", exact: true }));
    await saved;
  },
  "see when a tag was heard": async ({ page, press, picture }) => {
    await press(page.getByRole("link", { name: `Open ${VESSEL}` }));
    await press(page.getByRole("tab", { name: "Tags" }));
    await page.getByRole("tabpanel", { name: "Tags" }).locator("tbody tr").first().waitFor();
    await picture("tags");
  },
  "look up a word": async ({ page, press, picture }) => {
    await press(page.getByRole("button", { name: "Help" }));
    await page.getByRole("dialog", { name: "Help" }).getByRole("textbox").fill("datum");
    await picture("help");
  },
};

async function walk(page, url, name, task) {
  let [clicks, pictures] = [0, 0];
  const number = String(Object.keys(TASKS).indexOf(name) + 1);
  const press = async (what, options) => {
    clicks += 1;
    await what.click(options);
  };
  const picture = async (step) => {
    pictures += 1;
    for (const size of [...SIZES].sort((one, other) => one.width - other.width)) {
      await page.setViewportSize(size);
      await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
      await page.screenshot({ path: join(FOLDER, `${number}-${pictures}-${step}-${size.width}.png`) });
    }
  };
  await page.setViewportSize({ width: 1440, height: 900 });
  await page.goto(url);
  await page.getByText("Live", { exact: true }).waitFor();
  const began = performance.now();
  await task({ page, press, picture });
  console.log(`${name}: ${clicks} ${clicks === 1 ? "click" : "clicks"}, ${pictures} steps pictured, ${((performance.now() - began) / 1e3).toFixed(0)} s with the pictures`);
}

const unknown = only.filter((name) => !(name in TASKS));
if (unknown.length) {
  console.error(`There is no task ${unknown.join(", ")}. There are: ${Object.keys(TASKS).join("; ")}`);
  process.exit(2);
}
await mkdir(FOLDER, { recursive: true });
await withDemo(program, ["--otters", "2", "--no-cut"], async ({ url, password }) => {
  await inBrowser(async (open) => {
    const page = await open();
    page.context().setDefaultTimeout(PATIENCE_MS);
    await logIn(page, url, "admin", password);
    for (const [name, task] of Object.entries(TASKS)) if (!only.length || only.includes(name)) await walk(page, url, name, task);
  });
  console.log(`Pictures: ${FOLDER}`);
});
