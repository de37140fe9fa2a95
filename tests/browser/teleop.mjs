// Steering a simulated Otter by hand, and how that fails: node teleop.mjs URL PASSWORD. Prints when each fault came and
// the fresh samples of the person's hands before it (ms of UTC), and what it wants done to processes and cables; whether
// the vessel stopped in time its own log tells.
//
// A computer that is busy with other things may stop the motors before a fault comes, which is no harm and no proof:
// then the fault is repeated, until the motors ran when it came.

import { check, inBrowser, logIn, look } from "./browser.mjs";
import { begin, button, enter, helmNote, hold, keysOf, motors, OTTER, password, PATIENCE_MS, phase, runs, takeControl, tell, TRIES, url } from "./helm.mjs";

/** Why keys and a finger stop that do not change. */
const UNMOVED = "no key was pressed or let go, and no finger moved, for 10 s";
const VIGIL_MS = 10_000;
/** A keyboard whose key is held is repeated about so often. */
const REPEAT_MS = 30;

/** Runs in the page: notes fresh samples by a clock that nobody moves, and holds a gamepad and a clock to move. */
function instrument() {
  const [now, date] = [performance.now.bind(performance), Date.now.bind(Date)];
  window.jumpMs = 0;
  performance.now = () => now() + window.jumpMs;
  Date.now = () => date() + window.jumpMs;
  const send = WebSocket.prototype.send;
  let change;
  window.fresh = [];
  WebSocket.prototype.send = function (text) {
    const sample = JSON.parse(text).sample;
    // A sample whose device shows no change is none of the hands'.
    if (sample?.held && sample.change !== change) window.fresh = [...window.fresh.slice(-200), date()];
    if (sample) change = sample.change;
    send.call(this, text);
  };
  // When a key or a finger really changed last: what the computer repeats by itself is no change.
  for (const kind of ["keydown", "keyup", "pointerdown", "pointermove", "pointerup"]) {
    addEventListener(kind, (event) => event.repeat || (window.changed = date()), { capture: true });
  }
  window.pad = null;
  window.frozen = false;
  window.seen = true;
  Object.defineProperty(document, "visibilityState", { get: () => (window.seen ? "visible" : "hidden") });
  navigator.getGamepads = () => {
    if (!window.pad) return [null];
    // A hand trembles; one that hangs says the same for ever, though some browsers stamp it with the present.
    if (!window.frozen) window.pad.tremor = Math.random() * 0.001;
    const { held, ahead, tremor = 0 } = window.pad;
    const timestamp = now();
    const buttons = Array.from({ length: 17 }, (_, index) => ({ pressed: index === 7 && held, value: index === 7 && held ? 1 : 0 }));
    return [{ index: 0, id: "test pad", connected: true, mapping: "standard", timestamp, axes: [tremor, -ahead, 0, 0], buttons }];
  };
}

/** The process of the browser that is to be killed, and what ends the wait for that. */
let victim;
let letGo;

/** Whether the motors ran at a time. They have stopped since. */
const ran = async (asker, at) => {
  for (const begun = Date.now(), end = begun + 60_000; ; ) {
    const rows = await motors(asker, at - 3_000);
    const [before, later] = [rows.filter((row) => row.at <= at), rows.filter((row) => row.at > at && row.value === 0)];
    if ([0, 1].every((motor) => later.some((row) => row.motor === motor))) return runs(before);
    // They stood still when it came, and a vessel that steers no more reports its motors no more.
    if (before.length && !runs(before) && Date.now() > begun + 10_000) return false;
    check(Date.now() < end, "the motors do not stop, or nothing tells");
  }
};
/** A fault, repeated until the motors ran when it came and it is what stopped them. `inject` gives the time, and the fresh
 *  samples until then if they do not go on; where others inject it, they note the time, and `at` is somewhat later for
 *  certain. `over` waits for the end of it and gives what the person reads and the fresh samples, if those went on. */
