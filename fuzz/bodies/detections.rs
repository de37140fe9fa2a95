//! What must hold for any text that claims to be a report of a detection. The fuzz target calls this with bytes of its own
//! making, and `make test` with the committed seeds and everything that was ever found.

use detections::{Detection, Origin, TOPIC, fused};
use imc::messages::Event;
use imc::{Address, Text};
use units::UtcTime;

/// What is understood of it is told by the report of what was understood, and both together are one detection.
pub(crate) fn report(data: &[u8]) {
    let reported = UtcTime::from_micros(1_795_248_000_000_000);
    let origin = Origin { system: Address(0x2810), entity: 9, reported, received: None };
    let event = Event { topic: TOPIC.into(), data: Text::from_bytes(data) };
    let Some(told) = Detection::from_report(origin, &event) else { return };
    let again = Detection::from_report(origin, &told.report()).expect("it was told");
    assert_eq!(again.report(), told.report());
    assert_eq!(again.id(), told.id());
    if let Some(tag) = told.fish_tag() {
        let brief = Detection::from_fish_tag(origin, &tag);
        assert!(brief.is_same(&told));
        assert_eq!(fused(vec![brief, told]).len(), 1);
    }
}
