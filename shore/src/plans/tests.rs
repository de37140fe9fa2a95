//! Conversion of plans in both directions, and errors of bad ones.

use super::translate::{document, specification};
use super::{
    Change, Create, Delete, Format, List, Load, Restore, Revisions, Save, check, limits, read, write,
};
use crate::identity::{Fault, Request as _, migrated};
use api::{PlanDocument, PlanPlace, PlanSpeed, PlanStep, PlanTask, SpeedUnit};
use imc::messages::{
    Heartbeat, LoiterType, Message, PlanManeuver, PlanSpecification, PlanTransition, PowerChannelControl,
};
use imc::plan_digest::plan_md5;
use proptest::prelude::*;
use sqlx::SqliteConnection;
use units::UtcTime;

const NOW: UtcTime = UtcTime::from_micros(1_772_368_496_000_000);

fn place(lat_deg: f64, lon_deg: f64) -> PlanPlace {
    PlanPlace { lat_deg, lon_deg }
}

fn step(id: &str, task: PlanTask) -> PlanStep {
    PlanStep { id: id.to_owned(), speed: PlanSpeed { value: 1.5, unit: SpeedUnit::Mps }, task }
}

fn goto(id: &str, lat_deg: f64, lon_deg: f64) -> PlanStep {
    step(id, PlanTask::Goto { at: place(lat_deg, lon_deg) })
}

fn plan(name: &str, maneuvers: Vec<PlanStep>) -> PlanDocument {
    PlanDocument { name: name.to_owned(), maneuvers, ..PlanDocument::default() }
}

/// Two places about 1113 m apart.
fn north() -> PlanDocument {
    plan("north", vec![goto("a", 63.44, 10.40), goto("b", 63.45, 10.40)])
}

fn places() -> impl Strategy<Value = PlanPlace> {
    // With decimals as people type them, and near enough to each other for a path.
    (-800_000..800_000_i32, -900_000..900_000_i32)
        .prop_map(|(lat, lon)| place(63.0 + f64::from(lat) / 1e7, 10.0 + f64::from(lon) / 1e7))
}

fn tasks() -> impl Strategy<Value = PlanTask> {
    let metres = || (1..40_000_u32).prop_map(|tenths| f64::from(tenths) / 10.0);
    let degrees = || (0..3_600_u32).prop_map(|tenths| f64::from(tenths) / 10.0);
    prop_oneof![
        places().prop_map(|at| PlanTask::Goto { at }),
        prop::collection::vec(places(), 1..20).prop_map(|points| PlanTask::FollowPath { points }),
        (places(), metres(), any::<u16>()).prop_map(|(at, radius_m, duration_s)| PlanTask::StationKeeping {
            at,
            radius_m,
            duration_s
        }),
        (places(), metres(), any::<u16>(), any::<bool>()).prop_map(
            |(at, radius_m, duration_s, clockwise)| {
                PlanTask::Loiter { at, radius_m, duration_s, clockwise }
            }
        ),
        (places(), degrees(), metres(), metres(), any::<u8>(), 0..=100_u8, any::<[bool; 2]>()).prop_map(
            |(at, bearing_deg, width_m, length_m, curve_offset_m, alternation_percent, [square, right])| {
                PlanTask::Rows {
                    at,
                    bearing_deg,
                    cross_angle_deg: bearing_deg / 20.0,
                    width_m,
                    length_m,
                    step_m: width_m / 8.0,
                    curve_offset_m,
                    alternation_percent,
                    square_curve: square,
                    curve_right: right,
                }
            }
        ),
    ]
}

