// The pages by TLS: requests by HTTP/2, and the live socket beside them on a connection of its own: node encrypted.mjs URL NAME PASSWORD.

import { check, inBrowser, logIn } from "./browser.mjs";

const [url, name, password] = process.argv.slice(2);

await inBrowser(async (open) => {
  // The authority is the test's own.
  const page = await open({ ignoreHTTPSErrors: true });
  const sockets = [];
  page.on("websocket", (socket) => sockets.push(socket.url()));
  await logIn(page, url, name, password);
  await page.locator('.system[data-liveness="live"]').getByText("otter-1").waitFor();
  check(sockets.length > 0 && sockets.every((one) => one.startsWith("wss://")), `the live socket: ${sockets}`);
  const protocols = await page.evaluate(() =>
    [...performance.getEntriesByType("navigation"), ...performance.getEntriesByType("resource")]
      .filter((one) => one.name.startsWith("https:") && one.transferSize > 0)
      .map((one) => `${one.nextHopProtocol} ${new URL(one.name).pathname}`),
  );
  check(protocols.length > 2 && protocols.every((one) => one.startsWith("h2 ")), `by another protocol: ${protocols.join(", ")}`);
});
