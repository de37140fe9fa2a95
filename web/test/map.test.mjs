// Whose a click on the map is, what lies over what, and round distances: pure parts, bundled for Node.

import assert from "node:assert/strict";
import { test } from "node:test";
import { load } from "../testing/bundled.mjs";

const { createClicks } = await load("map/clicks");
const { over } = await load("map/layers");
const { edges, HALF_NAME_PX, TOOLS_PX } = await load("map/edges");
const { vesselLabel, vesselStyle } = await load("map/symbols");
const { graticuleStep_deg, ringStep_m } = await load("map/scale");

test("a click is taken once: by what is in hand, else by what lies there, else by the place", () => {
  let click = () => undefined;
  const clicks = createClicks({ on: (kind, then) => void (kind === "singleclick" && (click = then)) });
  const took = [];
  const wants = { pick: false, track: true, place: true };
  // In any order of coming.
  for (const claim of ["place", "track", "pick"]) clicks.claim(claim, () => (wants[claim] && took.push(claim), wants[claim]));
  click({});
  assert.deepEqual(took, ["track"], "choosing a time on the track does not ask what is there");
  wants.pick = true;
  click({});
  wants.pick = wants.track = false;
  click({});
  assert.deepEqual(took, ["track", "pick", "place"]);
  wants.place = false;
  click({});
  assert.equal(took.length, 3);
});

test("nothing lies over a vessel", () => {
  for (const layer of ["route", "tags", "cursor", "own", "rings", "planMarks", "measure"]) assert.ok(over("vessel") > over(layer), layer);
});

test("what is brought into view lies under no tool, with its name", () => {
  for (const width of [320, 390, 700, 1440]) {
    const [above, right, below, left] = edges(width);
    assert.ok(right >= TOOLS_PX + HALF_NAME_PX, `${width} px: ${right} px on the right`);
    // Names stand below, over the words at the edge; the buttons on the left are 44 px wide.
    assert.ok(above >= 50 && below >= 80 && left >= 53, `${width} px`);
  }
});

test("a vessel keeps its name where a plan's places have theirs, and says how it is heard", () => {
  const palette = { ink: "#000", halo: "#fff", series: ["#00f"], first: [] };
  const system = { address: 1, name: "otter-1", liveness: "live", fix: { heading_rad: 1 } };
  const { styles } = vesselStyle(system, palette, true);
  const names = styles.flatMap((style) => (style.getText() ? [style.getText()] : []));
  assert.deepEqual(names.map((text) => [text.getText(), text.getDeclutterMode()]), [["otter-1", "obstacle"]]);
  assert.ok(styles.every((style) => !style.getImage() || style.getImage().getDeclutterMode() !== "declutter"), "and the vessel itself never gives way");
  assert.deepEqual(["late", "stale", "lost"].map((liveness) => vesselLabel({ ...system, liveness })), ["otter-1", "otter-1 (stale)", "otter-1 (lost)"]);
});

test("range rings are at round distances that are not too near", () => {
  for (const [least, step] of [[0, 1], [3, 5], [20, 20], [21, 50], [99.9, 100], [100, 100], [6_000, 10_000]]) assert.equal(ringStep_m(least), step, String(least));
});

test("meridians stand at the least round angle that leaves room for their figures", () => {
  for (const [resolution, step] of [[0.01, 0.6 / 3600], [1, 6 / 3600], [20, 2 / 60], [1_000, 2], [9_000, 10], [10_000, undefined]]) assert.equal(graticuleStep_deg(resolution, 116), step, String(resolution));
});

test("course up holds near north too, and ends when somebody turns the map", async () => {
  const { createFollow } = await load("map/follow");
  const { default: View } = await import("ol/View.js");
  const view = new View({ center: [0, 0], zoom: 12, constrainRotation: false });
  /** A button of the tools: it is clicked and has attributes. */
  class Button extends EventTarget {
    attributes = new Map();
    getAttribute(name) {
      return this.attributes.get(name) ?? null;
    }
    setAttribute(name, value) {
      this.attributes.set(name, value);
    }
  }
  const buttons = {};
  const map = { getView: () => view, on: () => undefined, getTargetElement: () => undefined };
  const follow = createFollow(map, { button: (name) => (buttons[name] = new Button()) });
  const at = (course_rad) => follow.update({ lat_deg: 63, lon_deg: 10, course_rad, heading_rad: null });
  const courseUp = () => buttons.course.getAttribute("aria-pressed");
  at(1);
  buttons.course.dispatchEvent(new Event("click"));
  assert.equal(view.getRotation(), -1);
  for (const course of [0.05, 0.0, -0.05]) {
    at(course);
    assert.deepEqual([courseUp(), Math.abs(view.getRotation() + course) < 1e-12], ["true", true], `course ${course}`);
  }
  follow.northUp();
  at(1);
  assert.deepEqual([courseUp(), view.getRotation()], ["false", 0], "north up is not overruled by the next place");
  buttons.course.dispatchEvent(new Event("click"));
  view.setRotation(0.3);
  assert.deepEqual([courseUp(), view.getRotation()], ["false", 0.3], "a turn by hand is left as it is");
});
