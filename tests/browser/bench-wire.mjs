// What goes over the wire while pages are left alone: node bench-wire.mjs LUTRA-SERVER [SECONDS], as `scripts/bench-pages
// wire` starts it. Two simulated Otters sail before it, as lutra-agent sends all that it has.

import { spawn } from "node:child_process";
import { once } from "node:events";
import { createInterface } from "node:readline";
import { inBrowser, logIn } from "./browser.mjs";
import { verdict } from "./bench-frames.mjs";

const [program, given] = process.argv.slice(2);
/** Longer than a minute, after which a page asks the history again by itself. */
const seconds = Number(given ?? 70);
const VESSEL = 10449;

async function benchWire(page, url, path, what, goalkB) {
  const cdp = await page.context().newCDPSession(page);
  await cdp.send("Network.enable");
  let came = { live: 0, messages: 0, asked: 0 };
  cdp.on("Network.webSocketFrameReceived", ({ response: { opcode, payloadData } }) => {
    came.messages += 1;
    // Binary messages are told in base64.
    came.live += opcode === 2 ? (payloadData.length * 3) / 4 : payloadData.length;
  });
  cdp.on("Network.loadingFinished", ({ encodedDataLength }) => (came.asked += encodedDataLength));
  await page.goto(`${url}${path}`);
  await page.getByText("Live", { exact: true }).waitFor();
  // What it takes to begin is not what it takes to go on.
  await page.waitForTimeout(10_000);
  came = { live: 0, messages: 0, asked: 0 };
  const begun = performance.now();
  await page.waitForTimeout(seconds * 1e3);
  const took = (performance.now() - begun) / 1e3;
  const kB = (bytes) => bytes / took / 1e3;
  verdict(what, `${kB(came.live + came.asked).toFixed(1)} kB/s`, `${goalkB} kB/s`, kB(came.live + came.asked) <= goalkB);
  console.log(`  live socket ${kB(came.live).toFixed(1)} kB/s in ${(came.messages / took).toFixed(1)} messages/s, answers ${kB(came.asked).toFixed(1)} kB/s`);
  await cdp.detach();
}

const demo = spawn(program, ["demo", "--otters", "2", "--no-past", "--no-cut", "--listen", "127.0.0.1:0"], { stdio: ["ignore", "pipe", "inherit"] });
try {
  let [url, password, sailing] = ["", "", 0];
  for await (const line of createInterface({ input: demo.stdout })) {
    const told = /(http:\S+) {2}log in as admin with the password (\S+)/.exec(line);
    if (told) [, url, password] = told;
    if (/^otter-\d +sails/.test(line) && ++sailing === 2) break;
  }
  await inBrowser(async (open) => {
    const page = await open();
    await logIn(page, url, "admin", password);
    await benchWire(page, url, `/vessels/${VESSEL}`, "a vessel's page, left alone", 6);
    await benchWire(page, url, "/", "the first page with 2 vessels, left alone", 4);
  });
} finally {
  demo.kill("SIGTERM");
  await once(demo, "exit");
}