fn plans() -> impl Strategy<Value = PlanDocument> {
    let speed = prop_oneof![
        (1..30_u32).prop_map(|tenths| PlanSpeed { value: f64::from(tenths) / 10.0, unit: SpeedUnit::Mps }),
        (1..980_u32).prop_map(|rpm| PlanSpeed { value: f64::from(rpm), unit: SpeedUnit::Rpm }),
        (1..100_u32).prop_map(|part| PlanSpeed { value: f64::from(part), unit: SpeedUnit::Percent }),
    ];
    let steps = prop::collection::vec((speed, tasks()), 1..9);
    ("[a-zæ<&\" ]{0,9}[a-z]", "[ -~]{0,20}", any::<bool>(), steps).prop_map(
        |(name, description, repeat, steps)| PlanDocument {
            name: name.trim().to_owned(),
            description,
            vessel: None,
            repeat,
            maneuvers: steps
                .into_iter()
                .zip(1..)
                .map(|((speed, task), number)| PlanStep { id: format!("m<{number}>"), speed, task })
                .collect(),
        },
    )
}

proptest! {
    #[test]
    fn a_plan_comes_back_from_imc_with_the_same_bytes(plan in plans()) {
        let aboard = specification(&plan).unwrap();
        let (back, notes) = document(&aboard).unwrap();
        prop_assert!(notes.is_empty());
        let again = specification(&back).unwrap();
        prop_assert_eq!(plan_md5(&again).unwrap(), plan_md5(&aboard).unwrap());
        prop_assert_eq!((&back.name, &back.description, back.repeat), (&plan.name, &plan.description, plan.repeat));
    }

    #[test]
    fn a_plan_comes_back_from_its_files(plan in plans()) {
        let digest = plan_md5(&specification(&plan).unwrap()).unwrap();
        let (back, notes) = read(write(&plan, Format::GeoJson).unwrap().as_bytes(), "x.geojson").unwrap();
        prop_assert_eq!(&back, &plan);
        prop_assert!(notes.is_empty());
        let (back, _) = read(write(&plan, Format::Imc).unwrap().as_bytes(), "x.json").unwrap();
        prop_assert_eq!(plan_md5(&specification(&back).unwrap()).unwrap(), digest);
        let (back, _) = read(write(&plan, Format::Gpx).unwrap().as_bytes(), "x.gpx").unwrap();
        let all = |plan: &PlanDocument| -> Vec<PlanPlace> {
            plan.maneuvers.iter().flat_map(|step| super::check::places(&step.task).to_vec()).collect()
        };
        prop_assert_eq!(all(&back), all(&plan));
        prop_assert!(limits(&back).is_ok());
    }

    #[test]
    fn what_is_drawn_is_judged_and_never_panics(plan in plans(), lat_deg in any::<f64>(), value in any::<f64>()) {
        let good = check(&plan, NOW);
        prop_assert!(good.problems.is_empty() == good.digest.is_some());
        let mut bad = plan;
        bad.maneuvers[0].task = PlanTask::Goto { at: place(lat_deg, value) };
        bad.maneuvers[0].speed.value = value;
        check(&bad, NOW);
    }
}

#[test]
fn a_plan_takes_what_its_way_takes() {
    let check = check(&north(), NOW);
    assert_eq!((check.problems, check.warnings), (vec![], vec![]));
    let (length_m, duration_s) = (check.total.length_m.unwrap(), check.total.duration_s.unwrap());
    // A hundredth of a degree of latitude at 63°, by the WGS-84 meridian radius 6 386 km: 1114.6 m.
    assert!((length_m - 1_114.6).abs() < 1.0, "{length_m}");
    assert!((duration_s - length_m / 1.5).abs() < 0.1, "{duration_s}");
    assert!(check.total.energy_j.unwrap() > 0.0);
    assert_eq!(check.maneuvers[1].places, [place(63.45, 10.40)]);
    assert_eq!(check.digest.unwrap().len(), 32);
}

#[test]
fn a_round_counts_the_way_back_and_is_no_warning() {
    let round = PlanDocument { repeat: true, ..north() };
    let check = check(&round, NOW);
    assert_eq!(check.warnings, []);
    assert!((check.total.length_m.unwrap() - 2.0 * 1_114.6).abs() < 2.0, "{:?}", check.total);
}

