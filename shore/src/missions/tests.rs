use super::rows::{Change, Create, List, One, Withdraw};
use super::summary::{Drawn, Way, distance_m};
use crate::identity::{Fault, Request as _, migrated};
use api::MissionRequest;
use sqlx::SqliteConnection;
use units::UtcTime;

fn mission(name: &str, from_us: i64, vessels: &[u16]) -> MissionRequest {
    MissionRequest { name: name.to_owned(), from_us, vessels: vessels.to_vec(), ..MissionRequest::default() }
}

async fn names(db: &mut SqliteConnection, list: List) -> Vec<String> {
    let found = List { count: 10, ..list }.run(db).await.unwrap();
    found.into_iter().map(|row| row.mission.name).collect()
}

#[tokio::test]
async fn missions_are_found_by_vessel_and_kept_when_changed_or_withdrawn() {
    let mut db = migrated().await;
    let db = &mut db;
    let mut ids = Vec::new();
    for one in [mission("spring", 10, &[5]), mission("both", 30, &[5, 6]), mission("autumn", 20, &[6])] {
        let create = Create { mission: one, by: "nils".to_owned(), now: UtcTime::from_micros(1) };
        ids.push(create.run(db).await.unwrap());
    }
    assert_eq!(names(db, List::default()).await, ["both", "autumn", "spring"]);
    assert_eq!(names(db, List { seen: Some(vec![5]), ..List::default() }).await, ["both", "spring"]);
    assert!(names(db, List { seen: Some(vec![]), ..List::default() }).await.is_empty());
    assert_eq!(names(db, List { before: Some((30, ids[1])), ..List::default() }).await, ["autumn", "spring"]);

    let change = |revision| Change {
        id: ids[0],
        revision,
        mission: MissionRequest { to_us: Some(40), ..mission("spring tide", 11, &[6]) },
        by: "anna".to_owned(),
        now: UtcTime::from_micros(2),
    };
    change(1).run(db).await.unwrap();
    let late = change(1).run(db).await.unwrap_err();
    assert!(matches!(&late, Fault::Refused(text) if text.contains("meanwhile")), "{late}");
    let row = One(ids[0]).run(db).await.unwrap().unwrap();
    assert_eq!((row.revision, &*row.mission.name, row.mission.to_us), (2, "spring tide", Some(40)));
    assert_eq!((row.changed, row.by), ((Some("anna".to_owned()), Some(2)), "nils".to_owned()));
    assert_eq!(names(db, List { seen: Some(vec![5]), ..List::default() }).await, ["both"]);
    let sql = "SELECT body, by FROM mission_before WHERE mission = ?1";
    let (body, by): (String, String) = sqlx::query_as(sql).bind(ids[0]).fetch_one(&mut *db).await.unwrap();
    let before: MissionRequest = serde_json::from_str(&body).unwrap();
    assert_eq!((&*before.name, &*by), ("spring", "nils"));

    let withdraw =
        |revision| Withdraw { id: ids[0], revision, by: "anna".to_owned(), now: UtcTime::from_micros(3) };
    withdraw(1).run(db).await.unwrap_err();
    withdraw(2).run(db).await.unwrap();
    change(2).run(db).await.unwrap_err();
    assert_eq!(names(db, List::default()).await, ["both", "autumn"]);
    assert_eq!(names(db, List { withdrawn: true, ..List::default() }).await.len(), 3);
}

#[test]
fn energy_is_what_flowed_while_it_was_reported() {
    let of = |samples: &[(i64, f64)]| store::Samples {
        time_us: samples.iter().map(|(second, _)| second * 1_000_000).collect(),
        values: vec![samples.iter().map(|(_, value)| *value).collect()],
        cut: false,
    };
    // Half a minute at 24 V and 10 A, half a minute at 24 V and 20 A; then an hour of silence, of which nothing is known.
    let (volts, amps) =
        (of(&[(0, 24.0), (3_660, 24.0)]), of(&[(0, 10.0), (30, 20.0), (60, 5.0), (3_660, 5.0)]));
    let mut whole = Drawn::default();
    whole.add(&volts, &amps, i64::MAX);
    assert!((whole.wh - 6.0).abs() < 1e-9, "{}", whole.wh);
    // Read in two parts it is the same.
    let mut parts = Drawn::default();
    parts.add(&volts, &amps, 31_000_000);
    parts.add(&of(&[(3_660, 24.0)]), &of(&[(60, 5.0), (3_660, 5.0)]), i64::MAX);
    assert!((parts.wh - 6.0).abs() < 1e-9, "{}", parts.wh);
    // A current without a voltage says nothing, and charging counts back.
    let mut unknown = Drawn::default();
    unknown.add(&of(&[]), &amps, i64::MAX);
    assert!(!unknown.any);
    let mut charging = Drawn::default();
    charging.add(&volts, &of(&[(0, -10.0), (60, 0.0)]), i64::MAX);
    assert!((charging.wh + 4.0).abs() < 1e-9, "{}", charging.wh);
}

#[test]
fn a_distance_is_that_of_the_ellipsoid() {
    // One minute of latitude by the radius of curvature of the meridian in its middle; within 1 cm.
    let minute = distance_m((63.425, 10.4), (63.425 + 1.0 / 60.0, 10.4));
    let e2 = units::WGS84_ECCENTRICITY_SQUARED;
    let middle = (63.425_f64 + 0.5 / 60.0).to_radians();
    let meridian_m = units::WGS84_SEMI_MAJOR_M * (1.0 - e2) / (1.0 - e2 * middle.sin().powi(2)).powf(1.5);
    assert!((minute - meridian_m * (1.0_f64 / 60.0).to_radians()).abs() < 0.01, "{minute}");
    assert!(distance_m((0.0, 179.999), (0.0, -179.999)) < 250.0, "over the date line");
}

#[test]
fn a_way_is_summed_by_the_second_and_gaps_are_no_recorded_time() {
    let mut way = Way::default();
    // North by 1e-5° each half second: every other position counts.
    for half in 0..=20_i64 {
        way.add(half * 500_000, (63.0 + half as f64 * 1e-5, 10.0));
    }
    way.add(10_400_000, (f64::NAN, 10.0));
    let straight_m = distance_m((63.0, 10.0), (63.000_2, 10.0));
    assert!((way.distance_m - straight_m).abs() < 1e-6, "{} {straight_m}", way.distance_m);
    assert_eq!((way.first_us, way.recorded_us), (Some(0), 10_000_000));
    // After a gap the straight distance counts, but not the time.
    way.add(110_000_000, (63.001_2, 10.0));
    assert!((way.distance_m - distance_m((63.0, 10.0), (63.001_2, 10.0))).abs() < 1e-3);
    assert_eq!((way.recorded_us, way.last.map(|last| last.0)), (10_000_000, Some(110_000_000)));
}
