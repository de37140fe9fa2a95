//! Files as people and programs write them, good and hostile.

use geofile::{Geometry, LeftOut, Position, Shape, Shapes, geojson, gpx};
use proptest::prelude::*;
use serde_json::{Map, json};

const GPX: &str = r#"<?xml version="1.0"?>
<gpx xmlns="http://www.topografix.com/GPX/1/1" version="1.1">
  <metadata><name>Fjord &amp; <![CDATA[<b>]]></name></metadata>
  <wpt lat="63.1" lon="10.1"><name>buoy</name></wpt>
  <rte><name>r</name>
    <rtept lat="63.44" lon="10.40"><ele>3</ele><name>one</name></rtept>
    <rtept lat=" 63.45" lon="10.41"/>
  </rte>
  <trk><name>t</name><trkseg><trkpt lat="63" lon="10"/><trkpt lat="-63" lon="-180"></trkpt></trkseg><trkseg/></trk>
</gpx>"#;

fn at(lat_deg: f64, lon_deg: f64) -> Position {
    Position::new(lat_deg, lon_deg).unwrap()
}

fn point(name: &str, lat_deg: f64, lon_deg: f64) -> Shape {
    Shape { name: name.to_owned(), geometry: Geometry::Point(at(lat_deg, lon_deg)), properties: Map::new() }
}

#[test]
fn routes_and_tracks_are_read_and_marks_are_told() {
    let read = gpx::read(GPX.as_bytes()).unwrap();
    assert_eq!(read.name, "Fjord & <b>");
    let line = Geometry::Line(vec![at(63.0, 10.0), at(-63.0, -180.0)]);
    let track = Shape { name: "t".to_owned(), geometry: line, properties: Map::new() };
    assert_eq!(read.shapes, [point("one", 63.44, 10.40), point("", 63.45, 10.41), track]);
    assert_eq!(read.notes, [LeftOut::Marks(1)]);
}

#[test]
fn way_points_alone_are_points() {
    let text = "<gpx><wpt lat='1' lon='2'><name> a\nb </name></wpt></gpx>";
    assert_eq!(gpx::read(text.as_bytes()).unwrap().shapes, [point("a b", 1.0, 2.0)]);
}

#[test]
fn hostile_gpx_is_refused_with_its_place() {
    let deep = format!("<gpx>{}", "<a>".repeat(100_000));
    for (text, words) in [
        ("", "in place of <gpx>"),
        ("<kml/>", "<kml> in place of <gpx>"),
        ("<gpx><wpt lat='91' lon='0'/></gpx>", "line 1: <wpt> needs lat"),
        ("<gpx>\n<rte>\n<rtept lat='NaN' lon='0'/></rte></gpx>", "line 3: <rtept> needs lat"),
        ("<gpx>\n<rte><rtept/></rte></gpx>", "it has neither"),
        ("<gpx><rte>", "ends within <rte>"),
        ("<gpx>\n\n</rte>", "line 3: this is not XML"),
        ("<!DOCTYPE gpx [<!ENTITY a \"aaaa\"><!ENTITY b \"&a;&a;\">]><gpx/>", "no <!DOCTYPE>"),
        ("<gpx><name>&b;</name></gpx>", "&b; is unknown"),
        (&deep, "more than 64 deep"),
    ] {
        let error = gpx::read(text.as_bytes()).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }
    assert!(gpx::read(b"<gpx>\xFF\xFE</gpx>").unwrap_err().to_string().contains("from byte 5"));
    let many = format!("<gpx>{}</gpx>", "<wpt lat='1' lon='1'/>".repeat(geofile::MOST_POSITIONS + 1));
    assert!(gpx::read(many.as_bytes()).unwrap_err().to_string().contains("divide it"));
}