#[test]
fn what_goes_on_until_stopped_has_no_duration() {
    let station = PlanTask::StationKeeping { at: place(63.44, 10.40), radius_m: 10.0, duration_s: 0 };
    let check = check(&plan("wait", vec![step("s", station)]), NOW);
    assert_eq!((check.problems.len(), check.total.duration_s), (0, None));
}

#[test]
fn problems_come_by_maneuver_with_the_remedy() {
    let mut bad = north();
    bad.maneuvers[1].speed.value = 9.0;
    bad.maneuvers.push(goto("c", 91.0, 10.0));
    bad.maneuvers.push(goto("d", 0.0, 0.0));
    let problems = check(&bad, NOW).problems;
    let of =
        |id: &str| problems.iter().find(|one| one.maneuver.as_deref() == Some(id)).unwrap().text.as_str();
    assert_eq!(of("b"), "a speed of 9 m/s is not possible; above 0 and up to 3.09 m/s, 980 rpm or 100 % are");
    let b = problems.iter().find(|one| one.maneuver.as_deref() == Some("b")).unwrap();
    assert_eq!((&*b.code, b.values["rpm"]), ("speed", 980.0));
    assert!(of("c").contains("latitude") && of("d").contains("0, 0"), "{problems:?}");
    let empty = check(&plan("p", vec![step("x", PlanTask::FollowPath { points: vec![] })]), NOW).problems;
    assert_eq!(empty[0].text, "a path needs at least one point");
    assert_eq!(check(&plan("p", vec![]), NOW).problems[0].text, "the plan has no maneuvers yet");
    let long = step("x", PlanTask::FollowPath { points: vec![place(63.0, 10.0); 5_000] });
    assert!(check(&plan("p", vec![long]), NOW).problems[0].text.contains("too long for one message"));
}

#[test]
fn rows_beyond_count_are_a_problem_and_not_laid_out() {
    let rows = |width_m: f64, step_m: f64| PlanTask::Rows {
        at: place(63.44, 10.40),
        bearing_deg: 0.0,
        cross_angle_deg: 0.0,
        width_m,
        length_m: 10.0,
        step_m,
        curve_offset_m: 0,
        alternation_percent: 100,
        square_curve: false,
        curve_right: true,
    };
    let many = (0..400).map(|number| step(&format!("r{number}"), rows(1_000.0, 1.0))).collect();
    assert!(check(&plan("p", many), NOW).problems[0].text.contains("more than 50000 points together"));
    let endless = check(&plan("p", vec![step("r", rows(10.0, 0.0))]), NOW);
    assert!(endless.problems[0].text.contains("points"), "{:?}", endless.problems);
    assert!(!check(&plan("p", vec![step("r", rows(0.0, 0.0))]), NOW).problems.is_empty());
    assert!(check(&plan("p", vec![step("r", rows(100.0, 10.0))]), NOW).maneuvers[0].places.len() > 20);
}

#[test]
fn what_cannot_be_kept_is_refused() {
    for (plan, words) in [
        (plan("", vec![]), "name has 1 to 60"),
        (plan(" a", vec![]), "blanks"),
        (plan("a\nb", vec![]), "name has"),
        (plan(&"æ".repeat(31), vec![]), "60 bytes"),
        (plan("a", vec![goto("", 1.0, 1.0)]), "maneuver's name"),
        (plan("a", vec![goto("x", 1.0, 1.0); 501]), "500 are the most"),
        (PlanDocument { vessel: Some(0xFFFF), ..plan("a", vec![]) }, "vessel's address"),
        (
            plan("a", vec![step("x", PlanTask::FollowPath { points: vec![place(1.0, 1.0); 5_001] })]),
            "5000 are",
        ),
    ] {
        assert!(limits(&plan).unwrap_err().contains(words), "{words}");
    }
}

