use super::{Question, Ranks, Sightings, SightingsBuilder, ranks, summary};
use crate::{Lag, Lags, Narrowed, Study};
use api::{DetectionsSummary, FlagCode, RegisterAnimal, RegisterProject, RegisterRecord, RegisterTag};
use detections::{ClockState, Detection, Effort, Listening, Origin, Pose, Protocol, ReceiverClock, fused};
use imc::Address;
use std::collections::BTreeSet;
use std::time::Instant;
use units::{LatLon, UtcTime};

/// 2026-11-21 08:00 UTC.
const START_S: u32 = 1_795_248_000;

fn heard(tag_id: u32, after_s: u32, vessel: u16) -> Detection {
    let seconds = START_S + after_s;
    let reported = UtcTime::from_micros((i64::from(seconds) + 4) * 1_000_000);
    Detection {
        origin: Origin { system: Address(vessel), entity: 1, reported, received: Some(reported) },
        receiver: 1_024,
        maker: None,
        clock: ReceiverClock { seconds, millis: 250, state: ClockState::Set },
        protocol: Protocol::named("S256"),
        tag_id,
        data: None,
        snr_db: Some(20),
        frequency_khz: Some(69),
        line: 0,
        pose: Some(Pose {
            place: LatLon::from_deg(63.44 + f64::from(after_s) * 1e-6, 10.35).unwrap(),
            age_s: Some(0.1),
            sigma_m: None,
        }),
        effort: Effort::default(),
        raw: None,
    }
}

fn study() -> Study {
    let tag = RegisterTag {
        name: "S256-101".into(),
        protocol: "S256".into(),
        tag_id: Some(101),
        project: "Salmon".into(),
        interval_min_s: Some(20.0),
        interval_max_s: Some(40.0),
        ..RegisterTag::default()
    };
    let project = RegisterProject { name: "Salmon".into(), ..RegisterProject::default() };
    Study::new([RegisterRecord::Tag(tag), RegisterRecord::Project(project)])
}

/// Pieces as they are read: of each vessel separately, the newest first.
fn kept(all: &[Detection]) -> Vec<Sightings> {
    let mut kept = std::collections::BTreeMap::<u16, SightingsBuilder>::new();
    for one in fused(all.to_vec()).iter().rev() {
        kept.entry(one.origin.system.0).or_default().push(one);
    }
    kept.into_values().map(SightingsBuilder::finish).collect()
}

fn all(vessels: impl IntoIterator<Item = u16>) -> Question {
    Question {
        vessels: vessels.into_iter().collect::<BTreeSet<u16>>(),
        from_us: 0,
        to_us: i64::MAX,
        tags: Vec::new(),
        narrowed: Narrowed::default(),
        whole_axis: false,
    }
}

fn counted(detections: &[Detection], question: &Question) -> DetectionsSummary {
    counted_since(None, detections, &study(), question)
}

fn counted_since(
    whole_from_us: Option<i64>,
    detections: &[Detection],
    study: &Study,
    question: &Question,
) -> DetectionsSummary {
    let kept = kept(detections);
    summary(&kept.iter().collect::<Vec<_>>(), study, question, whole_from_us)
}

#[test]
fn detections_are_counted_by_tag_time_place_and_flag() {
    let mut lost = heard(102, 7_200, 1);
    (lost.clock.state, lost.pose) = (ClockState::Lost, None);
    // 101 twice within 900 s, then alone.
    let told = [heard(101, 0, 1), heard(101, 600, 1), heard(101, 7_000, 2), lost];
    let found = counted(&told, &all([1, 2]));
    assert_eq!((found.detections, found.tags_all), (4, 2));
    let first = &found.tags[0];
    assert_eq!(
        (&*first.tag, &*first.project, first.detections, first.unconfirmed),
        ("S256-101", "Salmon", 3, 1)
    );
    assert_eq!(first.marks.iter().map(|[_, count, _]| count).sum::<u32>(), 3);
    assert_eq!(found.bar_us, 3_600_000_000);
    assert_eq!(found.bars.iter().map(|bar| bar.detections).collect::<Vec<_>>(), [2, 1, 1]);
    assert_eq!(found.bars.iter().map(|bar| bar.unconfirmed).sum::<u64>(), 1);
    assert_eq!(found.squares.iter().map(|square| square.detections).sum::<u64>(), 3, "one has no place");
    let flags: Vec<(FlagCode, u64)> = found.flags.iter().map(|flag| (flag.code, flag.detections)).collect();
    assert_eq!(flags, [(FlagCode::Unconfirmed, 1), (FlagCode::ClockLost, 1), (FlagCode::NoPlace, 1)]);
    assert!(found.vessels.iter().all(|vessel| vessel.listened_s.is_none()), "nobody told");
}

