// How a route of the chart becomes part of a plan.

import assert from "node:assert/strict";
import { test } from "node:test";
import { load } from "../testing/bundled.mjs";

const { canGoAround, energyOf, placesOfRoute, progressText, remarks, routeName, keptSpeedText, routesOf, routeText, savedText, speedFor, stretchAt, withRoute, withWayAround } = await load("state/searoute");

const speed = { value: 1.5, unit: "mps" };
const at = (lat_deg, lon_deg) => ({ lat_deg, lon_deg });
const route = (points, more = {}) => ({ points, legs: points.slice(1).map(() => ({})), length_m: 2865, duration_s: 1910, energy_wh: 120, speed_mps: 1.5, current_unknown_m: 0, current_too_strong: false, least_depth_m: 5, least_clearance_m: 18.4, moved: [], guarded: true, guard: null, narrow: null, part_only: false, ...more });
const found = route([[63, 10], [63.1, 10.1], [63.2, 10.1], [63.3, 10]]);
const goto = (id, lat, lon) => ({ id, speed, task: { kind: "goto", at: at(lat, lon) } });
const plan = (...maneuvers) => ({ name: "p", description: "", vessel: null, repeat: false, maneuvers });

const ENDS = { from: { lat_deg: 63, lon_deg: 10 }, to: { lat_deg: 64, lon_deg: 10 } };

test("a route is told in a line, with what is least", () => {
  assert.equal(routeText(found), "2865 m · 32 min · least depth 5.0 m · clear by 18 m");
  assert.equal(routeText(route([[63, 10], [63.3, 10]], { length_m: 81_770, duration_s: 54_513, least_depth_m: null, least_clearance_m: null })), "81.8 km · 15 h 9 min · clear by more than 5 km");
});

test("where there is no room for a vessel off its track is told", () => {
  assert.deepEqual(remarks({ route: found, refusal: null }), []);
  const [text] = remarks({ route: { ...found, narrow: { needed_m: 29.2, leg: 1, least_m: 18.4, legs: 2, length_m: 900 } }, refusal: null });
  assert.match(text, /^On 2 legs danger is nearer than the 29 m .*: 18 m from leg 2\. /);
});

test("legs in ordered traffic are named", () => {
  const legs = [{ traffic: null }, { traffic: { kind: "lane", against: false } }, { traffic: { kind: "lane", against: true } }, { traffic: { kind: "separation_zone", against: false } }];
  assert.deepEqual(remarks({ route: { ...found, legs }, refusal: null }), ["Leg 2 leads through a traffic lane.", "Leg 3 leads against the direction of a traffic lane.", "Leg 4 leads through a traffic separation zone."]);
});

test("how far a long route has come is told by what was searched, not by what is left", () => {
  const of = (more) => progressText({ waiting: false, tiles: 0, most_tiles: 0, spent_s: 12.4, most_s: 90, ...more });
  assert.equal(of({ waiting: true }), "Waiting for other routes: 12 s");
  assert.equal(of({}), "Preparing the water: 12 s");
  assert.equal(of({ tiles: 140, most_tiles: 2000 }), "Searched 140 tiles of the chart, of 2000 at most: 12 s");
});

test("routes to choose from are the shortest first, and say by how much they are longer", () => {
  const other = { ...found, length_m: 3175.4, duration_s: 2117 };
  const answer = { route: found, shortest: null, alternatives: [other] };
  const routes = routesOf(answer);
  assert.deepEqual(routes.map((one, index) => routeName(one, index, answer, "shortest")), [
    "Shortest · 2865 m · 32 min · least depth 5.0 m · clear by 18 m",
    "2: 310 m longer · 3175 m · 35 min · least depth 5.0 m · clear by 18 m",
  ]);
  assert.deepEqual(routesOf({ route: null, alternatives: [] }), []);
  assert.deepEqual(routesOf(undefined), []);
});

test("a current that is too strong leaves time and energy out", () => {
  assert.equal(routeText({ ...found, duration_s: null }), "2865 m · the current is too strong · least depth 5.0 m · clear by 18 m");
  assert.match(routeText({ ...found, duration_s: null, current_unknown_m: 200 }), /the current is not known everywhere/);
  assert.match(routeText({ ...found, duration_s: null, current_unknown_m: 200, current_too_strong: true }), /· the current is too strong, the current is not known everywhere ·/);
  assert.equal(energyOf({ energy_wh: null, speed_mps: 1.5 }), "");
  assert.equal(energyOf({ energy_wh: 123.4, speed_mps: 1.5 }), "About 123 Wh from the batteries at 1.50 m/s (estimate).");
});

