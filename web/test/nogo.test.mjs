// Which areas a GeoJSON file closes, and what is said where it cannot.

import assert from "node:assert/strict";
import { test } from "node:test";
import { load } from "../testing/bundled.mjs";

const { areasOfGeoJson } = await load("state/nogo");

const ring = (east = 0) => [[10 + east, 63], [10.01 + east, 63], [10.01 + east, 63.01], [10 + east, 63]];
const of = (geo) => areasOfGeoJson(JSON.stringify(geo), "farms");
const polygon = (...rings) => ({ type: "Polygon", coordinates: rings });

test("each polygon is an area, by its own name or by the file's", () => {
  const feature = (properties, geometry) => ({ type: "Feature", properties, geometry });
  const { areas, wrong } = of({ type: "FeatureCollection", features: [feature({ navn: " Ørnes " }, polygon(ring())), feature(null, polygon(ring(1))), feature({ name: "twins" }, { type: "MultiPolygon", coordinates: [[ring(2)], [ring(3)]] }), feature({}, { type: "Point", coordinates: [1, 2] }), feature({}, null)] });
  assert.equal(wrong, "");
  assert.deepEqual(areas.map(({ name }) => name), ["Ørnes", "farms 2", "twins 1", "twins 2"]);
  assert.deepEqual(areas[0].corners, [[63, 10], [63, 10.01], [63.01, 10.01]], "latitude first, the first corner once");
  assert.equal(of(polygon(ring())).areas[0].name, "farms");
});

test("what cannot be closed is named by its number, and nothing of the file is taken", () => {
  const second = (geometry) => of({ type: "GeometryCollection", geometries: [polygon(ring()), geometry] });
  const long = [...Array.from({ length: 201 }, (_, n) => [10 + n * 1e-4, 63 + (n % 2) * 1e-4]), [10, 63]];
  for (const [geometry, told] of [
    [polygon(ring(), ring(0.001)), /^Polygon 2: it has holes/],
    [polygon([[10, 63], ["x", 63], [10, 64], [10, 63]]), /^Polygon 2: a corner does not have longitude/],
    [polygon([[200, 63], [10, 63], [10, 64], [200, 63]]), /^Polygon 2: a corner does not have longitude/],
    [polygon([[10, 63], [10.1, 63], [10, 63]]), /^Polygon 2: An area has three corners/],
    [polygon([[10, 63], [10.1, 63.1], [10.1, 63], [10, 63.1], [10, 63]]), /^Polygon 2: Two sides/],
    [polygon(long), /^Polygon 2: it has 201 corners/],
    [polygon([[10, 63], [10.1, 63], [10.1, 63.1], [10, 63.1]]), /^Polygon 2: its last corner is not its first/],
    [{ type: "Polygon" }, /^Polygon 2: /],
    [{ type: "Polygon", coordinates: 7 }, /GeoJSON/],
  ]) {
    const { areas, wrong } = second(geometry);
    assert.match(wrong, told);
    assert.deepEqual(areas, []);
  }
  for (const text of ["", "{", "null", "[1]", '"x"', '{"type":"FeatureCollection","features":7}']) assert.notEqual(areasOfGeoJson(text, "x").wrong, "", text);
  assert.equal(of({ type: "FeatureCollection", features: [] }).wrong, "There are no polygons in the file.");
});