#[test]
fn what_was_not_asked_for_is_not_counted_and_tells_nothing() {
    let told = [heard(101, 0, 1), heard(101, 60, 2), heard(102, 120, 1)];
    // The other vessel's detections confirm nothing for a user who may not see it.
    let found = counted(&told, &all([1]));
    assert_eq!((found.detections, found.tags[0].unconfirmed, found.vessels.len()), (2, 1, 1));
    let tagged = Question { tags: vec!["102".parse().unwrap()], ..all([1, 2]) };
    assert_eq!(counted(&told, &tagged).tags[0].tag, "S256-102");
    let of = |project: &str, area| {
        let narrowed = Narrowed::new(&[project.to_owned()], area, &study()).unwrap();
        Question { narrowed, ..all([1, 2]) }
    };
    assert_eq!(counted(&told, &of(" salmon ", None)).detections, 2);
    let near = Some("63.439,10.3;63.44003,10.3;63.44003,10.4;63.439,10.4");
    assert_eq!(counted(&told, &of("", near)).detections, 1);
    let timed = Question { from_us: i64::from(START_S + 50) * 1_000_000, ..all([1, 2]) };
    assert_eq!(counted(&told, &timed).detections, 2);
    assert_eq!(counted(&told, &timed).flags, [], "a neighbour before the time confirms");
    assert_eq!(counted(&[], &all([1])).from_us, None);
    let wrong = Narrowed::new(&["Trout".to_owned()], None, &study()).unwrap_err();
    assert!(wrong.starts_with("project: the register has no project `Trout`"), "{wrong}");
}

#[test]
fn a_list_of_names_is_taken_as_it_is_and_what_is_empty_is_refused() {
    let named = |name: &str| {
        RegisterRecord::Project(RegisterProject { name: name.into(), ..RegisterProject::default() })
    };
    let study = Study::new([named("Salmon; north"), named("Salmon")]);
    let of = |names: &[&str], area| Narrowed::of(names.iter().copied(), area, &study);
    assert!(of(&[" salmon; north "], None).is_ok_and(|narrowed| !narrowed.is_all()));
    assert!(of(&[], None).is_ok_and(|narrowed| narrowed.is_all()));
    assert!(of(&["Salmon", " "], None).unwrap_err().starts_with("project: a name is empty"));
    assert!(of(&[], Some("")).unwrap_err().starts_with("area: it is empty"));
    assert!(
        Narrowed::new(&[String::new()], Some(" "), &study).is_ok_and(|narrowed| narrowed.is_all()),
        "the page's fields"
    );
}

#[test]
fn a_name_with_a_semicolon_is_one_project_and_any_other_text_is_a_list() {
    let named = |name: &str| {
        RegisterRecord::Project(RegisterProject { name: name.into(), ..RegisterProject::default() })
    };
    let study = Study::new([named("Salmon; north"), named("Salmon"), named("Trout")]);
    let of = |texts: &[&str]| {
        let texts: Vec<String> = texts.iter().map(|text| (*text).to_owned()).collect();
        Narrowed::new(&texts, None, &study)
    };
    let listed = |names: &[&str]| Narrowed::of(names.iter().copied(), None, &study);
    assert_eq!(of(&["Salmon; north"]), listed(&["Salmon; north"]));
    assert_eq!(of(&["Salmon;Trout"]), listed(&["Salmon", "Trout"]));
    assert_eq!(of(&["salmon; north", "Trout"]), listed(&["Salmon; north", "Trout"]));
    assert!(of(&["Salmon;Cod"]).unwrap_err().contains("no project `Cod`"));
}