fn foreign(nodes: Vec<(&str, Message)>, ways: &[(&str, &str)]) -> PlanSpecification {
    PlanSpecification {
        plan_id: "x".into(),
        start_man_id: nodes.first().map_or("", |(id, _)| id).into(),
        maneuvers: nodes
            .into_iter()
            .map(|(id, data)| PlanManeuver {
                maneuver_id: id.into(),
                data: data.into(),
                ..PlanManeuver::default()
            })
            .collect(),
        transitions: ways
            .iter()
            .map(|(from, to)| PlanTransition {
                source_man: (*from).into(),
                dest_man: (*to).into(),
                ..PlanTransition::default()
            })
            .collect(),
        ..PlanSpecification::default()
    }
}

#[test]
fn foreign_plans_are_taken_in_the_order_they_are_sailed_or_refused() {
    let go = || Message::from(imc::messages::Goto { lat: 1.1, lon: 0.2, speed: 1.5, ..Default::default() });
    let three = |ways: &[(&str, &str)]| document(&foreign(vec![("a", go()), ("b", go()), ("c", go())], ways));
    let (plan, notes) = three(&[("a", "c"), ("a", "b"), ("c", "_done_")]).unwrap();
    let ids: Vec<&str> = plan.maneuvers.iter().map(|step| step.id.as_str()).collect();
    assert_eq!((ids, plan.repeat), (vec!["a", "c"], false));
    assert_eq!(notes, ["b: never reached in the plan, left out"]);
    assert!(three(&[("a", "b"), ("b", "c"), ("c", "a")]).unwrap().0.repeat);
    assert!(three(&[("a", "b"), ("b", "c"), ("c", "b")]).unwrap_err()[0].contains("goes back to 'b'"));
    assert!(three(&[("a", "z")]).unwrap_err()[0].contains("'z', which does not exist"));

    let one = |data: Message| document(&foreign(vec![("a", data)], &[])).unwrap_err().remove(0);
    assert!(one(Heartbeat.into()).contains("a Heartbeat is not edited here"));
    let eight = imc::messages::Loiter { r#type: LoiterType::Eight, ..Default::default() };
    assert!(one(eight.into()).contains("other than a circle"));
    let nan = imc::messages::Goto { lat: f64::NAN, ..Default::default() };
    assert!(one(nan.into()).contains("latitude"));
    let nan = imc::messages::Goto { speed: f32::INFINITY, ..Default::default() };
    assert!(one(nan.into()).contains("not a number"));
    let acts = PlanSpecification {
        start_actions: [Message::from(PowerChannelControl::default())].into_iter().collect(),
        ..foreign(vec![("a", go())], &[])
    };
    assert!(document(&acts).unwrap_err()[0].contains("has actions"));
}

#[test]
fn files_that_are_no_plans_are_refused_with_their_place() {
    for (text, words) in [
        ("", "neither GPX nor GeoJSON"),
        ("PK\u{3}", "neither GPX nor GeoJSON"),
        ("<kml/>", "<kml> in place of <gpx>"),
        ("<gpx/>", "no points or lines"),
        ("{", "not JSON"),
        (r#"{"abbrev":"Heartbeat"}"#, "a Heartbeat, not a PlanSpecification"),
        (r#"{"abbrev":"PlanSpecification","fields":{"plan_id":7}}"#, "fields.plan_id"),
        (r#"{"type":"Feature","geometry":{"type":"Polygon"}}"#, "Polygon"),
        (
            r#"{"type":"Feature","properties":{"kind":"loiter"},"geometry":{"type":"Point","coordinates":[1,2]}}"#,
            "feature 1: missing field `radius_m`",
        ),
        (
            r#"{"type":"Feature","properties":{"kind":"goto"},"geometry":{"type":"LineString","coordinates":[]}}"#,
            "feature 1: unknown field `points`",
        ),
    ] {
        let error = read(text.as_bytes(), "f").unwrap_err();
        assert!(error.contains(words), "{error}");
    }
}

#[test]
fn foreign_files_get_names_and_a_speed() {
    let gpx = "<gpx><rte><rtept lat='63' lon='10'><name>x</name></rtept><rtept lat='63.1' lon='10'>\
               <name>x</name></rtept><rtept lat='63.2' lon='10'/></rte></gpx>";
    let (plan, _) = read(gpx.as_bytes(), "evening tour.gpx").unwrap();
    let ids: Vec<&str> = plan.maneuvers.iter().map(|step| step.id.as_str()).collect();
    assert_eq!((plan.name.as_str(), ids), ("evening tour", vec!["x", "x (2)", "Goto 3"]));
    assert_eq!(check(&plan, NOW).problems, []);
}

fn by(author: &str, draft: bool) -> Change {
    Change { author: author.to_owned(), now: NOW, draft }
}

fn create(plan: PlanDocument, change: Change) -> Create {
    Create { plan, change }
}

fn save(id: i64, from: u32, plan: PlanDocument, change: Change) -> Save {
    Save { id, from, plan, change }
}

#[tokio::test]
async fn two_people_do_not_overwrite_each_other() {
    let db = &mut migrated().await;
    let id = create(north(), by("nils", true)).run(db).await.unwrap();
    save(id, 1, north(), by("nils", false)).run(db).await.unwrap();
    let refused = save(id, 1, north(), by("eva", true)).run(db).await.unwrap_err();
    assert!(matches!(&refused, Fault::Refused(text) if text.contains("nils changed the plan")), "{refused}");
    save(id, 2, plan("other", vec![]), by("eva", true)).run(db).await.unwrap();
    let row = Load { id, revision: None }.run(db).await.unwrap().unwrap();
    assert_eq!((row.revision, row.author.as_str(), row.plan.name.as_str()), (3, "eva", "other"));
    let before = Load { id, revision: Some(1) }.run(db).await.unwrap().unwrap();
    assert_eq!(before.plan, north(), "what was there before is kept");
}

#[tokio::test]
async fn drafts_of_one_person_are_one_revision() {
    let db = &mut migrated().await;
    let id = create(north(), by("nils", false)).run(db).await.unwrap();
    for from in 1..5 {
        save(id, from, north(), by("nils", true)).run(db).await.unwrap();
    }
    let kept = Revisions(id).run(db).await.unwrap();
    let kept: Vec<(u32, bool)> = kept.into_iter().map(|one| (one.revision, one.draft)).collect();
    assert_eq!(kept, [(5, true), (1, false)]);
}

async fn names(db: &mut SqliteConnection) -> Vec<String> {
    List.run(db).await.unwrap().into_iter().map(|row| row.plan.name).collect()
}

#[tokio::test]
async fn names_are_unique_and_a_deleted_plan_comes_back() {
    let db = &mut migrated().await;
    let first = create(north(), by("nils", true)).run(db).await.unwrap();
    let capitals = PlanDocument { name: "NORTH".to_owned(), ..north() };
    let second = create(capitals, by("nils", true)).run(db).await.unwrap();
    assert_eq!(names(db).await, ["north", "NORTH (2)"]);
    let taken = save(second, 1, plan("North", vec![]), by("nils", true)).run(db).await.unwrap_err();
    assert!(taken.to_string().contains("Another plan is called North"));
    Delete { id: first, now: NOW }.run(db).await.unwrap();
    assert!(Delete { id: first, now: NOW }.run(db).await.is_err());
    assert!(save(first, 1, north(), by("nils", true)).run(db).await.is_err());
    save(second, 1, plan("north", vec![]), by("nils", true)).run(db).await.unwrap();
    Restore { id: first, change: by("nils", false) }.run(db).await.unwrap();
    assert!(Restore { id: first, change: by("nils", false) }.run(db).await.is_err());
    assert_eq!(names(db).await, ["north", "north (2)"]);
}
