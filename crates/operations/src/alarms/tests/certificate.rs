//! The server's certificate: reported in time, and again when it becomes urgent.

use super::*;

const DAY_S: u64 = 86_400;

#[test]
fn a_certificate_is_told_from_thirty_days_before_its_end_and_more_urgently_in_the_last_week() {
    let mut bench = Bench::new();
    let until = UtcTime::from_micros(100 * DAY_S as i64 * 1_000_000);
    let file = "/etc/lutra/server.pem".to_owned();
    bench.shore.certificate = Some(CertificateState { file, until, refused: None });
    bench.s = 70 * DAY_S - 2;
    bench.pass(1);
    assert_eq!(bench.told(), [], "a month and a second are left");
    bench.pass(1);
    let told = bench.only();
    assert_eq!((told.key.kind, told.priority), (Kind::Certificate, Priority::Caution));
    assert_eq!(told.text, "the certificate /etc/lutra/server.pem ends on 1970-04-11 at 00:00:00Z");
    assert!(!told.wants_acknowledgement());
    bench.s = 93 * DAY_S - 1;
    bench.pass(1);
    assert_eq!((bench.only().priority, bench.only().state), (Priority::Warning, State::Unacknowledged));
    let (id, now) = (bench.only().id, bench.now());
    bench.alarms.acknowledge(now, id, "nils").unwrap();
    bench.s = 100 * DAY_S - 1;
    bench.pass(1);
    let ended = bench.only();
    assert_eq!(
        (ended.priority, ended.state),
        (Priority::Alarm, State::Unacknowledged),
        "who knew is told again"
    );
    assert_eq!(ended.text, "the certificate /etc/lutra/server.pem ended on 1970-04-11 at 00:00:00Z");
    // A new one is there.
    bench.shore.certificate.as_mut().unwrap().until = UtcTime::from_micros(900 * DAY_S as i64 * 1_000_000);
    bench.pass(10);
    assert_eq!(bench.only().state, State::Returned);
}

#[test]
fn new_files_that_cannot_be_used_are_told_beside_the_end() {
    let mut bench = Bench::new();
    let until = UtcTime::from_micros(5 * DAY_S as i64 * 1_000_000);
    let refused = Some("tls.key /etc/lutra/key.pem: no such file".to_owned());
    bench.shore.certificate = Some(CertificateState { file: "a.pem".to_owned(), until, refused });
    bench.pass(2);
    let kinds: Vec<_> = bench.told().into_iter().map(|(kind, _, priority)| (kind, priority)).collect();
    assert_eq!(kinds, [(Kind::Certificate, Priority::Warning); 2]);
    let texts: Vec<String> = bench.alarms.standing().map(|one| one.text.clone()).collect();
    let wanted = "a new certificate cannot be used, the earlier one still is: tls.key /etc/lutra/key.pem: no such file";
    assert!(texts.iter().any(|text| text == wanted), "{texts:?}");
}
