// The bar of the plan page, whole maneuvers and drawn areas: node maneuvers.mjs URL ONE-TIME-PASSWORD, against a server that holds
// the demonstration's chart.

import { check, inBrowser, logIn, look } from "./browser.mjs";

const [url, oneTime] = process.argv.slice(2);
const SIZES = [[1440, 900], [1024, 768], [390, 844]];
const BOAT = 2068;
const SPEED = { value: 1.5, unit: "mps" };
const goto = (id, lat_deg, lon_deg) => ({ id, speed: SPEED, task: { kind: "goto", at: { lat_deg, lon_deg } } });
const path = (id, ...points) => ({ id, speed: SPEED, task: { kind: "follow_path", points: points.map(([lat_deg, lon_deg]) => ({ lat_deg, lon_deg })) } });

await inBrowser(async (open) => {
  const page = await open();
  await logIn(page, url, "admin", oneTime, "nine grey otters");
  const csrf = await page.evaluate(() => document.querySelector('meta[name="csrf"]').content);
  await page.request.post(`${url}/admin/vessel`, { form: { csrf, name: "otter-0", address: String(BOAT) }, headers: { origin: url } });
  const draw = async (name, ...maneuvers) => {
    const made = await page.request.post(`${url}/api/v1/plans`, { headers: { "x-csrf-token": csrf }, data: { name, description: "", vessel: BOAT, repeat: false, maneuvers } });
    check(made.ok(), await made.text());
    await page.goto(`${url}/plans/${(await made.json()).id}`);
    await page.locator(".chart-credit").getByText("NOT FOR NAVIGATION").waitFor();
  };
  const stored = async () => (await (await page.request.get(`${url}/api/v1/plans/${page.url().split("/").at(-1)}`)).json()).plan;
  const kept = () => page.getByText(/^(Kept as draft|Saved) .*Z, revision \d+$/).waitFor();
  const bar = page.getByRole("region", { name: "Plan, verdict, and what to do with it" });
  const verdict = bar.locator(".verdict > button");
  const map = page.getByRole("application", { name: /Map of the plan/ });
  const steps = page.getByRole("list", { name: "Maneuvers" }).getByRole("listitem");
  const names = () => page.locator(".steps .name").allInnerTexts();
  const spot = async (x, y) => {
    const box = await map.boundingBox();
    return [box.x + box.width * x, box.y + box.height * y];
  };
  const drag = async (from, to) => {
    await page.mouse.move(...from);
    await page.mouse.down();
    await page.mouse.move((from[0] + to[0]) / 2, (from[1] + to[1]) / 2, { steps: 3 });
    await page.mouse.move(...to, { steps: 3 });
    await page.mouse.up();
  };

  // A plan over land: the bar says so, and leads to the worst leg.
  await draw("over land", goto("Start", 63.4465, 10.35), path("Bad", [63.447, 10.352], [63.455, 10.372]), goto("End", 63.4465, 10.351));
  await verdict.getByText(/^Not safe: .* crosses land/).waitFor();
  await page.getByTitle("Zoom in").click({ clickCount: 3 });
  await verdict.click();
  check((await page.locator('.step[aria-pressed="true"] .name').innerText()) === "2 Bad", "the worst leg's maneuver is chosen");
  await look(page, "bar-unsafe");

  // The bar stays while the form scrolls, whole and large enough, at all widths.
  for (const [width, height] of SIZES) {
    await page.setViewportSize({ width, height });
    for (const down of [0, 100_000]) {
      await page.evaluate((down) => [document.querySelector(".plan-side"), document.scrollingElement].forEach((one) => (one.scrollTop = down)), down);
      const trouble = await bar.evaluate((root) =>
        [...root.querySelectorAll("button, .name, .for, .aboard-now")].filter((one) => one.checkVisibility()).flatMap((one) => {
          const { top, bottom, left, right, width, height } = one.getBoundingClientRect();
          const out = top < 0 || left < 0 || bottom > innerHeight + 0.5 || right > innerWidth + 0.5;
          const small = one.matches("button") && (width < 43.5 || height < 43.5);
          const under = document.elementFromPoint((left + right) / 2, (top + bottom) / 2);
          const covered = !one.contains(under) && !under?.contains(one);
          return out || small || covered ? [`${one.outerHTML.slice(0, 80)} out ${out}, small ${small}, covered ${covered}`] : [];
        }));
      check(!trouble.length, `at ${width} px, scrolled ${down}: ${trouble.join("\n")}`);
      check(await page.locator("#stop").getByRole("button", { name: "STOP otter-0" }).isVisible(), "and STOP of its vessel with it");
    }
  }
  await page.setViewportSize({ width: 1440, height: 900 });

  // Deep water is safe, with its least depth as soon as that is known.
  await draw("whole", goto("Start", 63.4462, 10.346), path("Way", [63.4475, 10.349], [63.448, 10.3515], [63.4485, 10.35]));
  await verdict.getByText(/^Safe from Start on: least depth \d+\.\d\sm$/).waitFor();
  check(await bar.getByRole("button", { name: "Upload" }).isDisabled(), "a draft goes nowhere");

  // A whole path is moved by its grip, in one step of undo.
  await steps.nth(1).getByRole("button").first().click();
  await page.getByRole("button", { name: "Show all" }).click();
  const before = await stored();
  const points = (plan, step = 1) => plan.maneuvers[step].task.points;
  const found = await findOver(page, map, "move");
  await drag(found, [found[0] + 60, found[1] + 40]);
  await kept();
  const moved = await stored();
  const shift = points(moved).map((one, at) => [one.lat_deg - points(before)[at].lat_deg, one.lon_deg - points(before)[at].lon_deg]);
  check(shift.every(([lat, lon]) => lat < -1e-5 && lon > 1e-5 && Math.abs(lat - shift[0][0]) < 1e-6 && Math.abs(lon - shift[0][1]) < 2e-6), `all points alike: ${JSON.stringify(shift)}`);
  check(JSON.stringify(moved.maneuvers[0]) === JSON.stringify(before.maneuvers[0]), "and only that maneuver");
  await page.keyboard.press("Control+z");
  await kept();
  check(JSON.stringify(await stored()) === JSON.stringify(before), "undone at once");

  // Duplicated and reversed from its menu, by pointer and by keyboard.
  await page.getByRole("button", { name: "More for Way" }).click();
  await page.getByRole("menuitem", { name: "Duplicate" }).waitFor();
  await look(page, "maneuver-menu");
  if (!(await page.getByRole("menu").isVisible())) await page.getByRole("button", { name: "More for Way" }).click();
  await page.getByRole("menuitem", { name: "Duplicate" }).click();
  check((await names()).join() === "1 Start,2 Way,3 Way 1", `${await names()}`);
  check((await page.evaluate(() => document.activeElement.textContent)).includes("Way 1"), "the keyboard is on the copy");
  await page.keyboard.press("r");
  await kept();
  let plan = await stored();
  check(points(plan, 2)[0].lat_deg > points(plan, 2)[2].lat_deg, "the copy goes the other way");
  await page.keyboard.press("d");
  check((await names()).at(-1) === "4 Way 2", `${await names()}`);
  for (let times = 0; times < 3; times++) await page.keyboard.press("Control+z");
  check((await names()).join() === "1 Start,2 Way", "all of it undone");
  await page.getByRole("button", { name: "More for Start" }).focus();
  await page.keyboard.press("Enter");
  await page.keyboard.press("ArrowDown");
  check((await page.evaluate(() => document.activeElement.getAttribute("aria-disabled"))) === "true", "one place has no way back");
  await page.keyboard.press("Escape");
  check((await page.evaluate(() => document.activeElement.getAttribute("aria-label"))) === "More for Start", "back at the button");
  await page.keyboard.press("Enter");
  await page.getByRole("menuitem", { name: "Move it with arrow keys" }).click();
  check(await map.evaluate((node) => node === document.activeElement), "the keyboard is on the map");

  // The whole plan the other way round, and a whole maneuver by arrow keys.
  await page.getByRole("button", { name: "Reverse the whole plan" }).click();
  check((await names()).join() === "1 Way,2 Start", `${await names()}`);
  await page.keyboard.press("Control+z");
  await steps.nth(1).getByRole("button").first().click();
  await map.focus();
  await page.keyboard.press("Control+Shift+ArrowUp");
  await kept();
  plan = await stored();
  const north = points(plan).map((one, at) => (one.lat_deg - points(before)[at].lat_deg) * 111_480);
  check(north.every((metres) => Math.abs(metres - 10) < 0.1), `ten metres to the north: ${north}`);
  await page.keyboard.press("Shift+R");
  check((await names()).join() === "1 Way,2 Start", "by key on the map too");
  for (let times = 0; times < 2; times++) await page.keyboard.press("Control+z");

  // Rows in a rectangle: dragged, turned, resized.
  await page.getByRole("button", { name: "Rows in rectangle" }).click();
  await page.getByText(/Drag from one corner to the opposite one/).waitFor();
  await look(page, "drawing");
  await page.getByLabel("Spacing, m").fill("12");
  await page.keyboard.press("Tab");
  await drag(await spot(0.3, 0.75), await spot(0.42, 0.35));
  await kept();
  const rows = async () => (await stored()).maneuvers.find(({ task }) => task.kind === "rows").task;
  let task = await rows();
  check(task.step_m === 12 && task.bearing_deg === 0 && task.curve_right && task.length_m > task.width_m, JSON.stringify(task));
  check((await page.getByRole("button", { name: "Rows in rectangle" }).getAttribute("aria-pressed")) === "false", "the tool is put away");
  const turn = await findOver(page, map, "turn");
  await drag(turn, [turn[0] + 120, turn[1] + 30]);
  await kept();
  const turned = await rows();
  check(turned.bearing_deg > 5 && turned.bearing_deg < 120 && turned.length_m === task.length_m, `turned: ${JSON.stringify(turned)}`);
  const size = await findOver(page, map, "size");
  await drag(size, [size[0] + 30, size[1] + 30]);
  await kept();
  check((await rows()).width_m !== task.width_m, "resized");
  for (let times = 0; times < 2; times++) await page.keyboard.press("Control+z");
  await kept();
  check(JSON.stringify(await rows()) === JSON.stringify(task), "both undone");
  await page.getByRole("button", { name: /More for Rows 1/ }).click();
  await page.getByRole("menuitem", { name: /Reverse its way/ }).click();
  await kept();
  const back = await rows();
  check(back.at.lon_deg > task.at.lon_deg && back.length_m === task.length_m, `from the other corner: ${JSON.stringify(back)}`);
  await look(page, "rows-in-rectangle");

  // Lines in a polygon: corners by pointer, taken back and again, finished by its first corner.
  await page.getByRole("button", { name: "Lines in polygon" }).click();
  const corners = [[0.6, 0.3], [0.75, 0.35], [0.72, 0.5], [0.8, 0.7], [0.6, 0.75]];
  for (const corner of corners) await page.mouse.click(...(await spot(...corner)));
  await page.keyboard.press("Control+z");
  await page.keyboard.press("Control+y");
  await page.getByText(/^\d+ lines\. Click the first corner or Finish\.$/).waitFor();
  await look(page, "lines-in-polygon");
  const count = Number.parseInt(await page.locator(".drawing .told").innerText());
  await page.mouse.click(...(await spot(...corners[0])));
  await page.getByRole("button", { name: /Lines 1/ }).first().waitFor();
  await kept();
  const lines = (await stored()).maneuvers.find(({ id }) => id === "Lines 1");
  check(lines.task.kind === "follow_path" && lines.task.points.length === 2 * count, `${lines.task.points.length} points of ${count} lines`);

  // And by keyboard: Enter takes the middle of the map.
  await page.getByRole("button", { name: "Rows in rectangle" }).focus();
  await page.keyboard.press("Enter");
  await page.keyboard.press("Enter");
  await page.getByText("Click the opposite corner.").waitFor();
  for (const key of ["ArrowUp", "ArrowRight", "ArrowUp"]) {
    await page.keyboard.press(key);
    await page.waitForTimeout(400);
  }
  await page.keyboard.press("Enter");
  await page.getByRole("button", { name: /Rows 2/ }).first().waitFor();
  await page.keyboard.press("Control+z");
  check(!(await names()).some((name) => name.includes("Rows 2")), "undone");
});

/** Where on the map the pointer is over a grip of this kind: looked for by events within the page, for each move of the real
 * pointer takes a frame. */
async function findOver(page, map, kind) {
  const found = await map.evaluate((root, kind) => {
    const { left, top, right, bottom } = root.getBoundingClientRect();
    for (let y = top + 20; y < bottom - 20; y += 22) {
      for (let x = left + 20; x < right - 60; x += 22) {
        const under = document.elementFromPoint(x, y);
        under?.dispatchEvent(new PointerEvent("pointermove", { clientX: x, clientY: y, bubbles: true, pointerType: "mouse" }));
        if (root.dataset.over === kind) return [x, y];
      }
    }
    return null;
  }, kind);
  check(found, `a grip to ${kind}`);
  await page.mouse.move(...found);
  check((await map.getAttribute("data-over")) === kind, `the pointer is over the grip to ${kind}`);
  return found;
}
