// A person at the keyboard: keys only. No pointer is used and no focus set by the script. Wherever the focus stops it must
// be seen.

import { check } from "./browser.mjs";

/** No page has more stops than this. */
const STOPS = 250;

/** What a person does on `page` with ten fingers. */
export function atKeyboard(page) {
  const press = (...keys) => keys.reduce((before, key) => before.then(() => page.keyboard.press(key)), Promise.resolve());
  /** What has the focus: its role or element, its name, and whether one sees that. */
  const focused = () =>
    page.evaluate(() => {
      const one = document.activeElement;
      if (!one || one === document.body) return undefined;
      const style = getComputedStyle(one);
      const { width, height, top, bottom } = one.getBoundingClientRect();
      // Of a label around its field, what is not the field.
      const own = (label) => (label.contains(one) ? [...label.childNodes].filter((node) => !node.contains(one)).map((node) => node.textContent).join("") : label.textContent);
      const label = one.getAttribute("aria-label") ?? (one.labels?.[0] ? own(one.labels[0]) : one.textContent);
      return {
        name: label.trim(),
        box: [width, height, top, bottom].map(Math.round),
        seen: width > 0 && height > 0 && bottom > 0 && top < innerHeight && ((style.outlineStyle !== "none" && style.outlineWidth !== "0px") || style.boxShadow !== "none"),
        html: one.outerHTML.slice(0, 120),
      };
    });
  /** The same as a person sees it: what the page is just moving is looked at once it is painted. */
  const drawn = async () => {
    const at = await focused();
    if (!at || at.seen) return at;
    await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
    return focused();
  };
  /** Goes on with Tab to what has this name. */
  const to = async (name, key = "Tab") => {
    const passed = [];
    for (let stop = 0; stop < STOPS; stop++) {
      const at = await focused();
      if (at && (typeof name === "string" ? at.name === name : name.test(at.name))) return;
      await press(key);
      const now = await drawn();
      if (!now) continue;
      check(now.seen, `the focus is not seen: ${now.html} at ${now.box}`);
      passed.push(now.name);
    }
    throw new Error(`Tab does not come to ${name}, but to ${[...new Set(passed)].join(" | ")}`);
  };
  const type = async (name, text) => {
    await to(name);
    await press("Control+a");
    await page.keyboard.type(text);
    await press("Enter");
  };
  const choose = async (name, option) => {
    await to(name);
    await page.keyboard.type(option);
  };

  /** Enter, which leads to another page. */
  const follow = async (address) => {
    await press("Enter");
    await page.waitForURL(address);
    await page.getByText("Live", { exact: true }).waitFor();
  };

  /** From the login, with a password that need not be changed. */
  const logIn = async (url, name, password) => {
    await page.goto(`${url}/login`);
    await to(/^Name/);
    await page.keyboard.type(name);
    await to(/^Password/);
    await page.keyboard.type(password);
    await follow(/:\d+\/$/);
  };
  /** Goes on to what has this name, and presses Enter there. */
  const act = async (name, key = "Tab") => {
    await to(name, key);
    await press("Enter");
  };
  return { press, focused, to, type, choose, follow, logIn, act, write: (text) => page.keyboard.type(text) };
}
