// The past, measuring and parameters by keyboard alone: node keyboard-past.mjs URL PASSWORD.

import { check, inBrowser } from "./browser.mjs";
import { atKeyboard } from "./keys.mjs";

const [url, password] = process.argv.slice(2);
const NAME = "ILOS Lookahead Distance";

await inBrowser(async (open) => {
  const page = await open();
  const { press, to, act, type, follow, logIn, write } = atKeyboard(page);
  await logIn(url, "admin", password);
  await to("Open otter-1");
  await follow(/\/vessels\/\d+/);
  await page.locator('[data-tile="mode"]').getByText("Executing plan").waitFor();

  // Replay: begun, stepped, played and paused, faster, by the slider and the space bar; back to the present.
  const clockMs = async () => Date.parse((await page.locator(".replaybar .clock").textContent()).replace(" ", "T"));
  const clockIs = (ms, what) => page.waitForFunction((ms) => Math.abs(Date.parse(document.querySelector(".replaybar .clock").textContent.replace(" ", "T")) - ms) <= 1_000, ms).catch(() => check(false, what));
  const plays = (name) => page.getByRole("button", { name, exact: true }).waitFor();
  await act("Replay what is shown");
  await page.locator(".replaybar .badge").getByText("REPLAY", { exact: true }).waitFor();
  const began = await clockMs();
  await act("+1 s, step forward");
  await press("Enter");
  await clockIs(began + 2_000, "two steps on");
  await act("−1 s, step back", "Shift+Tab");
  await clockIs(began + 1_000, "one step back");
  await to("Speed");
  await write("10×");
  await page.waitForURL(/speed=10(&|$)/);
  await to(/^Time\. Left and right step/);
  await press("Shift+ArrowRight", "ArrowLeft");
  await clockIs(began + 10_000, "ten steps on and one back");
  await press("Space");
  await plays("Pause");
  await page.waitForFunction((ms) => Date.parse(document.querySelector(".replaybar .clock").textContent.replace(" ", "T")) > ms, began + 14_000);
  await act("Pause", "Shift+Tab");
  await plays("Play");
  const paused = await clockMs();
  // The cursor in a plot, by arrows; Enter goes there.
  await to(/^EstimatedState, m\/s\. Left and right move the cursor/);
  await press("ArrowLeft", "Shift+ArrowLeft");
  await page.locator(".here").getByText(/Z/).waitFor();
  await press("Enter");
  await page.waitForFunction((ms) => Math.abs(Date.parse(document.querySelector(".replaybar .clock").textContent.replace(" ", "T")) - ms) > 2_000, paused);
  await press("Escape");
  await act("Back to live", "Shift+Tab");
  await page.locator(".replaybar .badge").getByText("LIVE", { exact: true }).waitFor();

  // Measuring: the button leads to the map, Enter puts the places in its middle, arrows move it.
  await act("Measure");
  await press("Enter");
  await page.locator(".measured").getByText(/Click the next place, or Enter/).waitFor();
  // The map glides: where it has not begun to, the place is the same and taken back.
  for (let tries = 0; ; tries++) {
    check(tries < 100, "the arrows do not move the map");
    await press("ArrowRight", "Enter");
    if (!/^0\.0 m/.test(await page.locator(".measured").textContent())) break;
    await press("Backspace");
  }
  await page.locator(".measured").getByText(/^\d+(\.\d+)? k?m \(\d+\.\d+ nmi\), 09\d° T$/).waitFor();
  await press("Backspace");
  await page.locator(".measured").getByText(/Click the next place, or Enter/).waitFor();
  await press("Escape");
  await page.waitForFunction(() => document.querySelector(".measured").textContent === "");

  // The log book: what is said at a time is gone to from its row; older and newer by what is shown.
  await to("Plots");
  for (let at = 0; at < 3; at++) await press("ArrowRight");
  await page.getByRole("tabpanel", { name: "Log book" }).locator("tbody tr").first().waitFor();
  await to(/^20\d\d-\d\d-\d\d \d\d:\d\d:\d\dZ$/);
  await press("Enter");
  await page.locator(".replaybar .badge").getByText("REPLAY", { exact: true }).waitFor();
  await act("Back to live", "Shift+Tab");

  // Parameters: control taken, a value typed, written in two steps, read back, and taken back.
  await to("Log book");
  for (let at = 0; at < 4; at++) await press("ArrowRight");
  await page.getByRole("tabpanel", { name: "Control" }).waitFor();
  await act("Take control");
  await page.getByText("You have control of this vessel.").waitFor();
  await to("Control", "Shift+Tab");
  await press("ArrowLeft");
  const box = page.getByRole("tabpanel", { name: "Parameters" });
  await box.getByText("You have control: changes can be written.").waitFor();
  await type(/^Find/, "ilos");
  await to(`${NAME} of Path Control`);
  const field = page.getByRole("textbox", { name: `${NAME} of Path Control` });
  const first = await field.inputValue();
  await press("Control+a");
  await write("18");
  await act("Write 1", "Shift+Tab");
  await box.getByRole("group", { name: "Write 1 parameter to otter-1?" }).getByText(`${first} → 18 m`).waitFor();
  await act("Write to vessel");
  await box.getByText(/confirmed: The vessel reports 18\./).waitFor();
  await act("Read from vessel", "Shift+Tab");
  await box.getByText(/^Read\./).waitFor();
  check((await field.inputValue()) === "18", "the vessel tells what was written");
});
