// Values come back from forms as they went in: typed as they are shown, kept as vessels and plans have them.

import assert from "node:assert/strict";
import { test } from "node:test";
import { load } from "../testing/bundled.mjs";

const { DEG, KNOT_MPS, isSame, limitShown, minutesRead, minutesShown, shownAs, toShown, toWire } = await load("state/units");

const TYPED = ["0", "0.1", "0.5", "1", "2", "2.5", "2.916", "3", "-4.25", "12.345678", "90", "359.9", "0.000001", "1000"];

test("what somebody types comes back as it was typed, whatever the wire does to its last digits", () => {
  for (const unit of ["rad", "rad/s", "m/s", "m", "%"]) {
    for (const text of TYPED) {
      const wire = toWire(Number(text), unit);
      for (const [what, told] of [["as it is", wire], ["in single precision", Math.fround(wire)], ["in nine decimals", Number(wire.toFixed(9))]]) {
        // Single precision and nine decimals do not hold a millionth.
        if (shownAs(unit).factor === 1 || (what !== "as it is" && /\.\d{4}/.test(text))) continue;
        assert.equal(toShown(told, unit), text, `${text} ${unit}, ${what}`);
      }
    }
  }
});

test("the same number goes back to the vessel, and the text for it is the same again", () => {
  let seed = 7;
  const random = () => (seed = (seed * 48_271) % 2_147_483_647) / 2_147_483_647;
  for (let time = 0; time < 2_000; time++) {
    const typed = Number((random() * 400 - 200).toFixed(Math.floor(random() * 6)));
    for (const unit of ["rad", "m/s"]) {
      const text = toShown(toWire(typed, unit), unit);
      assert.ok(isSame(toWire(Number(text), unit), toWire(typed, unit)), `${typed} ${unit} as ${text}`);
      assert.equal(toShown(toWire(Number(text), unit), unit), text);
    }
  }
});

test("units are shown as the page has them", () => {
  assert.deepEqual(["rad", "rad/s", "m/s", "m", ""].map((unit) => shownAs(unit).unit), ["°", "°/s", "kn", "m", ""]);
  assert.ok(Math.abs(toWire(1, "m/s") - KNOT_MPS) < 1e-12 && Math.abs(toWire(180, "rad") - 180 / DEG) < 1e-11, "to twelve digits");
  assert.equal(toWire(18, "m/s"), 9.26, "18 kn, exactly");
  assert.equal(toShown(1.5, "m/s"), "2.916", "no short form: four digits");
  assert.equal(toShown(12, "m"), "12");
  assert.equal(shownAs("constructor").unit, "constructor");
});

test("a limit that is shown is itself allowed", () => {
  for (const limit of [0.1, 0.25, 1.5, 2, 2.5, 3, 5, 12]) {
    const [least, most] = ["least", "most"].map((side) => toWire(Number(limitShown(limit, "m/s", side)), "m/s"));
    assert.ok(least >= limit - 1e-9 && least < limit * 1.002, `${limit}: ${least}`);
    assert.ok(most <= limit + 1e-9 && most > limit * 0.998, `${limit}: ${most}`);
  }
  assert.equal(limitShown(0, "m/s", "least"), "0");
  assert.equal(limitShown(50, "m", "most"), "50");
});

test("minutes tell each second, and are read as people write them", () => {
  for (let seconds = 0; seconds <= 4_000; seconds++) assert.equal(minutesRead(minutesShown(seconds)), seconds);
  for (const [text, seconds] of [["5", 300], ["1.5", 90], ["1,5", 90], ["1:30", 90], ["90:05", 5_405], [" 0 ", 0]]) assert.equal(minutesRead(text), seconds, text);
  for (const text of ["", "x", "1:60", "1:5", ":30"]) assert.ok(Number.isNaN(minutesRead(text)), text);
  assert.deepEqual([300, 90, 100].map(minutesShown), ["5", "1.5", "1.67"]);
});
