//! Tests of the plan database.

use super::*;
use proptest::prelude::*;

fn request(plan_id: &str, ask: DatabaseQuery) -> DatabaseRequest {
    let origin = Origin { system: 0x4001, entity: 3, request: 7 };
    DatabaseRequest { origin, name: "console".to_owned(), plan_id: plan_id.to_owned(), ask }
}

fn set(plan_id: &str, size: usize) -> DatabaseRequest {
    let digest = [size as u8; 16];
    request(plan_id, DatabaseQuery::Set { bytes: vec![1; size], digest, named: plan_id.to_owned() })
}

fn small() -> PlanDatabase {
    let limits = DatabaseLimits {
        max_plans: 3,
        max_plan_bytes: 100,
        max_bytes: 200,
        max_changes: 2,
        max_name_bytes: 8,
    };
    PlanDatabase::new(limits, Kept::default())
}

type Told = Option<Result<Answer, DatabaseError>>;

/// Handles a request, the shell storing as `storage` says; what was answered.
fn ask(database: &mut PlanDatabase, request: DatabaseRequest, storage: Result<(), &str>) -> Vec<Told> {
    database.handle(UtcTime::from_micros(5), request);
    let mut told = Vec::new();
    while let Some(outgoing) = database.poll_outgoing() {
        match outgoing {
            Outgoing::Reply(reply) => told.push(reply.result),
            Outgoing::Effect(effect) => database.stored(effect.ticket(), storage.map_err(ToOwned::to_owned)),
        }
    }
    told
}

#[test]
fn a_change_is_answered_in_progress_and_then_with_its_result() {
    let mut database = small();
    let told = ask(&mut database, set("b", 10), Ok(()));
    assert_eq!(told[0], None);
    let Some(Ok(Answer::Stored { info, replaced: false })) = &told[1] else { panic!("{told:?}") };
    assert_eq!((info.plan_id.as_str(), info.bytes, info.digest), ("b", 10, [10; 16]));
    assert_eq!((info.change.at, info.change.system), (UtcTime::from_micros(5), 0x4001));
    let told = ask(&mut database, set("b", 20), Ok(()));
    assert!(matches!(told[1], Some(Ok(Answer::Stored { replaced: true, .. }))));
    let told = ask(&mut database, request("b", DatabaseQuery::Delete), Ok(()));
    assert_eq!(told, [None, Some(Ok(Answer::Removed))]);
    assert!(database.get("b").is_none());
}

#[test]
fn nothing_is_visible_before_it_is_stored() {
    let mut database = small();
    database.handle(UtcTime::from_micros(5), set("a", 10));
    assert!(database.get("a").is_none());
    assert_eq!(ask(&mut database, set("a", 10), Err("disk full")).len(), 4);
    assert!(database.get("a").is_none());
    let told = ask(&mut database, set("a", 10), Err("disk full"));
    assert_eq!(told[1], Some(Err(DatabaseError::Storage("disk full".to_owned()))));
    assert_eq!(database.state(), DatabaseState::default());
}

#[test]
fn reading_answers_once() {
    let mut database = small();
    ask(&mut database, set("b", 10), Ok(()));
    ask(&mut database, set("a", 20), Ok(()));
    let told = ask(&mut database, request("b", DatabaseQuery::Get), Ok(()));
    assert!(matches!(&told[..], [Some(Ok(Answer::Plan(record)))] if record.bytes == vec![1; 10]));
    let told = ask(&mut database, request("a", DatabaseQuery::GetInfo), Ok(()));
    assert!(matches!(&told[..], [Some(Ok(Answer::Info(info)))] if info.bytes == 20));
    let told = ask(&mut database, request("x", DatabaseQuery::Get), Ok(()));
    assert_eq!(told, [Some(Err(DatabaseError::Undefined))]);
    let told = ask(&mut database, request("x", DatabaseQuery::GetState), Ok(()));
    let [Some(Ok(Answer::State(state)))] = &told[..] else { panic!("{told:?}") };
    let names: Vec<&str> = state.plans.iter().map(|info| info.plan_id.as_str()).collect();
    assert_eq!((names, state.bytes), (vec!["a", "b"], 30));
}

