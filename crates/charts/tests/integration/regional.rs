//! An index whose pieces are read as they are needed answers as one that is held whole, and one that was brought up to
//! date chart by chart has the same bytes as one rebuilt.

use charts::coverage::Source;
use charts::demo;
use charts::depth_index::{
    BuildError, ChartToIndex, ChartTrust, Demand, DepthIndex, IndexBuilder, IndexBytes, Leg, Water, assemble,
};
use charts::s57::{Cell, NamedBytes};
use std::collections::BTreeSet;
use std::sync::{Arc, Mutex};
use testkit::Numbers;
use units::LatLon;

/// Overlapping bands, seams between cells, and waters far from each other.
const CELLS: [&str; 6] = ["GB4X0000", "GB5X01NE", "GB5X01NW", "GB5X01SE", "US4MD81M", "US5MD1MC"];
/// West, south, east and north of where questions are asked (degrees).
const WATERS: [[f64; 4]; 4] = [
    [60.76, -32.64, 61.34, -32.31],
    [60.85, -32.54, 61.01, -32.44],
    [-76.64, 38.90, -76.40, 39.06],
    [10.26, 63.42, 10.46, 63.49],
];

struct Set(Vec<(ChartToIndex, Cell)>);

impl Set {
    /// `None` without the shared cells.
    fn read() -> Option<Self> {
        let mut files: Vec<(String, Vec<u8>)> = Vec::new();
        for name in CELLS {
            let path = testkit::shared(&format!("data/charts/{name}.000"))?;
            files.push((format!("{name}.000"), std::fs::read(path).unwrap()));
        }
        files.extend(demo::archipelago().unwrap().into_iter().map(|file| (file.name.to_owned(), file.bytes)));
        let cell = |(number, (name, bytes)): (usize, &(String, Vec<u8>))| {
            let cell = Cell::read(NamedBytes { name, bytes }, &[]).unwrap();
            (to_index(&cell, number as u8), cell)
        };
        Some(Self(files.iter().enumerate().map(cell).collect()))
    }

    fn bytes(&self, before: Option<&DepthIndex>) -> Vec<u8> {
        let mut bytes = Vec::new();
        let charts = self.0.iter().map(|(chart, _)| chart.clone()).collect();
        let features = |source: &Source| {
            let (_, cell) = self.0.iter().find(|(chart, _)| chart.source == *source).unwrap();
            Ok::<_, BuildError>(cell.features.clone())
        };
        let put = |part: &[u8]| {
            bytes.extend_from_slice(part);
            Ok(())
        };
        assemble(charts, before, features, put).unwrap();
        bytes
    }

    fn held(&self) -> DepthIndex {
        let mut builder = IndexBuilder::new();
        for (chart, cell) in &self.0 {
            builder.add_features(chart.source.clone(), &cell.features).unwrap();
        }
        builder.build().unwrap()
    }
}

fn to_index(cell: &Cell, number: u8) -> ChartToIndex {
    let points = || cell.features.iter().flat_map(|feature| feature.geometry.points());
    let least = |value: fn(charts::s57::GeoPoint) -> f64| points().map(value).fold(f64::INFINITY, f64::min);
    let most =
        |value: fn(charts::s57::GeoPoint) -> f64| points().map(value).fold(f64::NEG_INFINITY, f64::max);
    let (west, east) = (least(|at| at.lon_deg), most(|at| at.lon_deg));
    let (south, north) = (least(|at| at.lat_deg), most(|at| at.lat_deg));
    let source = Source {
        name: cell.id.name.split('.').next().unwrap().to_owned(),
        edition: cell.id.edition.clone(),
        update: cell.id.update.clone(),
        issue_date: cell.id.issue_date.clone(),
        band: cell.id.band,
        scale: cell.parameters.scale,
        sounding_datum: cell.parameters.sounding_datum,
        supplement: false,
    };
    ChartToIndex { source, mark: [number; 32], bounds_deg: Some([west, south, east, north]) }
}

/// Notes which offsets were read.
#[derive(Debug)]
struct Noted(Vec<u8>, Mutex<BTreeSet<u64>>);

impl IndexBytes for Noted {
    fn length(&self) -> u64 {
        self.0.len() as u64
    }

    fn read(&self, offset: u64, length: usize) -> Result<Vec<u8>, String> {
        self.1.lock().unwrap().insert(offset);
        let from = offset as usize;
        self.0.get(from..from + length).map(<[u8]>::to_vec).ok_or_else(|| "it ends before".to_owned())
    }
}

fn open(bytes: Vec<u8>, most_bytes: usize) -> (DepthIndex, Arc<Noted>) {
    let noted = Arc::new(Noted(bytes, Mutex::default()));
    (DepthIndex::open(Arc::clone(&noted) as Arc<dyn IndexBytes>, 0, most_bytes).unwrap(), noted)
}