#[test]
fn hostile_geojson_is_refused_with_its_place() {
    let feature = |geometry: serde_json::Value| {
        json!({"type": "FeatureCollection", "features": [{"type": "Feature", "geometry": geometry}]})
            .to_string()
    };
    for (text, words) in [
        ("{".to_owned(), "not JSON"),
        ("[]".to_owned(), "without a type"),
        ("[".repeat(100_000), "not JSON"),
        (feature(json!({"type": "Polygon", "coordinates": []})), "feature 1: a \"Polygon\""),
        (feature(json!({"type": "Point", "coordinates": [10.4, 1e3]})), "feature 1: [10.4,1000.0]"),
        (feature(json!({"type": "Point", "coordinates": "x"})), "feature 1: \"x\""),
        (feature(json!({"type": "LineString", "coordinates": [[1, 2], [3]]})), "position 2: [3]"),
        (
            json!({"type": "Point", "coordinates": [1, 2], "crs": {"properties": {"name": "EPSG:32633"}}})
                .to_string(),
            "EPSG:32633",
        ),
    ] {
        let error = geojson::read(text.as_bytes()).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }
}

#[test]
fn collections_of_any_kind_are_read() {
    let multi = json!({"type": "GeometryCollection", "geometries": [
        {"type": "MultiPoint", "coordinates": [[1, 2], [3, 4, 5]]},
        {"type": "MultiLineString", "coordinates": [[[1, 2], [3, 4]]]},
    ]});
    let text = json!({"type": "FeatureCollection", "features": [
        {"type": "Feature", "geometry": multi, "properties": {"name": "m"}},
        {"type": "Feature", "geometry": null},
    ]});
    let read = geojson::read(text.to_string().as_bytes()).unwrap();
    assert_eq!(read.shapes.len(), 3);
    assert!(read.shapes.iter().all(|shape| shape.name == "m"));
    assert_eq!(read.notes, [LeftOut::NoGeometry("feature 2".to_owned())]);
}

fn positions() -> impl Strategy<Value = Position> {
    (-90.0..=90.0, -180.0..=180.0).prop_map(|(lat_deg, lon_deg)| at(lat_deg, lon_deg))
}

fn names() -> impl Strategy<Value = String> {
    "[ -~æøå<>&\"']{0,20}".prop_map(|name| name.trim().to_owned())
}

fn shapes() -> impl Strategy<Value = Shapes> {
    let geometry = prop_oneof![
        positions().prop_map(Geometry::Point),
        prop::collection::vec(positions(), 0..9).prop_map(Geometry::Line),
    ];
    let properties = prop::collection::btree_map("[a-m]{1,4}", any::<i32>(), 0..3)
        .prop_map(|map| map.into_iter().map(|(key, value)| (key, value.into())).collect::<Map<_, _>>());
    let shape = (names(), geometry, properties).prop_map(|(name, geometry, properties)| Shape {
        name,
        geometry,
        properties,
    });
    (names(), prop::collection::vec(shape, 0..8)).prop_map(|(name, shapes)| Shapes {
        name,
        shapes,
        ..Shapes::default()
    })
}

proptest! {
    #[test]
    fn geojson_comes_back_as_it_was(shapes in shapes()) {
        prop_assert_eq!(geojson::read(geojson::write(&shapes).as_bytes()).unwrap(), shapes);
    }

    #[test]
    fn gpx_gives_all_positions_back(shapes in shapes()) {
        let read = gpx::read(gpx::write(&shapes).as_bytes()).unwrap();
        let all = |shapes: &Shapes| -> Vec<(String, Position)> {
            shapes.shapes.iter().flat_map(|shape| match &shape.geometry {
                Geometry::Point(at) => vec![(shape.name.clone(), *at)],
                Geometry::Line(points) => points.iter().map(|at| (shape.name.clone(), *at)).collect(),
            }).collect()
        };
        prop_assert_eq!(all(&read), all(&shapes));
        prop_assert_eq!(read.name, shapes.name);
    }

    #[test]
    fn no_bytes_panic(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        let _ = (gpx::read(&bytes), geojson::read(&bytes));
    }
}