const fault = async (name, asker, why, { before, inject, over }) => {
  for (let tries = 0; ; tries++) {
    check(tries < TRIES, `${name}: the motors did not run when it came`);
    await before();
    const { at, samples } = await inject();
    const { said, fresh } = await over();
    const ok = (await ran(asker, at)) && said.includes(why);
    tell(`fault ${name} ${ok ? "ran" : "void"} ${at} ${(fresh ?? samples).join(",")}`);
    if (ok) return;
    tell(`${name} is repeated: it says ${JSON.stringify(said)}`);
  }
};

await inBrowser(async (open) => {
  const other = await open();
  await logIn(other, url, "bert", password);
  const page = await open();
  for (const one of [other, page]) one.setDefaultTimeout(PATIENCE_MS);
  await page.addInitScript(instrument);
  await logIn(page, url, "anna", password);

  const samples = () => page.evaluate(() => window.fresh);
  /** Does something in the page, with the time and the fresh samples until then. */
  const inPage = (work) => page.evaluate(`(() => { const at = Date.now() - window.jumpMs; const samples = window.fresh; (${work})(); return { at, samples }; })()`);
  const keys = keysOf(page);
  const keyUp = keys.release;
  const padSays = (held, ahead) => page.evaluate(([held, ahead]) => (window.pad = { held, ahead, timestamp: 0 }), [held, ahead]);
  const pad = {
    async release() {
      await page.evaluate(() => (window.frozen = false));
      await padSays(false, 0);
    },
    hold: () => padSays(true, 0),
    steer: () => padSays(true, 1),
  };
  const byKeys = () => hold(page, other, keys);
  const byPad = () => hold(page, other, pad);
  /** What the person reads when the sticks do not steer any more. */
  const stopped = async () => {
    await page.locator('.helm[data-phase="steering"]').waitFor({ state: "hidden" });
    return page.getByRole("region", { name: "Steer by hand" }).innerText();
  };
  const toReady = async () => {
    await keyUp();
    await phase(page, "ready");
  };

  await takeControl(page);
  check(await button(page, "Steer by hand …").isEnabled(), "with control one may steer");
  await begin(page);
  await look(page, "teleop-ready");
  await button(page, "End steering by hand").click();
  await begin(page);
  await byKeys();
  await look(page, "teleop-steering");
  await keyUp();

  await fault("released", other, "the dead-man was released", {
    before: byKeys,
    async inject() {
      const at = Date.now();
      await page.keyboard.up("Space");
      return { at, samples: await samples() };
    },
    over: async () => ({ said: await stopped() }),
  });
  await fault("keyboard-frozen", other, UNMOVED, {
    before: byKeys,
    async inject() {
      // A key that really changes is enough to go on.
      await asked(page);
      await page.keyboard.press("Shift");
      await page.locator(".helm-vigil:empty").waitFor({ state: "attached" });
      // Then the keyboard says nothing any more, and the computer repeats the key by itself.
      const steers = page.locator('.helm[data-phase="steering"]');
      while (await steers.isVisible()) {
        await page.keyboard.down("ArrowUp");
        await page.waitForTimeout(REPEAT_MS);
      }
      return quiet(page);
    },
    over: async () => ({ said: await stopped() }),
  });
  await fault("tab-hidden", other, "the window was hidden", {
    before: byKeys,
    inject: () => inPage(() => {
      window.seen = false;
      document.dispatchEvent(new Event("visibilitychange"));
    }),
    async over() {
      const said = await stopped();
      await page.evaluate(() => (window.seen = true));
      return { said };
    },
  });
  await fault("clock-jump", other, "the clock of the computer that steers jumped", {
    before: byKeys,
    inject: () => inPage(() => (window.jumpMs += 3_600_000)),
    over: async () => ({ said: await stopped() }),
  });
  await phase(page, "locked");
  await look(page, "teleop-stopped");

  // The gamepad's own time of change stands still while its values stay as they were. When it lives again with the
  // dead-man still held, that is not enough.
  await toReady();
  await fault("gamepad-frozen", other, "the input device shows no sign of life", {
    before: byPad,
    inject: () => inPage(() => (window.frozen = true)),
    async over() {
      const [said, fresh] = [await stopped(), await samples()];
      await page.evaluate(() => (window.frozen = false));
      return { said, fresh };
    },
  });
  await fault("gamepad-unplugged", other, "the gamepad is gone", {
    before: byPad,
    inject: () => inPage(() => (window.pad = null)),
    over: async () => ({ said: await stopped() }),
  });

  // A stick that does not rest in neutral is named; whoever leaves the gamepad out steers without it.
  await padSays(false, 0.2);
  const remedy = (text) => page.locator(".helm-remedy").getByText(text).waitFor();
  await remedy("The gamepad's stick for ahead and astern is not in neutral");
  await page.getByText("axis 1 (ahead and astern) -0.20; up to 0.08 counts as neutral").waitFor();
  await look(page, "teleop-worn-stick");
  await button(page, "Leave the gamepad out").click();
  await remedy(/Hold the dead-man first/);
  await page.evaluate(() => (window.pad = null));
  await button(page, "Leave the gamepad out").waitFor({ state: "hidden" });

  // STOP by its chord, with both hands at the helm.
  await fault("stop-pressed", other, "it is not steered by hand any more", {
    before: byKeys,
    async inject() {
      const at = Date.now();
      await page.keyboard.press("Control+.");
      return { at, samples: await samples() };
    },
    async over() {
      await helmNote(page).waitFor();
      const said = await stopped();
      await keyUp();
      await begin(page);
      return { said };
    },
  });

  // Somebody else takes over.
  await enter(other);
  await fault("lease-taken", other, "control of the vessel was lost", {
    async before() {
      if (await other.getByText("You have control of this vessel.").isVisible()) {
        await button(other, "Release control").click();
        await takeControl(page);
        await begin(page);
      }
      await other.getByLabel("Reason, for the one who has control").fill("my turn");
      await byKeys();
      await button(other, "Take over …").click();
    },
    async inject() {
      await button(other, "Take over now").click();
      await other.getByText("You have control of this vessel.").waitFor();
      const lease = await (await other.request.get(`${url}/api/v1/vessels/${OTTER}/lease`)).json();
      return { at: lease.holder.since_us / 1e3, samples: await samples() };
    },
    async over() {
      await helmNote(page).waitFor();
      // The vessel does not wait for hands that nobody has there: it says so to whoever took over.
      await other.locator('.tile[data-tile="mode"]').getByText("Ready").waitFor();
      // Who lost control does not steer.
      await page.getByRole("button", { name: "Steer by hand …", exact: true, disabled: true }).waitFor();
      await keyUp();
      return { said: await stopped() };
    },
  });
  await look(page, "teleop-taken");
  await button(other, "Release control").click();
  await other.getByText("Nobody has control of this vessel.").waitFor();

  // The way to the vessel, and the way to the server, carry nothing any more. Then the server is killed.
  const byOthers = (name, words, why, after) =>
    fault(name, page, why, {
      async before() {
        await takeControl(page);
        await begin(page);
        await hold(page, page, keys);
      },
      async inject() {
        tell(words);
        return { at: Date.now() + 100, samples: [] };
      },
      async over() {
        const [said, fresh] = [await stopped(), await samples()];
        await after();
        await keyUp();
        return { said, fresh };
      },
    });
  await byOthers("network-dropped-vessel", "silence vessel", "the vessel is not heard", () => tell("passes vessel"));
  await byOthers("network-dropped-browser", "silence browser", "The server is not heard", () => tell("passes browser"));
  await byOthers("server-killed", "kill server", "", () => helmNote(page).getByText("the server is not reached").waitFor());
  await takeControl(page);
  await button(page, "Release control").click();
  await page.getByText("Nobody has control of this vessel.").waitFor();

  // A finger that rests where it is: a screen that hangs tells the same.
  const { tablet, finger } = await tabletOf(open);
  await fault("finger-frozen", page, UNMOVED, {
    before: () => hold(tablet, page, finger),
    async inject() {
      await asked(tablet);
      await tablet.locator('.helm[data-phase="steering"]').waitFor({ state: "hidden" });
      return quiet(tablet);
    },
    over: async () => ({ said: await tablet.getByRole("region", { name: "Steer by hand" }).innerText() }),
  });
  await finger.release();
  await button(tablet, "End steering by hand").click();
  await button(tablet, "Release control").click();
  await page.getByText("Nobody has control of this vessel.").waitFor();
  await tablet.close();

  // The browser is killed, on a tablet that is steered by touch.
  await fault("browser-killed", page, "", {
    async before() {
      await new Promise((done, fail) => inBrowser((open) => touch(open, page, done)).catch(fail));
    },
    inject: async () => {
      // At most one sample's time after the last sample.
      const at = Date.now();
      process.kill(victim, "SIGKILL");
      return { at, samples: [at] };
    },
    async over() {
      letGo();
      return { said: "" };
    },
  });

  const audit = await (await page.request.get(`${url}/api/v1/audit?count=1000`)).json();
  // How far each order got stands there too.
  const acts = audit.filter((one) => ["teleop.begin", "teleop.end"].includes(one.action) && ["asked", "done"].includes(one.outcome)).reverse();
  const ends = acts.filter((one) => one.action === "teleop.end").map((one) => one.subject);
  for (const why of ["the person ended it", "it is not steered by hand any more", "control of the vessel was lost", "the server was killed", "the window was closed"]) {
    check(ends.some((subject) => subject.includes(why)), `${why} in ${ends.join("\n")}`);
  }
  acts.forEach((one, index) => check(one.action === (index % 2 ? "teleop.end" : "teleop.begin"), `each beginning has its end: ${JSON.stringify(acts, null, 1)}`));
});

