//! How fast a plan is checked against the chart on one core. `cargo bench -p mission` runs this on the shared
//! cell US5WA22M; without it, on a made-up sea.

#![expect(missing_docs, reason = "criterion's macros make public functions without any")]

use charts::depth_index::{DepthIndex, IndexBuilder};
use charts::s57::{Cell, NamedBytes};
use criterion::{Criterion, criterion_group, criterion_main};
use guard::GuardLimits;
use mission::{
    DraftBody, Goto, Maneuver, ManeuverDraft, Plan, PlanDraft, PlanLimits, TransitionDraft, check_plan,
};
use std::hint::black_box;
use testkit::sea::{Ground, Sea};
use units::{LatLon, LocalFrame, LocalPoint, Speed};

fn shared() -> Option<DepthIndex> {
    let files: Vec<(String, Vec<u8>)> = (0..=4)
        .map(|update| {
            let name = format!("US5WA22M.{update:03}");
            let path = testkit::shared(&format!("data/charts/{name}"))?;
            Some((name, std::fs::read(path).expect("the cell can be read")))
        })
        .collect::<Option<_>>()?;
    let named: Vec<NamedBytes<'_>> = files.iter().map(|(name, bytes)| NamedBytes { name, bytes }).collect();
    let cell = Cell::read(named[0], &named[1..]).expect("the cell is whole");
    let mut builder = IndexBuilder::new();
    builder.add_cell(&cell).expect("positions are on the globe");
    Some(builder.build().expect("it is not too large"))
}

fn made(middle: LatLon) -> DepthIndex {
    let mut sea = Sea::new(middle, 5000.0, 30.0);
    for n in 0..500_u32 {
        let at = LocalPoint::default().displaced(f64::from(n), 8.0 * f64::from(n) + 300.0);
        sea = sea.with(Ground::Depth(f64::from(n % 7)), at, 30.0, 40);
    }
    sea.index()
}

/// A hundred legs of 500 m to and fro.
fn plan(middle: LatLon) -> Plan {
    let frame = LocalFrame::new(middle);
    let id = |n: u32| format!("m{n}");
    let goto = |n: u32| {
        let at = LocalPoint { north_m: f64::from(n % 2) * 500.0, east_m: f64::from(n) * 10.0 - 500.0 };
        let speed = Speed::MetresPerSecond(1.5);
        let body = DraftBody::Maneuver(Maneuver::Goto(Goto { target: frame.to_place(at).into(), speed }));
        ManeuverDraft { id: id(n), depth_m: None, body }
    };
    let draft = PlanDraft {
        id: "bench".to_owned(),
        start: id(0),
        maneuvers: (0..100).map(goto).collect(),
        transitions: (1..100).map(|n| TransitionDraft { from: id(n - 1), to: id(n) }).collect(),
        notes: Vec::new(),
    };
    Plan::build(&draft, &PlanLimits::default()).expect("the plan is good")
}

fn guard(c: &mut Criterion) {
    // Commencement Bay.
    let middle = LatLon::from_deg(47.287, -122.45).expect("a place");
    let index = shared().unwrap_or_else(|| made(middle));
    let (plan, limits) = (plan(middle), GuardLimits::default());
    c.bench_function("check_plan, 100 legs of 500 m", |bench| {
        bench.iter(|| black_box(check_plan(black_box(&plan), Some(middle), &index, &limits)));
    });
}

criterion_group!(benches, guard);
criterion_main!(benches);