#[test]
fn refuses_what_is_over_its_bounds() {
    let mut database = small();
    ask(&mut database, set("a", 90), Ok(()));
    let cases = [
        (set("", 1), DatabaseError::BadName),
        (set("far too long", 1), DatabaseError::BadName),
        (set("b", 101), DatabaseError::TooLarge { bytes: 101, limit: 100 }),
        (
            request("b", DatabaseQuery::Set { bytes: vec![], digest: [0; 16], named: "c".to_owned() }),
            DatabaseError::NamesDiffer { named: "c".to_owned() },
        ),
        (request("b", DatabaseQuery::Delete), DatabaseError::Undefined),
    ];
    for (request, error) in cases {
        assert_eq!(ask(&mut database, request, Ok(())), [None, Some(Err(error))]);
    }
    ask(&mut database, set("b", 90), Ok(()));
    assert_eq!(ask(&mut database, set("c", 90), Ok(()))[1], Some(Err(DatabaseError::Full)), "bytes");
    ask(&mut database, set("c", 1), Ok(()));
    assert_eq!(ask(&mut database, set("d", 1), Ok(()))[1], Some(Err(DatabaseError::Full)), "plans");
    assert!(matches!(ask(&mut database, set("a", 80), Ok(()))[1], Some(Ok(_))), "a replacement has room");
}

#[test]
fn changes_under_way_are_bounded_and_counted() {
    let mut database = small();
    for id in ["a", "b"] {
        database.handle(UtcTime::from_micros(5), set(id, 1));
    }
    database.handle(UtcTime::from_micros(5), set("c", 1));
    let outgoing: Vec<_> = std::iter::from_fn(|| database.poll_outgoing()).collect();
    assert!(
        matches!(outgoing.last(), Some(Outgoing::Reply(reply)) if reply.result == Some(Err(DatabaseError::Busy)))
    );
    assert_eq!(outgoing.iter().filter(|one| matches!(one, Outgoing::Effect(_))).count(), 2);
}

#[test]
fn clearing_forgets_all_and_is_the_last_change() {
    let mut database = small();
    ask(&mut database, set("a", 1), Ok(()));
    assert_eq!(
        ask(&mut database, request("a", DatabaseQuery::Clear), Ok(())),
        [None, Some(Ok(Answer::Removed))]
    );
    let state = database.state();
    assert_eq!((state.plans.len(), state.last_change.is_some()), (0, true));
}

#[test]
fn starts_with_what_was_stored() {
    let mut database = small();
    ask(&mut database, set("a", 1), Ok(()));
    ask(&mut database, set("b", 2), Ok(()));
    let stored: Vec<Record> = database.records().cloned().collect();
    let again = PlanDatabase::new(DatabaseLimits::default(), Kept { plans: stored, ..Kept::default() });
    assert_eq!(again.state(), database.state());
    // The last change may be lost.
    let stored: Vec<Record> = database.records().cloned().collect();
    let last = stored.iter().map(|record| record.change.at).max().unwrap();
    let change = |s: f64| Change {
        at: UtcTime::from_micros(last.micros() + (1e6 * s) as i64),
        system: 9,
        ..Change::default()
    };
    for (after_s, counts) in [(1.0, true), (-1.0, false)] {
        let kept = Kept { plans: stored.clone(), forgotten: Some(change(after_s)), under_way: None };
        let state = PlanDatabase::new(DatabaseLimits::default(), kept).state();
        assert_eq!(state.last_change == Some(change(after_s)), counts);
    }
}

proptest! {
    #[test]
    fn keeps_its_bounds_whatever_is_asked(
        asks in prop::collection::vec((0..4_u8, "[a-f]", 0..120_usize, any::<bool>()), 0..60)
    ) {
        let mut database = small();
        for (kind, id, size, stores) in asks {
            let request = match kind {
                0 | 1 => set(&id, size),
                2 => request(&id, DatabaseQuery::Delete),
                _ => request(&id, DatabaseQuery::Clear),
            };
            let told = ask(&mut database, request, if stores { Ok(()) } else { Err("broken") });
            prop_assert_eq!(told.len(), 2);
            prop_assert!(told[0].is_none() && told[1].is_some());
            let state = database.state();
            prop_assert!(state.plans.len() <= 3 && state.bytes <= 200);
        }
    }
}
