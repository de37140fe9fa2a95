// Who goes by keyboard sees where they are: node insight.mjs URL ONE-TIME-PASSWORD. What comes above a field that has the focus
// pushes it out of the window; it is brought back, and nobody's own scrolling is undone.

import { check, inBrowser, logIn, until } from "./browser.mjs";

const [url, oneTime] = process.argv.slice(2);
/** Higher than what lies below any field of a plan in the window, px. */
const HIGH_PX = 500;
/** Higher than the window, px. */
const BEYOND_PX = 2_000;
/** So far a table is scrolled sideways that its first link is out of sight, px. */
const ASIDE_PX = 120;

await inBrowser(async (open) => {
  const page = await open({ viewport: { width: 1440, height: 900 } });
  await logIn(page, url, "admin", oneTime, "nine grey otters");
  const csrf = await page.evaluate(() => document.querySelector('meta[name="csrf"]').content);
  const speed = { value: 1, unit: "mps" };
  const plan = { name: "north shore", description: "", vessel: null, repeat: false, maneuvers: [{ id: "Goto 1", speed, task: { kind: "goto", at: { lat_deg: 63.44, lon_deg: 10.4 } } }] };
  const made = await (await page.request.post(`${url}/api/v1/plans`, { headers: { "x-csrf-token": csrf }, data: plan })).json();

  /** Where the focus is, and whether all of it is in the window and in what scrolls around it. */
  const focus = () =>
    page.evaluate(() => {
      const one = document.activeElement;
      const { top, bottom } = one.getBoundingClientRect();
      const around = [...document.querySelectorAll(".plan-side, html")].filter((box) => box.contains(one)).map((box) => (box === document.documentElement ? { top: 0, bottom: innerHeight } : box.getBoundingClientRect()));
      const side = document.querySelector(".plan-side");
      return { name: one.getAttribute("aria-label") ?? one.labels?.[0]?.textContent ?? one.textContent, seen: around.every((box) => top >= box.top - 1 && bottom <= box.bottom + 1), at: [Math.round(top), Math.round(bottom)], scrolled: [scrollY, side.scrollTop].map(Math.round) };
    });
  /** Something comes at the top of the plan's side, as a verdict or an offer does. */
  const grow = (high = HIGH_PX) =>
    page.evaluate((px) => {
      const grown = document.createElement("div");
      grown.className = "grown";
      grown.style.height = `${px}px`;
      document.querySelector(".plan-side").prepend(grown);
    }, high);
  const painted = () => page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => requestAnimationFrame(done)))));
  /** A plan's page at its top with the focus on its last field that is in the window, by Tab alone. */
  const tabbed = async () => {
    await page.goto(`${url}/plans/${made.id}`);
    await page.getByRole("button", { name: /^1 Goto 1/ }).waitFor();
    await page.locator('body[data-link="up"]').waitFor();
    let before;
    for (let stops = 0; stops < 200; stops++) {
      await page.keyboard.press("Tab");
      const inside = await page.evaluate(() => Boolean(document.activeElement?.closest(".plan-side")));
      const now = await focus();
      if (inside && now.seen && now.scrolled.every((px) => px === 0)) before = now;
      if (inside && now.at[1] > 400) break;
    }
    check(before, "a field of the plan's side gets the focus at the top of the page");
    const at = await focus();
    check(at.seen && at.scrolled.every((px) => px === 0), `${at.name} is in the window before anything grows: ${JSON.stringify(at)}`);
    return at;
  };

  const { name } = await tabbed();
  await grow();
  await until(async () => (await focus()).seen, `${name} is brought back into the window`, 5_000).catch(async (error) => {
    throw new Error(`${error.message}: ${JSON.stringify(await focus())}`);
  });
  check((await focus()).name === name, "the focus stays where it was");

  // Who scrolls away by the wheel is not fetched back, whatever grows.
  const box = await page.locator(".plan-side").boundingBox();
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  await page.mouse.wheel(0, -4_000);
  await until(async () => (await focus()).scrolled[1] === 0, "scrolled up again");
  await painted();
  check(!(await focus()).seen, "the wheel takes the focus out of the window, and it stays there");
  await grow();
  await painted();
  const after = await focus();
  check(!after.seen && after.scrolled[1] === 0, `nobody who scrolled is yanked: ${JSON.stringify(after)}`);

  // Sideways scrolling of a wide table by its keys stays too, though the focus goes out of sight with it.
  await page.goto(`${url}/plans/${made.id}`);
  await page.getByRole("button", { name: /^1 Goto 1/ }).waitFor();
  await page.locator('body[data-link="up"]').waitFor();
  await page.keyboard.press("Tab");
  await page.evaluate(() => {
    const [wide, long, link] = ["div", "p", "a"].map((name) => document.createElement(name));
    wide.className = "wide grown";
    wide.style.overflowX = "auto";
    long.style.width = "4000px";
    [link.href, link.textContent] = ["#first", "first"];
    long.append(link);
    wide.append(long);
    document.querySelector(".plan-side").prepend(wide);
    link.focus();
  });
  const aside = () => page.evaluate(() => document.querySelector(".wide.grown").scrollLeft);
  await until(async () => {
    await page.keyboard.press("ArrowRight");
    return (await aside()) > ASIDE_PX;
  }, "the table is scrolled sideways", 10_000);
  for (let looks = 0; looks < 5; looks++) await painted();
  check((await aside()) > ASIDE_PX, `sideways scrolling is not undone: ${await aside()}`);
  check((await focus()).name === "first", "the link keeps the focus");

  // Nor who came by pointer.
  await page.goto(`${url}/plans/${made.id}`);
  await page.getByLabel("Name of the plan").click();
  await page.locator('body[data-link="up"]').waitFor();
  check((await focus()).name === "Name of the plan", "the field that was clicked has the focus");
  await grow(BEYOND_PX);
  for (let looks = 0; looks < 5; looks++) await painted();
  const pointed = await focus();
  check(pointed.at[0] > BEYOND_PX && !pointed.seen, `the field went out of the window: ${JSON.stringify(pointed)}`);
  check(pointed.scrolled.every((px) => px === 0), `a click is not a key: ${JSON.stringify(pointed)}`);
});
