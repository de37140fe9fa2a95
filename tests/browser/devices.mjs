// What real protocols brought, on the pages: node devices.mjs URL NAME PASSWORD VESSEL HEARD, where HEARD is JSON of detections with
// their time (heard_us) and where the vessel truly was (lat_deg, lon_deg). Prints nothing.

import { check, inBrowser, logIn } from "./browser.mjs";

const [url, name, password, vessel, heard] = process.argv.slice(2);
/** What is shown to a thousandth of a minute may be off by half of one, 0.9 m, beside the 1.5 m that detections may be off. */
const TOLERANCE_M = 2.5;

/** Degrees of a place as pages write it: 63° 26.777′ N 010° 20.700′ E. */
function degrees(text) {
  const [, lat, latMin, ns, lon, lonMin, ew] = /(\d+)° ([\d.]+)′ ([NS]) (\d+)° ([\d.]+)′ ([EW])/.exec(text) ?? [];
  return [(Number(lat) + Number(latMin) / 60) * (ns === "S" ? -1 : 1), (Number(lon) + Number(lonMin) / 60) * (ew === "W" ? -1 : 1)];
}

await inBrowser(async (open) => {
  const page = await open();
  await logIn(page, url, name, password);
  await page.getByText("Live", { exact: true }).waitFor();
  for (const path of ["/detections", `/vessels/${vessel}?tab=Tags`]) {
    await page.goto(url + path);
    for (const { heard_us, lat_deg, lon_deg } of JSON.parse(heard)) {
      const second = new Date(heard_us / 1e3).toISOString().slice(0, 19).replace("T", " ");
      const row = page.locator("main tbody tr", { hasText: second }).first();
      const place = await row.locator("td", { hasText: "′" }).textContent();
      const [lat, lon] = degrees(place);
      const off_m = Math.hypot((lat - lat_deg) * 111_500, (lon - lon_deg) * 111_500 * Math.cos((lat_deg * Math.PI) / 180));
      check(off_m < TOLERANCE_M, `${path}: ${off_m} m from the truth: ${place}`);
    }
  }
});
