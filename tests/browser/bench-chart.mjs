// How smoothly a map with its chart is panned over a harbour.

import { frames, panning, smooth } from "./bench-frames.mjs";

const HARBOUR = [63.4445, 10.352];

/** `page` is logged in as who may draw plans; the chart of the demonstration is imported. */
export async function benchChart(page, url, seconds) {
  const csrf = await page.evaluate(() => document.querySelector('meta[name="csrf"]').content);
  const [lat_deg, lon_deg] = HARBOUR;
  const corner = (id, north, east) => ({ id, speed: { value: 1, unit: "mps" }, task: { kind: "goto", at: { lat_deg: lat_deg + north, lon_deg: lon_deg + east } } });
  const plan = { name: `bench ${Date.now()}`, description: "", vessel: null, repeat: false, maneuvers: [corner("a", -0.008, -0.02), corner("b", 0.008, 0.02)] };
  const made = await page.request.post(`${url}/api/v1/plans`, { headers: { "x-csrf-token": csrf }, data: plan });
  await page.goto(`${url}/plans/${(await made.json()).id}`);
  await page.locator(".chart-credit").getByText("depths in m").waitFor();
  await page.waitForLoadState("networkidle");
  for (const what of ["chart of a harbour, panned first", "chart of a harbour, panned again"]) {
    smooth(what, await panning(page, () => frames(page, seconds)), 60);
  }
}