#[test]
fn listening_is_counted_as_it_was_told_and_no_longer() {
    let mut kept = SightingsBuilder::default();
    kept.push(&heard(101, 30, 1));
    let on = |after_s: u32, on: bool| {
        let reported = UtcTime::from_micros(i64::from(START_S + after_s) * 1_000_000);
        (
            Origin { system: Address(1), entity: 1, reported, received: None },
            Listening { on, ..Listening::default() },
        )
    };
    // 30 s, 30 s, then silence that counts 90 s; off from 600 s on.
    for (origin, told) in [on(600, false), on(60, true), on(30, true), on(0, true)] {
        kept.listen(origin, told);
    }
    let kept = kept.finish();
    let found = summary(&[&kept], &study(), &all([1]), None);
    assert_eq!(found.vessels[0].listened_s, Some(150.0));
    assert_eq!(found.bars[0].listened_s, Some(150.0));
    let area = Narrowed::new(&[], Some("63,10;64,10;64,11"), &study()).unwrap();
    let within = summary(&[&kept], &study(), &Question { narrowed: area, ..all([1]) }, None);
    assert_eq!(within.vessels.first().and_then(|vessel| vessel.listened_s), None, "nobody knows where");
}

#[test]
fn neighbours_are_those_that_files_tell() {
    // A made-up order of tags and times; numbers by Knuth's multiplier.
    let told: Vec<Detection> = (0..2_000_u32)
        .map(|at| heard(101 + at.wrapping_mul(2_654_435_761) % 7, at * 90, 1))
        .map(|one| Detection { receiver: one.receiver + one.tag_id % 2, ..one })
        .collect();
    let mut lags = Lags::default();
    let study = study();
    let mut unconfirmed = 0;
    for one in told.clone() {
        lags.push(one);
    }
    while let Some((one, lag)) = lags.take() {
        assert_ne!(lag, Lag::Unknown);
        unconfirmed += u64::from(study.heard(&one, "", lag).doubt().is_some());
    }
    assert!(unconfirmed > 0);
    assert_eq!(counted(&told, &all([1])).tags.iter().map(|tag| tag.unconfirmed).sum::<u64>(), unconfirmed);
}

/// A receiver that was taken from one boat to another and back: its detections come as two lists.
#[test]
fn neighbours_are_found_across_vessels_as_files_do() {
    // 100 to 1,300 s apart, by turns: on one boat alone hardly any is within 900 s of the next.
    let told: Vec<Detection> = (0..600_u32)
        .map(|at| heard(101, at * 700 + at.wrapping_mul(2_654_435_761) % 600, u16::from(at % 2 == 1)))
        .collect();
    let (mut lags, study, mut unconfirmed) = (Lags::default(), study(), 0);
    told.iter().cloned().for_each(|one| lags.push(one));
    while let Some((one, lag)) = lags.take() {
        unconfirmed += u64::from(study.heard(&one, "", lag).doubt().is_some());
    }
    assert!(unconfirmed > 0 && unconfirmed < 300, "{unconfirmed}");
    assert_eq!(counted(&told, &all([0, 1])).tags.iter().map(|tag| tag.unconfirmed).sum::<u64>(), unconfirmed);
}

