use charts::depth_index::IndexBuilder;
use charts::s57::{Cell, NamedBytes};
use planner::{Cancel, Needs, Request, Router};
use std::sync::Arc;
use std::time::Instant;
use testkit::Numbers;
use units::LatLon;

fn main() {
    let mut args = std::env::args().skip(1);
    let name = args.next().unwrap();
    let depth: f64 = args.next().unwrap().parse().unwrap();
    let clearance: f64 = args.next().unwrap().parse().unwrap();
    let folder = testkit::shared("data/charts").unwrap();
    let read = |name: &str| std::fs::read(folder.join(name)).unwrap();
    let mut builder = IndexBuilder::new();
    for name in name.split(',') {
        let base = read(&format!("{name}.000"));
        let updates: Vec<(String, Vec<u8>)> = (1..9)
            .map(|n| format!("{name}.{n:03}"))
            .take_while(|file| folder.join(file).exists())
            .map(|file| (file.clone(), read(&file)))
            .collect();
        let updates: Vec<NamedBytes<'_>> =
            updates.iter().map(|(name, bytes)| NamedBytes { name, bytes }).collect();
        let file = format!("{name}.000");
        builder.add_cell(&Cell::read(NamedBytes { name: &file, bytes: &base }, &updates).unwrap()).unwrap();
    }
    let index = Arc::new(builder.build().unwrap());
    let extent = index.extent().unwrap();
    println!("{extent:?} {} vertices", index.vertex_count());
    let router = Router::new(Arc::clone(&index));
    let needs = Needs::depth_and_clearance(depth, clearance);
    let t = Instant::now();
    let room = planner::SeaRoom::of_chart(&index, &needs, &Cancel::never()).unwrap();
    println!("prepared {:?}, {} triangles", t.elapsed(), room.triangles());
    let mut numbers = Numbers(7);
    let mut place = || {
        LatLon::from_deg(
            numbers.within(extent.south_deg, extent.north_deg),
            numbers.within(extent.west_deg, extent.east_deg),
        )
        .unwrap()
    };
    let mut all = Vec::new();
    let (mut ok, mut no, mut bad) = (0, 0, 0);
    for n in 0..2000 {
        let (a, b) = (place(), place());
        let t = Instant::now();
        let answer = router.route(&Request::new(a, b), &needs, &Cancel::never());
        let us = t.elapsed().as_micros();
        match answer {
            Ok(route) => {
                ok += 1;
                if n > 0 {
                    all.push((us, route.length_m, route.legs.len(), route.effort.intervals));
                }
            }
            Err(planner::Refusal::NotConfirmed { at }) => {
                bad += 1;
                println!("NOT CONFIRMED {a:?} {b:?} {at}");
            }
            Err(other) => {
                if no < 5 {
                    println!("{other}");
                }
                no += 1
            }
        }
    }
    all.sort_by_key(|one| one.0);
    println!(
        "ok {ok} no {no} bad {bad}; p50 {:?} p99 {:?} max {:?}",
        all[all.len() / 2],
        all[all.len() * 99 / 100],
        all[all.len() - 1]
    );
}