/** Waits until the page asks for a sign of life. */
function asked(page) {
  return page.locator(".helm-vigil").getByText("Still there?").waitFor();
}

/** When hands that changed last some time ago count as gone: nothing is fresh from there on. */
async function quiet(page) {
  const at = (await page.evaluate(() => window.changed)) + VIGIL_MS;
  return { at, samples: [at] };
}

/** A tablet and the finger on it, about to steer. */
async function tabletOf(open) {
  const tablet = await open({ hasTouch: true, viewport: { width: 820, height: 1180 } });
  tablet.setDefaultTimeout(PATIENCE_MS);
  await tablet.addInitScript(instrument);
  await logIn(tablet, url, "anna", password);
  await takeControl(tablet);
  await begin(tablet);
  await look(tablet, "teleop-tablet");
  await tablet.setViewportSize({ width: 820, height: 1180 });
  const input = await tablet.context().newCDPSession(tablet);
  const circle = tablet.locator(".helm-pad");
  await tablet.locator(".helm").evaluate((helm) => helm.scrollIntoView({ block: "start" }));
  const box = await circle.boundingBox();
  check(box.width >= 200, "the pad is large enough for a thumb");
  // Map and helm are in sight together, beneath STOP and the alarms.
  const seen = await tablet.evaluate(() => {
    const box = (name) => document.querySelector(name).getBoundingClientRect();
    return { top: box("#top").bottom, map: [box(".map").top, box(".map").bottom], helm: [box(".helm").top, box(".helm-pad").bottom], page: innerHeight };
  });
  check(seen.map[0] >= seen.top - 1 && seen.map[1] - seen.map[0] > 300, `the map is in sight: ${JSON.stringify(seen)}`);
  check(seen.helm[0] >= seen.map[1] - 1 && seen.helm[1] <= seen.page, `and the helm: ${JSON.stringify(seen)}`);
  const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
  const at = (type, touchPoints) => input.send("Input.dispatchTouchEvent", { type, touchPoints });
  let down = false;
  const finger = {
    async release() {
      if (down) await at("touchEnd", []);
      down = false;
    },
    async hold() {
      await at("touchStart", [{ x, y }]);
      down = true;
    },
    steer: () => at("touchMove", [{ x, y: y - 100 }]),
  };
  return { tablet, finger };
}

/** Steers by touch until the browser is killed. */
async function touch(open, asker, done) {
  const { tablet, finger } = await tabletOf(open);
  await hold(tablet, asker, finger);
  const browser = await tablet.context().browser().newBrowserCDPSession();
  const { processInfo } = await browser.send("SystemInfo.getProcessInfo");
  victim = processInfo.find((one) => one.type === "browser").id;
  const killed = new Promise((over) => (letGo = over));
  done();
  await killed;
}