#[test]
fn a_code_that_is_used_again_is_another_fish() {
    let at_us = |after_s: u32| Some(i64::from(START_S + after_s) * 1_000_000);
    let animal = |name: &str, project: &str| {
        RegisterRecord::Animal(RegisterAnimal {
            name: name.into(),
            project: project.into(),
            ..RegisterAnimal::default()
        })
    };
    let tag = |name: &str, animal: &str, from_us, to_us| {
        RegisterRecord::Tag(RegisterTag {
            name: name.into(),
            protocol: "S256".into(),
            tag_id: Some(101),
            animal: animal.into(),
            from_us,
            to_us,
            ..RegisterTag::default()
        })
    };
    let projects = ["Salmon", "Trout"].map(|name| {
        RegisterRecord::Project(RegisterProject { name: name.into(), ..RegisterProject::default() })
    });
    let study = Study::new(projects.into_iter().chain([
        animal("Olga", "Salmon"),
        animal("Kari", "Trout"),
        tag("first", "Olga", at_us(0), at_us(1_000)),
        tag("second", "Kari", at_us(2_000), None),
    ]));
    // Three of Olga, one while no animal had the code, two of Kari by another receiver.
    let late = |after_s| Detection { receiver: 1_025, ..heard(101, after_s, 1) };
    let told = [
        heard(101, 1, 1),
        heard(101, 2, 1),
        heard(101, 3, 1),
        heard(101, 1_500, 1),
        late(2_001),
        late(2_002),
    ];
    let found = counted_since(None, &told, &study, &all([1]));
    let tags: Vec<_> =
        found.tags.iter().map(|tag| (&*tag.name, &*tag.animal, &*tag.project, tag.detections)).collect();
    assert_eq!(
        tags,
        [("first", "Olga", "Salmon", 3), ("second", "Kari", "Trout", 2), ("", "", "", 1)],
        "each by itself"
    );
    assert_eq!(found.tags_all, 3);
    assert_eq!(found.tags[0].last_us, heard(101, 3, 1).clock.utc().unwrap().micros());
}

#[test]
fn before_an_animal_carries_it_a_tag_is_a_tag_alone() {
    let released = RegisterAnimal {
        name: "Olga".into(),
        project: "Salmon".into(),
        release_us: Some(i64::from(START_S + 100) * 1_000_000),
        ..RegisterAnimal::default()
    };
    let tag = RegisterTag {
        name: "tag".into(),
        protocol: "S256".into(),
        tag_id: Some(101),
        animal: "Olga".into(),
        ..RegisterTag::default()
    };
    let project = RegisterProject { name: "Salmon".into(), ..RegisterProject::default() };
    let study = Study::new([
        RegisterRecord::Animal(released),
        RegisterRecord::Tag(tag),
        RegisterRecord::Project(project),
    ]);
    let told = [heard(101, 1, 1), heard(101, 200, 1), heard(101, 201, 1)];
    let found = counted_since(None, &told, &study, &all([1]));
    let tags: Vec<_> = found.tags.iter().map(|tag| (&*tag.animal, &*tag.project, tag.detections)).collect();
    assert_eq!(tags, [("Olga", "Salmon", 2), ("", "", 1)]);
}

#[test]
fn what_is_not_read_yet_may_confirm() {
    // Alone within 900 s: in doubt, but not where the neighbours of a day are not all there.
    let told = [heard(101, 100, 1), heard(101, 90_000, 1)];
    let since = |whole_s: Option<u32>| {
        let whole_us = whole_s.map(|after_s| i64::from(START_S + after_s) * 1_000_000);
        let found = counted_since(whole_us, &told, &study(), &all([1]));
        (found.detections, found.flags.iter().map(|flag| flag.detections).sum::<u64>())
    };
    assert_eq!(since(None), (2, 2));
    assert_eq!(since(Some(50)), (2, 1), "the first is within a day of what is not there");
    assert_eq!(since(Some(10_000)), (1, 0), "the first is left out, and a day is not over at the second");
}

