//! How fast cells are read and depth queries are answered on one core. `cargo bench -p charts` runs this on the
//! shared cells; without them it says so and measures nothing.

#![expect(missing_docs, reason = "criterion's macros make public functions without any")]

use charts::depth_index::{Demand, DepthIndex, IndexBuilder, Leg};
use charts::s57::{Cell, NamedBytes};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use std::hint::black_box;
use units::{LatLon, LocalFrame, LocalPoint};

const CELLS: [(&str, u32); 9] = [
    ("US4MD81M", 3),
    ("US5WA22M", 4),
    ("US5MD1MC", 0),
    ("US1BS01M", 0),
    ("GB4X0000", 0),
    ("GB5X01NE", 0),
    ("GB5X01NW", 0),
    ("GB5X01SE", 0),
    ("GB5X02SE", 0),
];

struct CellFiles {
    name: &'static str,
    files: Vec<(String, Vec<u8>)>,
}

fn shared_cells() -> Option<Vec<CellFiles>> {
    let files = |name: &str, updates: u32| -> Option<Vec<(String, Vec<u8>)>> {
        let file = |number: u32| {
            let name = format!("{name}.{number:03}");
            let path = testkit::shared(&format!("data/charts/{name}"))?;
            Some((name, std::fs::read(path).expect("the cell can be read")))
        };
        (0..=updates).map(file).collect()
    };
    CELLS.iter().map(|(name, updates)| Some(CellFiles { name, files: files(name, *updates)? })).collect()
}

fn read(cell: &CellFiles) -> Cell {
    let named: Vec<NamedBytes<'_>> =
        cell.files.iter().map(|(name, bytes)| NamedBytes { name, bytes }).collect();
    Cell::read(named[0], &named[1..]).expect("the cell is whole")
}

fn index(cells: &[Cell]) -> DepthIndex {
    let mut builder = IndexBuilder::new();
    for cell in cells {
        builder.add_cell(cell).expect("positions are on the globe");
    }
    builder.build().expect("it is not too large")
}

/// Numbers in [0, 1) that are the same in every run.
fn numbers() -> impl FnMut() -> f64 {
    let mut state = 0x2545_F491_4F6C_DD1D_u64;
    move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// Places in the waters of Tacoma, the finest of the shared cells.
fn places(count: usize) -> Vec<LatLon> {
    let mut next = numbers();
    let mut place = || LatLon::from_deg(47.231 + 0.094 * next(), -122.552 + 0.198 * next());
    (0..count).map(|_| place().expect("in range")).collect()
}

fn legs(index: &DepthIndex, length_m: f64, afloat: bool) -> Vec<Leg> {
    let mut next = numbers();
    let deep = Demand::least_depth(1.0);
    let leg = |from: LatLon| {
        let way = LocalPoint::default().displaced(std::f64::consts::TAU * next(), length_m);
        Leg { from, to: LocalFrame::new(from).to_place(way) }
    };
    let all = places(40_000).into_iter().map(leg);
    all.filter(|leg| !afloat || index.shallowest_along(*leg, 25.0, &deep).navigable).take(1000).collect()
}

fn bench_reading(criterion: &mut Criterion, cells: &[CellFiles]) {
    let mut group = criterion.benchmark_group("read");
    group.sample_size(20);
    for cell in cells.iter().take(5) {
        group.throughput(Throughput::Bytes(cell.files.iter().map(|(_, bytes)| bytes.len() as u64).sum()));
        group.bench_function(cell.name, |bencher| bencher.iter(|| black_box(read(cell))));
    }
    group.finish();
}

fn bench_index(criterion: &mut Criterion, cells: &[Cell]) -> DepthIndex {
    let built = index(cells);
    let bytes = built.to_bytes();
    println!("index of {} cells: {} vertices, {} bytes", cells.len(), built.vertex_count(), bytes.len());
    let mut group = criterion.benchmark_group("index");
    group.sample_size(10);
    group.bench_function("build, all shared cells", |bencher| bencher.iter(|| black_box(index(cells))));
    group.bench_function("load from bytes, all shared cells", |bencher| {
        bencher.iter(|| DepthIndex::from_bytes(black_box(&bytes)).expect("it was written"));
    });
    group.finish();
    built
}

fn bench_questions(criterion: &mut Criterion, index: &DepthIndex) {
    let demand = Demand::least_depth(1.0);
    let places = places(10_000);
    let mut group = criterion.benchmark_group("ask");
    group.throughput(Throughput::Elements(places.len() as u64));
    group.bench_function("depth_at x10000", |bencher| {
        bencher.iter(|| places.iter().filter(|place| index.depth_at(**place, &demand).navigable).count());
    });
    group.throughput(Throughput::Elements(1000));
    for (name, afloat) in [("anywhere", false), ("afloat", true)] {
        let legs = legs(index, 1000.0, afloat);
        assert_eq!(legs.len(), 1000);
        group.bench_function(format!("shallowest_along 1 km, 25 m, {name} x1000"), |bencher| {
            bencher.iter(|| {
                legs.iter().filter(|leg| index.shallowest_along(**leg, 25.0, &demand).navigable).count()
            });
        });
        group.bench_function(format!("first_danger_along 1 km, 25 m, {name} x1000"), |bencher| {
            bencher.iter(|| {
                legs.iter().filter(|leg| index.first_danger_along(**leg, 25.0, &demand).is_some()).count()
            });
        });
    }
    group.bench_function("distance_to_shallower 1 m x1000", |bencher| {
        bencher.iter(|| {
            let near = |place: &&LatLon| index.distance_to_shallower(**place, 1.0, 5000.0).is_some();
            places.iter().take(1000).filter(near).count()
        });
    });
    group.finish();
}

fn bench(criterion: &mut Criterion) {
    let Some(files) = shared_cells() else { return };
    bench_reading(criterion, &files);
    let cells: Vec<Cell> = files.iter().map(read).collect();
    let index = bench_index(criterion, &cells);
    bench_questions(criterion, &index);
}

criterion_group! {
    name = benches;
    config = Criterion::default().without_plots();
    targets = bench
}
criterion_main!(benches);