/// Thousands of questions all over the waters, the same for both, and the same answers to the last bit.
fn agree(one: &DepthIndex, other: &DepthIndex, count: usize) {
    let mut numbers = Numbers(5);
    let (mut deep, mut shallow) = (0, 0);
    let demands = [
        Demand::least_depth(3.0),
        Demand { trust: ChartTrust::AllErrors(ChartTrust::STANDARD), ..Demand::least_depth(2.0) },
        Demand { air_draught_m: Some(10.0), position_m: 5.0, ..Demand::least_depth(5.0) },
    ];
    for round in 0..count {
        let [west, south, east, north] = WATERS[round % WATERS.len()];
        let mut place =
            || LatLon::from_deg(numbers.within(south, north), numbers.within(west, east)).unwrap();
        let (from, to) = (place(), place());
        let near = |part: f64| from.lat_deg() + part * (to.lat_deg() - from.lat_deg());
        let east_of = |part: f64| from.lon_deg() + part * (to.lon_deg() - from.lon_deg());
        // Legs of some hundred metres, and each tenth from end to end.
        let part = if round % 10 == 0 { 1.0 } else { 0.02 };
        let leg = Leg { from, to: LatLon::from_deg(near(part), east_of(part)).unwrap() };
        let demand = &demands[round % demands.len()];
        let worst = one.shallowest_along(leg, 20.0, demand);
        deep += usize::from(worst.navigable);
        shallow += usize::from(!worst.navigable);
        assert_eq!(worst, other.shallowest_along(leg, 20.0, demand), "{leg:?}");
        let named = |index: &DepthIndex, object: Option<u32>| {
            let object = index.object(object?)?;
            Some((index.source(&object).clone(), object))
        };
        assert_eq!(named(one, worst.object), named(other, worst.object), "{leg:?}");
        assert_eq!(one.depth_at(from, demand), other.depth_at(from, demand), "{from:?}");
        assert_eq!(one.first_danger_along(leg, 20.0, demand), other.first_danger_along(leg, 20.0, demand));
        assert_eq!(one.distance_to_shallower(from, 4.0, 3e3), other.distance_to_shallower(from, 4.0, 3e3));
        let interest = |index: &DepthIndex| index.points_of_interest(from, 5, 2e3, |_| true);
        assert_eq!(interest(one), interest(other), "{from:?}");
    }
    assert!(deep > count / 20 && shallow > count / 20, "{deep} deep, {shallow} shallow");
}

#[test]
fn pieces_read_as_they_are_needed_answer_as_the_whole() {
    let Some(set) = Set::read() else { return };
    let bytes = set.bytes(None);
    let whole = set.held();
    assert!(DepthIndex::from_bytes(&bytes).unwrap() == whole);
    // So little is kept that nearly each question reads its pieces again.
    let (regional, _) = open(bytes.clone(), 1);
    agree(&regional, &whole, testkit::so_many(100, 300));
    let (regional, _) = open(bytes, 64 << 20);
    agree(&regional, &whole, testkit::so_many(2_000, 60_000));
}

#[test]
fn a_question_reads_the_charts_that_it_touches_and_no_others() {
    let Some(set) = Set::read() else { return };
    let (index, noted) = open(set.bytes(None), 64 << 20);
    let directory = noted.1.lock().unwrap().len();
    let harbour = LatLon::from_deg(63.446, 10.345).unwrap();
    assert!(index.depth_at(harbour, &Demand::default()).water.least_m().is_some());
    // The archipelago has two charts, of which the better one answers.
    assert_eq!(noted.1.lock().unwrap().len(), directory + 1);
    let nowhere = LatLon::from_deg(50.0, 0.0).unwrap();
    assert_eq!(index.depth_at(nowhere, &Demand::default()).water, Water::NoData);
    assert_eq!(noted.1.lock().unwrap().len(), directory + 1);
}

#[test]
fn an_index_brought_up_to_date_has_the_bytes_of_one_made_anew() {
    let Some(whole) = Set::read() else { return };
    let bytes = whole.bytes(None);
    let before = DepthIndex::from_bytes(&bytes).unwrap();
    for changed in (0..whole.0.len()).step_by(testkit::so_many(5, 1)) {
        let mut set = Set(whole.0.clone());
        let (chart, cell) = set.0.remove(changed);
        let without = set.bytes(Some(&before));
        assert!(without == set.bytes(None), "without {}", chart.source.name);
        // It comes back as another edition, without one of its dangers.
        let mut cell = cell;
        cell.features.retain(|feature| feature.record % 7 != 0 || feature.class.acronym() != Some("SOUNDG"));
        set.0.push((ChartToIndex { mark: [99; 32], ..chart.clone() }, cell));
        let (left, _) = open(without, 1 << 20);
        let renewed = set.bytes(Some(&left));
        assert!(renewed == set.bytes(None), "with another {}", chart.source.name);
        assert!(renewed == set.bytes(Some(&before)), "in the place of {}", chart.source.name);
    }
    assert!(whole.bytes(Some(&before)) == bytes);
}

#[test]
fn a_chart_that_cannot_be_read_is_no_water_and_no_neighbour() {
    let Some(set) = Set::read() else { return };
    let mut bytes = set.bytes(None);
    let (index, noted) = open(bytes.clone(), 64 << 20);
    let harbour = LatLon::from_deg(63.446, 10.345).unwrap();
    let opened = noted.1.lock().unwrap().clone();
    index.depth_at(harbour, &Demand::default());
    let piece = *noted.1.lock().unwrap().difference(&opened).next().unwrap();
    bytes[piece as usize + 1_000] ^= 4;
    assert!(DepthIndex::from_bytes(&bytes).is_err());

    let (damaged, _) = open(bytes, 64 << 20);
    let answer = damaged.depth_at(harbour, &Demand::default());
    assert_eq!((answer.water, answer.navigable), (Water::UnknownDepth, false));
    let object = damaged.object(answer.object.unwrap()).unwrap();
    assert_eq!(object.name.as_deref(), Some("the chart XX5LUTRA cannot be read"));
    let near = Leg { from: harbour, to: LatLon::from_deg(63.45, 10.36).unwrap() };
    assert!(!damaged.shallowest_along(near, 5.0, &Demand::default()).navigable);
    assert_eq!(damaged.unreadable().len(), 1);
    assert!(damaged.unreadable()[0].starts_with("XX5LUTRA: the depth index is damaged at byte"));
    // What is made of it is made of the charts.
    assert!(set.bytes(Some(&damaged)) == set.bytes(None));
}