#[test]
fn squares_of_both_sides_of_the_date_line_lie_together() {
    let at = |after_s, lat, lon| Detection {
        pose: Some(Pose { place: LatLon::from_deg(lat, lon).unwrap(), age_s: Some(0.1), sigma_m: None }),
        ..heard(101, after_s, 1)
    };
    // Some 440 m apart, at the equator where a degree is longest.
    let told = [at(0, 0.0, 179.998), at(30, 0.0, -179.998), at(60, 0.001, 179.999)];
    let found = counted(&told, &all([1]));
    assert!(found.square_m < 10.0, "{} m", found.square_m);
    let mut places: Vec<f64> = found.squares.iter().map(|square| square.lon_deg).collect();
    places.sort_by(f64::total_cmp);
    assert_eq!(places.len(), 3, "{places:?}");
    for (place, wanted) in places.iter().zip([-179.998, 179.998, 179.999]) {
        assert!((place - wanted).abs() < 1e-6, "{places:?}");
    }
    let greenwich = counted(&[at(0, 51.0, -0.5), at(30, 51.0, 0.5)], &all([1]));
    assert!(greenwich.square_m < 1_200.0, "{} m", greenwich.square_m);
}

#[test]
fn no_place_is_lost_at_the_edge_of_the_squares() {
    // Widths across the 180th meridian that come out as 60 squares, more or less by rounding; numbers by Knuth's multiplier.
    for number in 1..2_000_u32 {
        let random = |at: u32| f64::from((number + at).wrapping_mul(2_654_435_761)) / f64::from(u32::MAX);
        let at = |after_s, lat, lon| Detection {
            pose: Some(Pose { place: LatLon::from_deg(lat, lon).unwrap(), age_s: Some(0.1), sigma_m: None }),
            ..heard(101, after_s, 1)
        };
        let (west, east) = (180.0 - random(0), random(1) - 180.0);
        let told = [at(0, 0.0, west), at(30, random(2) * 0.1, east), at(60, random(3) * 0.1, 180.0)];
        let found = counted(&told, &all([1]));
        assert_eq!(found.squares.iter().map(|square| square.detections).sum::<u64>(), 3, "{west} {east}");
    }
}

#[test]
fn one_wrong_clock_does_not_stretch_the_plots() {
    let mut told: Vec<Detection> = (0..30).map(|at| heard(101, at * 60, 1)).collect();
    let mut lost = heard(101, 0, 1);
    // A vessel that thinks it is 1970, and one detection half an hour after the others, which is not far.
    (lost.clock.state, lost.origin.reported) = (ClockState::NotSet, UtcTime::from_micros(1_000_000));
    told.push(lost);
    told.push(heard(101, 3_000, 1));
    let found = counted(&told, &all([1]));
    assert_eq!((found.detections, found.outside), (32, 1));
    assert_eq!(found.bar_us, 3_600_000_000);
    assert_eq!(found.from_us, Some(i64::from(START_S) * 1_000_000));
    assert_eq!(found.tags[0].marks.iter().map(|[_, count, _]| count).sum::<u32>(), 31);
    let stretched = counted(&told, &Question { whole_axis: true, ..all([1]) });
    assert_eq!((stretched.detections, stretched.outside), (32, 0));
    assert!(stretched.bar_us > 7 * 86_400_000_000, "over 56 years");
    // Among only a few none counts as far.
    assert_eq!(counted(&told[25..], &all([1])).outside, 0);
}

/// The first week of a season is perhaps one detection, half a year before all others.
#[test]
fn what_a_good_clock_heard_always_stands_on_the_axis() {
    let early_s = 180 * 86_400;
    let late = (0..2_000).map(|at| heard(101, early_s + at * 60, 1));
    let mut lost = heard(101, 0, 1);
    (lost.clock.state, lost.origin.reported) = (ClockState::NotSet, UtcTime::from_micros(1_000_000));
    let told: Vec<Detection> = [lost, heard(101, 0, 1)].into_iter().chain(late).collect();
    let found = counted(&told, &all([1]));
    assert_eq!((found.detections, found.outside), (2_002, 1), "the one of 1970 alone");
    assert!(found.from_us.unwrap() <= i64::from(START_S) * 1_000_000);
    assert_eq!(found.tags[0].marks.iter().map(|[_, count, _]| count).sum::<u32>(), 2_001);
    assert_eq!(counted(&told[1..], &all([1])).outside, 0);
}

