//! How a receiver listens, reported also while it hears nothing: only so is it known where no fish was.

use crate::detection::ClockState;
use crate::list::{List, number};
use imc::messages::Event;
use imc::tuples;

/// The topic of an Event that reports how a receiver listens.
pub const LISTENING_TOPIC: &str = "AcousticListening";

/// How a receiver listens, from this moment until the next such report.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Listening {
    /// Whether it listens at all.
    pub on: bool,
    /// Serial number of the receiver; absent until it has written a line.
    pub receiver: Option<u32>,
    /// Frequency listened to (kHz).
    pub frequency_khz: Option<u8>,
    /// Number of the set of codings that it decodes, as Thelma Biotel counts them (LM).
    pub protocols: Option<u8>,
    /// The vessel's own thrust, of the stronger motor, as a share of the greatest without direction (0 to 1).
    pub thrust: Option<f64>,
    /// Speed of the vessel's faster propeller (rpm, without direction).
    pub propeller_rpm: Option<f64>,
    /// What is known of its clock; absent until anything is.
    pub clock: Option<ClockState>,
    /// How far its clock is behind the vessel's, with the shortest delay of a line in it (s): while that stays the clock runs as
    /// the vessel's does. A line comes when its train of pulses is over, some three to four seconds after its stamp.
    pub clock_offset_s: Option<f64>,
    /// How far the hydrophone hangs below the antenna whose place detections start from (m).
    pub below_antenna_m: Option<f64>,
}

impl Listening {
    /// As an Event, a tuple list of these names: `listening` (`on`, `off`), `receiver`, `frequency_khz`, `protocols`,
    /// `thrust_percent`, `propeller_rpm`, `clock` (the words of [`Detection::report`](crate::Detection::report)),
    /// `clock_offset_s`, `below_antenna_m`. Unknown values are left out.
    pub fn report(&self) -> Event {
        let mut list = List::default();
        list.put("listening", if self.on { "on" } else { "off" });
        list.known("receiver", self.receiver);
        list.known("frequency_khz", self.frequency_khz);
        list.known("protocols", self.protocols);
        list.known("thrust_percent", self.thrust.map(|share| format!("{:.0}", share * 100.0)));
        list.known("propeller_rpm", self.propeller_rpm.map(|rpm| format!("{rpm:.0}")));
        list.known("clock", self.clock.map(ClockState::word));
        list.known("clock_offset_s", self.clock_offset_s.map(|offset_s| format!("{offset_s:.3}")));
        list.known("below_antenna_m", self.below_antenna_m.map(|down_m| format!("{down_m:.2}")));
        Event { topic: LISTENING_TOPIC.into(), data: list.0.into() }
    }

    /// The report in an Event; `None` when its topic is another, or when it does not say whether the receiver listens.
    pub fn from_report(event: &Event) -> Option<Self> {
        if event.topic != LISTENING_TOPIC {
            return None;
        }
        let list = event.data.to_str_lossy();
        let within =
            |name, most: f64| tuples::number(&list, name).filter(|value: &f64| (0.0..=most).contains(value));
        Some(Self {
            on: match tuples::get(&list, "listening")? {
                "on" => true,
                "off" => false,
                _ => return None,
            },
            receiver: number(&list, "receiver"),
            frequency_khz: number(&list, "frequency_khz"),
            protocols: number(&list, "protocols"),
            thrust: within("thrust_percent", 100.0).map(|percent| percent / 100.0),
            propeller_rpm: within("propeller_rpm", 1e6),
            clock: tuples::get(&list, "clock").and_then(ClockState::of_word),
            clock_offset_s: tuples::number(&list, "clock_offset_s"),
            below_antenna_m: tuples::number(&list, "below_antenna_m"),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_report_tells_all_of_it_and_leaves_out_what_is_not_known() {
        let whole = Listening {
            on: true,
            receiver: Some(25),
            frequency_khz: Some(69),
            protocols: Some(8),
            thrust: Some(0.4),
            propeller_rpm: Some(420.0),
            clock: Some(ClockState::Disciplined),
            clock_offset_s: Some(3.602),
            below_antenna_m: Some(1.25),
        };
        assert_eq!(Listening::from_report(&whole.report()), Some(whole));
        let off = Listening::default().report();
        assert_eq!(off.data, "listening=off");
        assert_eq!(Listening::from_report(&off), Some(Listening::default()));
        let other = Event { topic: crate::TOPIC.into(), ..off };
        assert_eq!(Listening::from_report(&other), None);
    }

    proptest! {
        #[test]
        fn any_text_is_a_report_or_none(data in "(\\PC|[;=%.0-9-]){0,100}") {
            for data in [data.clone(), format!("listening=on;{data}")] {
                let event = Event { topic: LISTENING_TOPIC.into(), data: data.as_str().into() };
                if let Some(told) = Listening::from_report(&event) {
                    let again = Listening::from_report(&told.report()).unwrap();
                    prop_assert_eq!(again.report(), told.report());
                }
            }
        }
    }
}
