// Alarms told to who looks at no page: node notices.mjs URL ONE-TIME-PASSWORD. A webhook of this script's own gets them. Prints
// what the boat is to do.

import { once } from "node:events";
import { createServer } from "node:http";
import { check, inBrowser, logIn, look } from "./browser.mjs";

const [url, oneTime] = process.argv.slice(2);

/** A webhook that keeps what it gets, and answers what it is told to. */
const got = [];
let answer = 204;
const hook = createServer(async (request, response) => {
  let body = "";
  for await (const part of request) body += part;
  got.push({ ...JSON.parse(body), signature: request.headers["lutra-signature"], delivery: request.headers["lutra-delivery"] });
  response.writeHead(answer).end(answer === 204 ? undefined : "not here");
}).listen(0, "127.0.0.1");
await once(hook, "listening");
const target = `http://127.0.0.1:${hook.address().port}/lutra`;

/** Lets the server's clock go on until the webhook got a message of this event. */
const gets = async (page, event) => {
  for (let steps = 0; !got.some((one) => one.event === event); steps++) {
    check(steps < 60, `${event} in ${JSON.stringify(got.map((one) => one.event))}`);
    console.log("advance 5");
    await page.waitForTimeout(300);
  }
  return got.find((one) => one.event === event);
};

await inBrowser(async (open) => {
  const page = await open();
  await logIn(page, url, "admin", oneTime, "nine grey otters");
  await page.goto(`${url}/account`);
  const part = page.getByRole("region", { name: "Messages about alarms" });
  await part.getByText("This server sends no mail").waitFor();

  // What cannot be is refused beside its remedy, and makes no rule.
  const field = part.getByLabel("Address or URL");
  await field.fill("somewhere");
  await part.getByRole("button", { name: "Add rule" }).click();
  await page.getByRole("alert").getByText('"somewhere" is not a URL; give one like https://example.org/hook.').waitFor();
  check(!(await part.getByRole("list", { name: "Your rules" }).count()), "no rule is made");

  await field.fill(target);
  await part.getByLabel("Also when it is over").check();
  await part.getByRole("button", { name: "Add rule" }).click();
  const key = await part.locator(".secret").innerText();
  check(/^[0-9a-f]{64}$/.test(key), "the key is shown once");
  await look(page, "notices-key");
  await page.goto(`${url}/account`);
  check(!(await page.content()).includes(key), "and never again");
  await part.getByRole("listitem").filter({ hasText: target }).getByText(/^alarm and worse, all vessels/).waitFor();

  // Tried out: what became of it is on the page at once.
  const send = part.getByRole("button", { name: /^Send a test message/ });
  await send.click();
  await page.getByRole("status").getByText("The test message was delivered.").waitFor();
  check(got.length === 1 && got[0].event === "test" && /^t=\d+,v1=[0-9a-f]{64}$/.test(got[0].signature), JSON.stringify(got));
  answer = 410;
  await send.click();
  await page.getByRole("alert").getByText("The test message: refused: it answers 410 Gone: not here.").waitFor();
  answer = 204;
  await look(page, "notices-refused");

  // An alarm, and its end, though no page shows alarms to anybody.
  console.log("silence");
  const raised = await gets(page, "alarm.raised");
  check(raised.alarm.vessel_name === "otter-0" && raised.alarm.text, JSON.stringify(raised.alarm));
  console.log("speak");
  const over = await gets(page, "alarm.over");
  check(over.alarm.id === raised.alarm.id && over.delivery !== raised.delivery, "its end");
  await page.reload();
  await part.getByText("The last messages").click();
  await part.getByRole("row", { name: /over: .* delivered$/ }).first().waitFor();
  await look(page, "notices-delivered");

  await part.locator("summary", { hasText: /^Remove/ }).click();
  await part.getByRole("button", { name: "Remove the rule now" }).click();
  await page.getByText("The rule is removed.").waitFor();
});
hook.close();