test("the route of an objective stands beside the shortest one, and says what it saves", () => {
  const best = { ...found, length_m: 3000, duration_s: 1719, energy_wh: 90, speed_mps: 1.2 };
  const answer = { route: best, shortest: found, alternatives: [] };
  assert.deepEqual(routesOf(answer).map((one, index) => routeName(one, index, answer, "least_energy")), [
    "Least energy, 135 m longer · 3000 m · 29 min · least depth 5.0 m · clear by 18 m · 90 Wh",
    "Shortest · 2865 m · 32 min · least depth 5.0 m · clear by 18 m · 120 Wh",
  ]);
  assert.equal(savedText(answer), "Against the shortest route: length +5 %, time −10 %, energy −25 %.");
  assert.equal(savedText({ ...answer, shortest: null }), "");
  assert.equal(savedText({ ...answer, route: { ...best, duration_s: null } }), "Against the shortest route: length +5 %, energy −25 %.");
  // A plan takes the speed that saves the energy, and keeps its own otherwise.
  assert.deepEqual(speedFor(best, speed), { value: 1.2, unit: "mps" });
  assert.equal(speedFor(found, speed), speed);
  const percent = { value: 40, unit: "percent" };
  assert.equal(speedFor(best, percent), percent);
  assert.equal(keptSpeedText(best, speedFor(best, speed)), "");
  assert.equal(keptSpeedText(best, percent), "The plan keeps its own speed; time and energy are for 1.20 m/s.");
  assert.match(keptSpeedText(best, speed), /for 1\.20 m\/s/);
});

test("what is moved, refused or against the guard is told", () => {
  assert.deepEqual(remarks({ route: found, refusal: null }), []);
  const guard = { code: "too-shallow", number: 1, depth_m: 2.5 };
  assert.deepEqual(remarks({ route: route([], { moved: [{ end: "goal", distance_m: 20.4, text: "moved" }], guarded: false, guard }), refusal: null }), [
    "The goal lies too near land, shallow water, a danger or an area to avoid; it was moved by 20 m.",
    "The guard would refuse leg 2: too shallow, 2.5 m",
  ]);
  const none = { text: "in English", stretch: 0, nearest: null, gap_m: null, closed: null, apart_m: null, looked_m: null, by: [], passable: null };
  const told = (refusal) => remarks({ route: null, refusal: { ...none, ...refusal } });
  assert.deepEqual(told({ code: "failed" }), ["in English"]);
  assert.deepEqual(told({ code: "closed_start", gap_m: 740.2, closed: { code: "land", depth_m: null, may_move_m: 200 } }), ["No route can begin there (land). The nearest open water is 740 m away; the start is moved by 200 m at most."]);
  assert.deepEqual(told({ code: "closed_goal", closed: { code: "too-shallow", depth_m: -1, may_move_m: 200 } }), ["No route can end there (charted depth dries 1.0 m, or too near a danger), and there is no open water within 50 km."]);
  assert.deepEqual(told({ code: "too_far", apart_m: [812_000, 500_000] }), ["Start and goal are 812 km apart; routes are planned up to 500 km: add places on the way."]);
  assert.deepEqual(told({ code: "too_far", apart_m: [512_000, 180_000], by: [[63.12346, 8.5], [64, 9.25]] }), ["Start and goal are 512 km apart; routes are planned up to 180 km here. Add places on the way, such as 63.1235, 8.5000; 64.0000, 9.2500."]);
  assert.match(told({ code: "not_found", looked_m: 74_600, gap_m: 812.4 })[0], /up to 75 km from the start\. .* is 812 m from the goal\./);
  assert.match(remarks({ route: route([], { part_only: true }), refusal: null })[0], /^The charts hold so much here/);
  const noWay = "No route is deep enough and keeps this clearance. The nearest place that can be reached is 812 m from the goal.";
  assert.deepEqual(told({ code: "no_way", gap_m: 812 }), [noWay]);
  const passable = { depth_m: 3, shallowest_at: [63, 10], clearance_m: 12, gap_at: null, gap_width_m: null, by_rule_alone: false, by_zones_alone: false };
  assert.deepEqual(told({ code: "no_way", gap_m: 812, passable }), [noWay, "There is one with a least depth of 3 m, or with a clearance of 12 m."]);
  assert.deepEqual(told({ code: "no_way", gap_m: 812, passable: { ...passable, depth_m: null, clearance_m: null, by_rule_alone: true } }), [noWay, "No smaller depth or clearance was found that gives one.", "Areas where entry is prohibited or restricted are in the way; without them there is a route."]);
  assert.deepEqual(told({ code: "no_way", gap_m: 812, passable: { ...passable, depth_m: null, gap_at: [63, 10], gap_width_m: 25.7, by_zones_alone: true } }), [noWay, "There is one with a clearance of 12 m.", "The narrowest gap is 25 m wide; the map shows it.", "The areas to avoid are in the way; without them there is a route."]);
  assert.deepEqual(told({ code: "closed_goal", closed: { code: "zone", depth_m: null, may_move_m: 200 } }), ["No route can end there: it lies in an area to avoid, or too near its edge."]);
});

