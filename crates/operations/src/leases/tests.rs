use super::*;
use proptest::prelude::*;

const BOAT: Address = Address(0x2810);

fn at(seconds: u64) -> Now {
    let us = seconds * 1_000_000;
    Now { mono: MonoTime::from_micros(us), utc: UtcTime::from_micros(1_790_000_000_000_000 + us as i64) }
}

fn person(number: i64) -> Holder {
    Holder { person: number, name: format!("person {number}"), key: format!("window {number}") }
}

fn request(reason: &str) -> LeaseRequest {
    LeaseRequest::Request(reason.to_owned())
}

fn changes(leases: &mut Leases) -> Vec<Change> {
    leases.drain().0.into_iter().map(|event| event.change).collect()
}

#[test]
fn a_free_lease_is_granted_at_once_and_ends_without_renewal() {
    let mut leases = Leases::default();
    assert!(matches!(leases.epoch(at(0), BOAT, &person(1)), Err(LeaseRefused::NotYours(_))));
    leases.ask(at(0), BOAT, &person(1), request("")).unwrap();
    let first = leases.epoch(at(0), BOAT, &person(1)).unwrap();
    for second in (10..=100).step_by(10) {
        leases.ask(at(second), BOAT, &person(1), LeaseRequest::Renew).unwrap();
    }
    assert_eq!(leases.epoch(at(159), BOAT, &person(1)), Ok(first));
    assert!(leases.epoch(at(160), BOAT, &person(1)).is_err(), "also before anybody looks at the time");
    leases.tick(at(160));
    assert_eq!(leases.of(BOAT).held, None);
    leases.ask(at(161), BOAT, &person(2), request("")).unwrap();
    assert!(leases.epoch(at(161), BOAT, &person(2)).unwrap() > first);
    assert_eq!(changes(&mut leases), [Change::Granted, Change::Expired, Change::Granted]);
}

#[test]
fn a_request_waits_for_the_holder_and_not_for_ever() {
    let mut leases = Leases::default();
    leases.ask(at(0), BOAT, &person(1), request("")).unwrap();
    leases.ask(at(1), BOAT, &person(2), request("my turn")).unwrap();
    assert_eq!(leases.of(BOAT).waiting.as_ref().unwrap().reason, "my turn");
    let other = leases.ask(at(2), BOAT, &person(3), request("")).unwrap_err();
    assert_eq!(other.to_string(), "person 2 has asked already and gets an answer within 30 s.");
    assert!(leases.ask(at(3), BOAT, &person(2), LeaseRequest::Grant).is_err(), "not one's own request");
    leases.ask(at(4), BOAT, &person(1), LeaseRequest::Decline).unwrap();
    assert_eq!(leases.ask(at(5), BOAT, &person(1), LeaseRequest::Grant), Err(LeaseRefused::NobodyWaits));
    leases.ask(at(6), BOAT, &person(2), request("really")).unwrap();
    leases.ask(at(20), BOAT, &person(1), LeaseRequest::Renew).unwrap();
    // Asking again does not prolong the wait.
    leases.ask(at(30), BOAT, &person(2), request("please")).unwrap();
    leases.tick(at(35));
    assert_eq!(leases.of(BOAT).held.as_ref().unwrap().holder, person(1));
    leases.tick(at(36));
    assert_eq!(leases.of(BOAT).held.as_ref().unwrap().holder, person(2));
    leases.ask(at(37), BOAT, &person(1), request("")).unwrap();
    leases.ask(at(38), BOAT, &person(2), LeaseRequest::Grant).unwrap();
    assert!(leases.epoch(at(38), BOAT, &person(1)).is_ok());
}

#[test]
fn who_releases_makes_way_for_who_waits() {
    let mut leases = Leases::default();
    leases.ask(at(0), BOAT, &person(1), request("")).unwrap();
    leases.ask(at(1), BOAT, &person(2), request("")).unwrap();
    leases.ask(at(2), BOAT, &person(1), LeaseRequest::Release).unwrap();
    assert!(leases.epoch(at(2), BOAT, &person(2)).is_ok());
    leases.ask(at(3), BOAT, &person(2), LeaseRequest::Release).unwrap();
    assert!(leases.ask(at(3), BOAT, &person(2), LeaseRequest::Release).is_err());
    assert_eq!(leases.of(BOAT).last.as_ref().unwrap().change, Change::Released);
}