#[test]
fn listening_outside_of_the_axis_is_told() {
    let on = |builder: &mut SightingsBuilder, seconds: i64, on: bool| {
        let reported = UtcTime::from_micros(seconds * 1_000_000);
        builder.listen(
            Origin { system: Address(1), entity: 1, reported, received: None },
            Listening { on, ..Listening::default() },
        );
    };
    let mut kept = SightingsBuilder::default();
    for at in (0..5_000).rev() {
        kept.push(&heard(101, at * 60, 1));
    }
    // Half a minute in 1970.
    on(&mut kept, 31, false);
    on(&mut kept, 1, true);
    let kept = kept.finish();
    let found = summary(&[&kept], &study(), &all([1]), None);
    assert_eq!((found.outside, found.listened_outside_s), (0, 30.0));
    assert_eq!(found.vessels[0].listened_s, Some(30.0), "it is counted");
    let whole = summary(&[&kept], &study(), &Question { whole_axis: true, ..all([1]) }, None);
    assert_eq!((whole.outside, whole.listened_outside_s), (0, 0.0));
    assert!(whole.from_us.unwrap() < 1_000_000_000, "{:?}", whole.from_us);
}

#[test]
fn detections_are_divided_into_equal_parts() {
    let told: Vec<Detection> = (0..100).map(|at| heard(101 + at % 10, at / 10 * 10, 1)).collect();
    let kept = kept(&told);
    let pieces: Vec<&Sightings> = kept.iter().collect();
    let of = |parts: usize, tag: &str| {
        let tags = if tag.is_empty() { Vec::new() } else { vec![tag.parse().unwrap()] };
        ranks(&pieces, &study(), &Question { tags, ..all([1]) }, parts)
    };
    let all = of(4, "");
    let begins = |all: &Ranks| {
        all.parts.iter().map(|part| part.from_us / 1_000_000 - i64::from(START_S) - 4).collect::<Vec<_>>()
    };
    let count = |all: &Ranks| all.parts.iter().map(|part| part.detections).collect::<Vec<_>>();
    assert_eq!((all.detections, begins(&all), count(&all)), (100, vec![0, 20, 50, 70], vec![20, 30, 20, 30]));
    // Detections that were reported together stay together.
    let many = of(1_000, "");
    assert_eq!(count(&many), [10; 10]);
    assert_eq!(count(&of(1_000, "102")), [1; 10]);
    assert_eq!(of(4, "999"), Ranks { detections: 0, parts: Vec::new() });
}

#[test]
fn weeks_begin_on_monday() {
    let mut late = heard(101, 0, 1);
    late.clock.seconds += 4 * 365 * 86_400;
    late.origin.reported = UtcTime::from_micros(i64::from(late.clock.seconds) * 1_000_000);
    let told = [heard(101, 0, 1), late];
    let found = counted(&told, &all([1]));
    assert_eq!(found.bar_us % (7 * 86_400_000_000), 0);
    // 2026-11-16 is the Monday before 2026-11-21.
    assert_eq!(found.bars[0].from_us, i64::from(START_S - 5 * 86_400 - 8 * 3_600) * 1_000_000);
}

/// A million detections: `cargo nextest run --release --workspace --run-ignored all --no-capture -E 'test(a_million_detections)'`.
#[test]
#[ignore = "a measurement: it prints its figures"]
#[expect(clippy::disallowed_methods, reason = "a measurement reads the clock")]
fn a_million_detections_are_counted_at_once() {
    let mut kept = SightingsBuilder::default();
    for at in (0..1_000_000_u32).rev() {
        kept.push(&heard(101 + at.wrapping_mul(2_654_435_761) % 300, at * 5, 1));
    }
    let kept = kept.finish();
    let study = study();
    for _ in 0..3 {
        let begun = Instant::now();
        let found = summary(&[&kept], &study, &all([1]), None);
        let took = begun.elapsed();
        let bytes = serde_json::to_vec(&found).unwrap().len();
        println!("{} detections counted in {took:?}, an answer of {bytes} bytes", found.detections);
        assert_eq!(found.detections, 1_000_000);
    }
}