test("a route is a path of its own, after the chosen maneuver or at the end", () => {
  const two = plan(goto("Path 1", 62, 10), goto("b", 64, 10));
  assert.deepEqual(withRoute(two, found, speed).maneuvers.map(({ id }) => id), ["Path 1", "b", "Path 2"]);
  const between = withRoute(two, found, speed, 0);
  assert.deepEqual(between.maneuvers.map(({ id }) => id), ["Path 1", "Path 2", "b"]);
  assert.deepEqual(between.maneuvers[1].task.points, placesOfRoute(found));
});

test("a refused transit gets a path before its maneuver, without the ends that the plan has", () => {
  const two = plan(goto("a", 63, 10), goto("b", 63.3, 10));
  const around = withWayAround(two, found, { maneuver: "b", part: "transit", number: 0 });
  assert.deepEqual(around.maneuvers.map(({ id }) => id), ["a", "Path 1", "b"]);
  assert.deepEqual(around.maneuvers[1].task.points, [at(63.1, 10.1), at(63.2, 10.1)]);
});

test("a refused leg of a path gets points between its own", () => {
  const path = { id: "way", speed, task: { kind: "follow_path", points: [at(62, 10), at(63, 10), at(63.3, 10), at(64, 10)] } };
  const around = withWayAround(plan(path), found, { maneuver: "way", part: "track", number: 1 });
  assert.deepEqual(around.maneuvers[0].task.points, [at(62, 10), at(63, 10), at(63.1, 10.1), at(63.2, 10.1), at(63.3, 10), at(64, 10)]);
});

test("nothing happens to a plan that has changed meanwhile, or for a way that needs no corner", () => {
  const two = plan(goto("a", 63, 10), goto("b", 63.3, 10));
  assert.equal(withWayAround(two, found, { maneuver: "gone", part: "transit", number: 0 }), two);
  assert.equal(withWayAround(two, route([[63, 10], [63.3, 10]]), { maneuver: "b", part: "transit", number: 0 }), two);
  assert.ok(canGoAround({ ...ENDS, part: "transit" }) && !canGoAround({ ...ENDS, part: "circle" }) && !canGoAround({ ...ENDS, from: null, part: "transit" }));
});

test("a place to pass belongs to the stretch on which the line was pulled", () => {
  const chosen = [at(63, 10), at(63.2, 10.1), at(63.3, 10)];
  const places = placesOfRoute(found);
  assert.deepEqual([0, 1, 2].map((leg) => stretchAt(chosen, places, leg)), [0, 0, 1]);
});

test("a search that was stopped, a closed place on the way and a search of a part are said in words", () => {
  const refusal = (more) => ({ code: "", text: "as the server said it", stretch: 0, nearest: null, gap_m: null, closed: null, apart_m: null, looked_m: null, gave_up: null, via: null, by: [], passable: null, ...more });
  const said = (more) => remarks({ route: null, refusal: refusal(more) }).join(" ");
  assert.match(said({ code: "gave_up", looked_m: 120_400, gave_up: { tiles: 412, out_of_time: true } }), /its time is used up\. It searched 412 tiles of the chart, up to 120 km from the start.*ask again/);
  assert.match(said({ code: "gave_up", looked_m: 120_400, gave_up: { tiles: 2000, out_of_time: false } }), /may search no more of the chart\. It searched 2000 tiles, up to 120 km .*Add places on the way/);
  const closed = { code: "land", depth_m: null, may_move_m: 1000 };
  assert.match(said({ code: "closed_via", via: 2, closed, gap_m: 1400 }), /^No route can pass place 2 \(.+\)\. The nearest open water is 1400 m away; the place is moved by 1000 m at most\.$/);
  assert.match(said({ code: "closed_via", via: 2, closed }), /^No route can pass place 2 \(.+\), and there is no open water within 50 km\.$/);
  assert.match(said({ code: "no_way", gap_m: 80, looked_m: 40_000 }), /80 m from the goal \(searched 40 km around the start\)\.$/);
  assert.match(said({ code: "no_way", gap_m: 80 }), /80 m from the goal\.$/);
  assert.match(said({ code: "not_found", gap_m: 80, looked_m: 40_000 }), /^No route was found in the water that was looked at, up to 40 km/);
});

test("places to pass that were moved are named by number, and speed limits on the way are said", () => {
  const moved = [{ end: "via", via: 2, distance_m: 84.4, text: "" }, { end: "goal", via: null, distance_m: 10, text: "" }];
  const [via, goal, slow] = remarks({ route: { ...found, moved, legs: [{ limit_mps: null }, { limit_mps: 0.8 }] }, refusal: null });
  assert.match(via, /^Place 2 on the way lies too near land.* moved by 84 m\.$/);
  assert.match(goal, /^The goal lies too near land/);
  assert.match(slow, /^The route enters areas with a speed limit\./);
});