#[test]
fn taking_over_needs_a_reason_that_the_former_holder_reads() {
    let mut leases = Leases::default();
    leases.ask(at(0), BOAT, &person(1), request("")).unwrap();
    leases.ask(at(1), BOAT, &person(2), request("")).unwrap();
    let before = leases.epoch(at(1), BOAT, &person(1)).unwrap();
    let take = |reason: &str| LeaseRequest::Take(reason.to_owned());
    assert!(matches!(leases.ask(at(2), BOAT, &person(3), take("  ")), Err(LeaseRefused::NoReason(_))));
    assert!(leases.ask(at(2), BOAT, &person(3), take(&"x".repeat(201))).is_err());
    leases.ask(at(2), BOAT, &person(3), take("it drifts")).unwrap();
    let lease = leases.of(BOAT);
    let last = lease.last.clone().unwrap();
    assert_eq!((last.change, &*last.who, &*last.reason), (Change::TakenOver, "person 3", "it drifts"));
    assert_eq!(last.from.as_deref(), Some("person 1"));
    assert!(lease.held.as_ref().unwrap().epoch > before && lease.waiting.is_some());
    assert!(leases.epoch(at(2), BOAT, &person(1)).is_err());
}

#[test]
fn who_takes_over_has_the_whole_time_to_answer_who_waits() {
    let mut leases = Leases::default();
    leases.ask(at(0), BOAT, &person(1), request("")).unwrap();
    leases.ask(at(1), BOAT, &person(2), request("my turn")).unwrap();
    leases.ask(at(30), BOAT, &person(3), LeaseRequest::Take("it drifts".to_owned())).unwrap();
    let waiting = leases.of(BOAT).waiting.clone().unwrap();
    assert_eq!((waiting.since, waiting.granted_at), (at(1).utc, at(60).utc));
    leases.tick(at(59));
    assert_eq!(leases.of(BOAT).held.as_ref().unwrap().holder, person(3));
    leases.tick(at(60));
    assert_eq!(leases.of(BOAT).held.as_ref().unwrap().holder, person(2));
}

#[test]
fn two_windows_of_one_person_are_told_apart() {
    let mut leases = Leases::default();
    let other = Holder { key: "another".to_owned(), ..person(1) };
    leases.ask(at(0), BOAT, &person(1), request("")).unwrap();
    let before = leases.epoch(at(0), BOAT, &person(1)).unwrap();
    assert!(leases.epoch(at(0), BOAT, &other).is_err());
    assert!(leases.ask(at(1), BOAT, &other, LeaseRequest::Renew).is_err());
    leases.ask(at(1), BOAT, &other, request("")).unwrap();
    assert!(leases.epoch(at(1), BOAT, &other).unwrap() > before);
    assert!(leases.epoch(at(1), BOAT, &person(1)).is_err());
}

#[test]
fn what_nobody_fetches_is_bounded_and_counted() {
    let mut leases = Leases::default();
    for second in 0..2_000 {
        let ask = if second % 2 == 0 { request("") } else { LeaseRequest::Release };
        leases.ask(at(second), BOAT, &person(1), ask).unwrap();
    }
    let (events, forgotten) = leases.drain();
    assert_eq!((events.len(), forgotten), (EVENTS_KEPT, 1_000));
}

fn anything() -> impl Strategy<Value = LeaseRequest> {
    prop_oneof![
        Just(LeaseRequest::Request(String::new())),
        Just(LeaseRequest::Grant),
        Just(LeaseRequest::Decline),
        Just(LeaseRequest::Release),
        Just(LeaseRequest::Renew),
        Just(LeaseRequest::Take("now".to_owned())),
    ]
}

proptest! {
    /// Whatever people do: one holder at most, who was heard within the last minute; epochs that grow with every
    /// change of holder; no one waits for a free lease, nor for their own, nor longer than they must.
    #[test]
    fn there_is_one_holder_at_most(steps in prop::collection::vec((0u64..40, 1i64..4, anything()), 1..200)) {
        let mut leases = Leases::default();
        let (mut seconds, mut heard, mut epoch) = (0, 0, 0);
        for (wait, number, ask) in steps {
            seconds += wait;
            let now = at(seconds);
            let who = person(number);
            let was = leases.of(BOAT).held.clone();
            let done = leases.ask(now, BOAT, &who, ask.clone()).is_ok();
            let lease = leases.of(BOAT).clone();
            if let Some(held) = &lease.held {
                if was.as_ref().map(|was| was.epoch) == Some(held.epoch) {
                    prop_assert_eq!(&was.as_ref().unwrap().holder, &held.holder);
                    if done && number == held.holder.person && matches!(ask, LeaseRequest::Renew | LeaseRequest::Request(_) | LeaseRequest::Take(_)) {
                        heard = seconds;
                    }
                } else {
                    prop_assert!(held.epoch > epoch);
                    (epoch, heard) = (held.epoch, seconds);
                }
                prop_assert!(seconds - heard < LASTS.as_secs());
                let may: Vec<i64> = (1..4).filter(|one| leases.epoch(now, BOAT, &person(*one)).is_ok()).collect();
                prop_assert_eq!(may, vec![held.holder.person]);
            }
            if let Some(waiting) = &lease.waiting {
                prop_assert!(now.mono < waiting.due);
                prop_assert!(lease.held.as_ref().is_some_and(|held| held.holder.person != waiting.who.person));
            }
        }
    }
}
