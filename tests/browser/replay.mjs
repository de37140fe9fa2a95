// The past on a vessel's page: node replay.mjs URL PASSWORD [LOG]. LOG is a recording of a DUNE vehicle, brought in first.

import { readFile } from "node:fs/promises";
import { PATIENCE_MS, check, inBrowser, logIn, look, same, sameSamples, table } from "./browser.mjs";

const [url, password, log] = process.argv.slice(2);
const OTTER = 10449;
const DUNE = 0x2810;

await inBrowser(async (open) => {
  const page = await open();
  await logIn(page, url, "admin", password);
  await page.getByText("Live", { exact: true }).waitFor();
  const json = async (path) => (await page.request.get(url + path)).json();
  const query = () => new URL(page.url()).searchParams;
  const clock = () => page.locator(".replaybar .clock").textContent();
  const clockMs = async () => Date.parse((await clock()).replace(" ", "T"));
  const badge = (text) => page.locator(".replaybar .badge").getByText(text, { exact: true }).waitFor();
  const tile = (name) => page.locator(`[data-tile="${name}"] .reading`);
  const button = (name) => page.getByRole("button", { name, exact: true });

  /** Everything that is the same for any recorded stretch. */
  const replay = async (vessel, fromUs, toUs, name, pictures) => {
    const plots = "EstimatedState";
    const series = (await json(`/api/v1/series?system=${vessel}`)).filter((one) => one.message === plots);
    const entity = series.sort((one, other) => other.count - one.count)[0].entity;
    const t = Math.round(fromUs + (toUs - fromUs) / 2);
    const address = `/vessels/${vessel}?from=${fromUs}&to=${toUs}&t=${t}&speed=10&plots=${plots}.${entity}.u,${plots}.${entity}.psi&tab=Values`;
    await page.goto(url + address);
    // A deep link restores range, time, speed, fields and tab, standing still.
    await badge("REPLAY");
    check(Math.abs((await clockMs()) - t / 1e3) < 1_000, `${await clock()} is the time of the address`);
    check((await page.getByRole("combobox", { name: "Speed" }).inputValue()) === "10", "speed");
    await page.getByRole("tab", { name: "Values", selected: true }).waitFor();
    const at = await json(`/api/v1/vessels/${vessel}/at?time_us=${t}`);
    const state = at.values.find((one) => one.abbrev === plots && one.entity === entity);
    const of = (name) => state.fields.find((field) => field.name === name).value;
    check(state.time_us <= t, "the value was said before");

    // Instruments and tables tell of then, and say so.
    const speed = ((Math.hypot(of("vx"), of("vy")) * 3600) / 1852).toFixed(1);
    await page.waitForFunction((speed) => document.querySelector('[data-tile="speed_mps"] .reading').textContent === speed, speed);
    await page.getByRole("heading", { name: /^Values as of 20\d\d-.*Z$/ }).waitFor();
    await page.locator('[data-tile="link"]').getByText("recorded").waitFor();
    await page.getByRole("tabpanel", { name: "Values" }).getByLabel("Filter").fill("estimatedstate psi");
    const psi = ((of("psi") * 180) / Math.PI).toFixed(1).replace("-", "−");
    await page.getByRole("row", { name: new RegExp(`EstimatedState .* psi · heading ${psi} °`) }).waitFor();
    if (pictures) await look(page, `replay-${name}-values`);
    await page.getByRole("tab", { name: "Plots" }).click();
    check(query().get("tab") === null && query().get("t") === String(t), page.url());

    // A plot tells the place on the map and the instruments of its time; leaving it, the time that was set.
    const plot = page.getByRole("region", { name: "EstimatedState, m/s", exact: true });
    const over = plot.locator(".u-over");
    await over.scrollIntoViewIfNeeded();
    const box = await over.boundingBox();
    const set = await clock();
    const asked = page.waitForResponse((response) => response.url().includes("/at?"));
    await over.hover({ position: { x: box.width / 4, y: 60 } });
    await asked;
    const early = await clockMs();
    check(Math.abs(early - (fromUs + (toUs - fromUs) / 4) / 1e3) < (toUs - fromUs) / 2e4 + 1_100, `${await clock()} is a quarter of the way`);
    await page.mouse.move(5, 5);
    await page.waitForFunction((set) => document.querySelector(".replaybar .clock").textContent === set, set);
    // Another plot has the cursor too.
    const other = page.getByRole("region", { name: "EstimatedState, °", exact: true });
    const turn = await other.locator(".legend .num").innerText();
    check(/\d °/.test(turn), `${turn} at the time that is set`);

    // By a click it stays there, by keys it steps.
    await over.click({ position: { x: box.width / 4, y: 60 } });
    await page.mouse.move(5, 5);
    await page.waitForFunction((early) => Math.abs(Date.parse(document.querySelector(".replaybar .clock").textContent.replace(" ", "T")) - early) <= 1_000, early);
    await button("+1 s, step forward").click();
    const stepped = await clockMs();
    await page.getByRole("slider").focus();
    await page.keyboard.press("Shift+ArrowRight");
    check(Math.abs((await clockMs()) - stepped - 10_000) <= 1_000, "ten seconds further");
    await page.keyboard.press("ArrowLeft");
    check(Math.abs((await clockMs()) - stepped - 9_000) <= 1_000, "one back");

    // It plays: ten times as fast as it was, on the map and by the instruments.
    const here = await page.locator(".here").textContent();
    const [startMs, began] = [await clockMs(), Date.now()];
    const followed = page.waitForResponse((response) => Number(new URL(response.url()).searchParams.get("time_us")) >= (startMs + 4_000) * 1e3);
    await page.keyboard.press("Space");
    await button("Pause").waitFor();
    await page.waitForFunction((from) => Date.parse(document.querySelector(".replaybar .clock").textContent.replace(" ", "T")) >= from + 8_000, startMs);
    // The instruments follow.
    await followed;
    await page.keyboard.press("Space");
    await button("Play").waitFor();
    const [played, passed] = [(await clockMs()) - startMs, Date.now() - began];
    check(played >= 7_000 && played <= 10 * passed + 1_100, `${played} ms in ${passed} ms`);
    check((await page.locator(".here").textContent()) !== here, "the boat moved");
    const then = query().get("t");
    check(Math.abs(Number(then) / 1e3 - (await clockMs())) < 1_000, "the address tells the time");
    if (pictures) await look(page, `replay-${name}-plots`);

    // The same address shows the same.
    const shown = [await clock(), await page.locator(".here").textContent()];
    await page.reload();
    await badge("REPLAY");
    await page.waitForFunction(([time, place]) => document.querySelector(".replaybar .clock").textContent === time && document.querySelector(".here").textContent === place, shown);

    // Twenty times as fast and over a slow link, nothing is struck that the vessel reported all the time.
    const quarter = Math.round(fromUs + (toUs - fromUs) / 4);
    await page.goto(url + address.replace(`t=${t}&speed=10`, `t=${quarter}&speed=20`).replace("&tab=Values", ""));
    await badge("REPLAY");
    const fresh = () => ["speed_mps", "heading_rad"].every((name) => !document.querySelector(`[data-tile="${name}"]`).hasAttribute("data-old"));
    await page.waitForFunction(fresh);
    await page.route("**/at?*", async (route) => {
      await new Promise((late) => setTimeout(late, 400));
      await route.continue();
    });
    // Where a busy computer holds an answer back for as long as makes values old, which is no fault, that proves nothing: then the looks
    // are repeated.
    const answered = [];
    page.on("requestfinished", (request) => /\/at\?/.test(request.url()) && answered.push(Date.now()));
    for (let tries = 0; ; tries++) {
      await page.evaluate(`window.struck = 0; window.looks = setInterval(() => (window.struck += (${fresh})() ? 0 : 1), 20)`);
      answered.splice(0, Infinity, Date.now());
      await button("Play").click();
      await page.waitForFunction((until) => Date.parse(document.querySelector(".replaybar .clock").textContent.replace(" ", "T")) >= until, (quarter + (toUs - fromUs) / 2) / 1e3);
      const struck = await page.evaluate("clearInterval(window.looks); window.struck");
      answered.push(Date.now());
      // It may have come to the end by itself.
      await button("−1 s, step back").click();
      if (struck === 0) break;
      const longestMs = Math.max(...answered.slice(1).map((at, before) => at - answered[before]));
      // The answer that stands may be of as long before, so that two of these make values old.
      check(longestMs > 900, `speed or heading was struck in ${struck} of the looks at a fast replay, whose answers came within ${longestMs} ms`);
      if (tries === 5) {
        console.log(`each of six replays had answers that took as long as ${longestMs} ms: whether values are struck is left to web/test/replay.test.mjs`);
        break;
      }
      await page.goto(url + address.replace(`t=${t}&speed=10`, `t=${quarter}&speed=20`).replace("&tab=Values", ""));
      await badge("REPLAY");
      await page.waitForFunction(fresh);
    }
    await page.unrouteAll({ behavior: "wait" });

    // CSV is what is shown.
    const link = plot.getByRole("link", { name: /Download CSV of EstimatedState u/ });
    await link.waitFor();
    const download = page.waitForEvent("download");
    await link.click();
    const csv = await readFile(await (await download).path(), "utf8");
    const samples = await json(`/api/v1/vessels/${vessel}/samples?message=${plots}&entity=${entity}&fields=u&limit=10000&from_us=${Math.floor(fromUs / 1e3) * 1e3}&to_us=${Math.ceil(toUs / 1e3) * 1e3}`);
    sameSamples(csv, samples, "u");

    // Nothing is commanded from the past; STOP stays.
    await page.getByRole("tab", { name: "Control" }).click();
    await page.getByText("You look at the past").waitFor();
    check(await page.locator(".control-box").evaluate((node) => node.inert), "the controls are out of reach");
    if (pictures) await look(page, `replay-${name}-control`);
    await page.getByRole("tab", { name: "Plots" }).click();
  };

  // A real vehicle's log.
  if (log) {
    const token = await page.locator('meta[name="csrf"]').getAttribute("content");
    const sent = await page.request.post(`${url}/api/v1/import?name=Data.lsf.gz`, {
      headers: { "x-csrf-token": token, "content-type": "application/octet-stream", origin: url },
      data: await readFile(log),
    });
    check(sent.ok(), await sent.text());
    const { id } = await sent.json();
    for (;;) {
      const { state, problems } = await json(`/api/v1/import/${id}`);
      if (state === "done") break;
      check(state === "running", `${state}: ${problems.map(({ text }) => text)}`);
      await page.waitForTimeout(100);
    }
    const states = (await json(`/api/v1/series?system=${DUNE}`)).filter((one) => one.message === "EstimatedState");
    const last = Math.max(...states.map((one) => one.last_us));
    // Without a word about time, an old log is looked at as it was.
    await page.goto(`${url}/admin/import`);
    await page.getByRole("cell", { name: "done" }).waitFor();
    await look(page, "replay-import");
    await page.getByRole("link", { name: "0x2810" }).click();
    await badge("REPLAY");
    await replay(DUNE, last - 120_000_000, last, "dune", true);
  }

  // A simulated Otter that sails on, and hears fish.
  await page.goto(`${url}/vessels/${OTTER}?tab=Tags`);
  await badge("LIVE");
  await page.getByRole("row", { name: /S256-10\d/ }).nth(2).waitFor({ timeout: 2 * PATIENCE_MS });
  const now = Date.now() * 1e3;
  const first = (await json(`/api/v1/series?system=${OTTER}`)).find((one) => one.message === "EstimatedState").first_us;
  const [from, to] = [Math.max(first, now - 300_000_000), now];
  await replay(OTTER, from, to, "otter", !log);

  // Tags of the range lie on the map, grouped; a group lists its tags.
  const { detections } = await json(`/api/v1/vessels/${OTTER}/detections?from_us=${from}&to_us=${to + 1}&limit=5000`);
  await page.getByRole("tab", { name: "Tags" }).click();
  const rows = page.getByRole("tabpanel", { name: "Tags" }).locator("tbody tr");
  await page.waitForFunction((count) => document.querySelectorAll("#panel-5 tbody tr").length === count, detections.length);
  const map = page.locator(".map");
  // From what all of it takes; the map may still be finding that by itself.
  await page.getByRole("button", { name: "Show all", exact: true }).click();
  await page.waitForTimeout(400);
  await map.focus();
  for (let at = 0; at < 8; at++) await page.keyboard.press("-");
  await page.getByRole("button", { name: "Show all", exact: true }).focus();
  await page.waitForTimeout(400);
  const middle = await map.boundingBox();
  // Zoomed out far enough, all of them are one group in the middle.
  await page.mouse.click(middle.x + middle.width / 2, middle.y + middle.height / 2);
  await page.getByText(`${detections.length} of ${detections.length} detections: those at the chosen place on the map.`).waitFor();
  await look(page, "replay-tags-grouped");
  await button("Show all tags").click();
  await page.getByRole("button", { name: "Show all", exact: true }).click();
  const saved = page.waitForEvent("download");
  await page.getByRole("link", { name: "Download CSV of tags heard" }).click();
  const tags = table(await readFile(await (await saved).path(), "utf8"));
  const seen = await rows.evaluateAll((rows) => rows.map((row) => [...row.cells].slice(0, 6).map((cell) => cell.textContent)));
  const [heard, ...columns] = ["heard_utc", "tag", "sensor_value [count]", "snr [dB]", "frequency [kHz]", "receiver"].map((name) => tags.head.indexOf(name));
  same(tags.rows.toReversed().map((row) => [`${row[heard].slice(0, 19).replace("T", " ")}Z`, ...columns.map((at) => row[at])]), seen, "tags as they are shown");

  // A tag's row sets the time everywhere, and the log book's too.
  const tag = detections[0];
  await rows.last().getByRole("button").click();
  await page.waitForFunction((ms) => Math.abs(Date.parse(document.querySelector(".replaybar .clock").textContent.replace(" ", "T")) - ms) <= 1_000, tag.time_us / 1e3);
  check(query().get("t") === String(tag.time_us), page.url());
  await page.locator('tr[aria-current="time"]').waitFor();

  await page.getByRole("tab", { name: "Log book" }).click();
  const entry = page.getByRole("tabpanel", { name: "Log book" }).locator("tbody tr").first();
  const wroteUs = await entry.getAttribute("data-us");
  await entry.getByRole("button").click();
  await page.waitForFunction((us) => new URL(location.href).searchParams.get("t") === us, wroteUs);
  const savedBook = page.waitForEvent("download");
  await page.getByRole("button", { name: "Download CSV of log book as shown" }).click();
  const book = table(await readFile(await (await savedBook).path(), "utf8"));
  const written = await page.getByRole("tabpanel", { name: "Log book" }).locator("tbody tr").evaluateAll((rows) => rows.map((row) => [...row.cells].map((cell) => cell.textContent)));
  same(book.rows.map(([, time, severity, entity, from, text]) => [`${time.slice(0, 19).replace("T", " ")}Z`, severity, from || entity, text]), written.map(([time, severity, ...rest]) => [time, severity.split(" ")[1], ...rest]), "the log book as it is shown");
  check(book.rows.some((row) => row[5].includes("square")) && book.rows.every(([vessel]) => vessel === "otter-1"), JSON.stringify(book.rows[0]));

  // The track on the map tells it too: pointed to, the time at which the boat was there; tapped, it stays.
  await page.getByRole("tab", { name: "Plots" }).click();
  await page.getByRole("button", { name: "Show all", exact: true }).click();
  const stood = await clock();
  let found;
  for (let x = middle.x + 60; x < middle.x + middle.width - 60 && !found; x += 6) {
    await page.mouse.move(x, middle.y + middle.height / 2);
    await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
    if ((await clock()) !== stood) found = x;
  }
  check(found, "the track tells its time");
  const pointed = await clock();
  const minutes = (text) => [...text.matchAll(/(\d+\.\d+)′/g)].map((one) => Number(one[1]));
  const [track, mouse] = [minutes(await page.locator(".here").textContent()), minutes(await page.locator(".ol-mouse-position").textContent())];
  check(Math.abs(track[0] - mouse[0]) < 0.02 && Math.abs(track[1] - mouse[1]) < 0.04, `${track} is where the pointer is: ${mouse}`);
  await page.waitForFunction(() => /\d °/.test(document.querySelectorAll(".plot .legend .num")[1].textContent));
  await page.mouse.click(found, middle.y + middle.height / 2);
  // Where a tag lies on the track, the tap is the tag's.
  await page.waitForFunction(
    (time) => Math.abs(Number(new URL(location.href).searchParams.get("t")) - Date.parse(time.replace(" ", "T")) * 1e3) < 2e6 || /those at the chosen place on the map/.test(document.body.textContent),
    pointed,
  );
  await page.getByRole("tab", { name: "Plots" }).click();

  // Measuring by clicks and by keys.
  await button("Measure").click();
  await page.keyboard.press("Enter");
  await page.getByText(/Click the next place/).waitFor();
  await page.mouse.click(middle.x + middle.width / 4, middle.y + middle.height / 2);
  await page.locator(".measured").getByText(/ m \(\d+\.\d{3} nmi\), 2[67]\d° T/).waitFor();
  await look(page, "replay-measure");
  await map.focus();
  await page.keyboard.press("Escape");
  await page.waitForFunction(() => document.querySelector(".measured").textContent === "");

  // Back to live by one button, with all its commands.
  await button("Back to live").click();
  await badge("LIVE");
  await page.waitForFunction(() => !document.querySelector('[data-tile="speed_mps"]').hasAttribute("data-old"));
  check(!(await page.locator(".control-box").evaluate((node) => node.inert)), "the controls are back");
  check(query().get("t") === null && query().get("span") !== null, page.url());
  await look(page, "replay-live");

  // A vessel of which nothing is known says what to do.
  await page.goto(`${url}/vessels/2457`);
  await page.getByText("Nothing is recorded of this vessel yet.").waitFor();
});
