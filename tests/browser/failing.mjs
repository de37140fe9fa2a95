// A page of which a part fails: node failing.mjs URL ONE-TIME-PASSWORD. Nothing old looks fresh, and STOP works on.

import { check, inBrowser, logIn } from "./browser.mjs";

const [url, oneTime] = process.argv.slice(2);
const BOAT = 0x0814;

/** From here on nobody can draw into the elements, as if the function that does it had a fault; returns how to mend it. */
const sabotage = (page, selector) =>
  page.locator(selector).first().evaluate((node) => {
    Object.defineProperty(node, "textContent", {
      configurable: true,
      get() {
        throw new Error("sabotage");
      },
    });
    window.mend = () => delete node.textContent;
  });

/** The same for what components draw: no text that they change, and none that they rebuild. */
const sabotageComponents = (page) =>
  page.evaluate(() => {
    const [data, make] = [Object.getOwnPropertyDescriptor(CharacterData.prototype, "data"), document.createTextNode];
    const fail = () => {
      throw new Error("sabotage");
    };
    Object.defineProperty(CharacterData.prototype, "data", { configurable: true, get: data.get, set: fail });
    document.createTextNode = fail;
    window.mend = () => {
      Object.defineProperty(CharacterData.prototype, "data", data);
      document.createTextNode = make;
    };
  });

await inBrowser(async (open) => {
  const first = await open();
  await logIn(first, url, "admin", oneTime, "nine grey otters");
  const context = first.context();
  // These pages have to complain.
  const another = async (path) => {
    const page = await context.newPage();
    page.told = [];
    page.on("console", (message) => message.type() === "error" && page.told.push(message.text()));
    await page.goto(`${url}${path}`);
    await page.locator('body[data-link="up"]').waitFor();
    await page.getByText("Live", { exact: true }).waitFor();
    return page;
  };
  const grey = async (page, box) => {
    await page.locator('body[data-link="down"]').waitFor();
    await page.getByText("This page failed: what you see may be old. STOP works. Reload the page.").waitFor();
    check((await page.locator(box).evaluate((node) => getComputedStyle(node).filter)) !== "none", `${box} is grey`);
  };

  for (const [path, box, part] of [[`/vessels/${BOAT}`, "#vessel", ".tile .age"], ["/", "#fleet", ".system .name"], ["/", "#fleet", ".alarm-bar .worst"]]) {
    const page = await another(path);
    await page.locator(part).first().waitFor();
    // Of each frame that comes the page could say that it is there.
    let links = 0;
    await page.exposeFunction("linkIs", () => (links += 1));
    await (part.startsWith(".system") ? sabotageComponents(page) : sabotage(page, part));
    if (part.startsWith(".alarm")) console.log("silence");
    await grey(page, box);
    await page.evaluate(() => new MutationObserver(() => window.linkIs()).observe(document.body, { attributeFilter: ["data-link"] }));
    const frames = await page.evaluate(() => performance.now());
    await page.waitForFunction((since) => performance.now() - since > 2_500, frames);
    check(links === 0, `${path}: it was said to be Live ${links} times meanwhile`);
    check(page.told.filter((text) => text.includes("sabotage")).length === 1, `${path}: told once: ${page.told}`);
    // Whatever else fails, a vessel is stopped.
    await page.locator("#stop .halt").first().click();
    await page.locator("#orders .order").first().getByText(/accepted, sent|sent .*, but the vessel is silent/).waitFor();
    await page.evaluate(() => window.mend());
    // What is told once and could not be drawn is missing until the page is loaded again.
    if (part.startsWith(".alarm")) {
      console.log("speak");
      await page.reload();
    }
    await page.locator('body[data-link="up"]').waitFor();
    await page.getByText("Live", { exact: true }).waitFor();
    await page.close();
  }

  // What fails outside of any drawing is not known to be mended before the page is loaded again.
  const page = await another(`/vessels/${BOAT}`);
  await page.evaluate(() => void setTimeout(() => {
    throw new Error("sabotage");
  }));
  await grey(page, "#vessel");
  await page.reload();
  await page.getByText("Live", { exact: true }).waitFor();
});
