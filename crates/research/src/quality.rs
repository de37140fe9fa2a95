//! Why a detection is doubtful. Doubtful detections are flagged, never left out.

use crate::study::{Heard, confirming_s};
use api::{DetectionFlag, FlagCode};
use detections::{ClockState, Detection};

/// A receiver's clock that is further from the vessel's is off (µs). A line comes some seconds after its tag was heard.
const CLOCK_OFF_US: i64 = 3_600_000_000;
/// A place that was measured further away in time is old (s): a boat of 2 m/s is 20 m away by then.
const OLD_PLACE_S: f64 = 10.0;

/// All flags that follow from a detection alone, as bits: 1 shifted by the place in this list.
pub(crate) const MARKS: [FlagCode; 6] = [
    FlagCode::ClockNotSet,
    FlagCode::ClockLost,
    FlagCode::ClockOff,
    FlagCode::NoPlace,
    FlagCode::OldPlace,
    FlagCode::LinesLost,
];

/// The bit of [`FlagCode::ClockOff`].
pub(crate) const CLOCK_OFF: u8 = 1 << 2;
/// The bits of [`FlagCode::ClockNotSet`], [`FlagCode::ClockLost`] and [`FlagCode::ClockOff`].
pub(crate) const CLOCK_WRONG: u8 = 1 | 1 << 1 | CLOCK_OFF;

/// Whether a flag follows from a detection alone. The one that needs its neighbours is [`Heard::doubt`].
fn has(one: &Detection, code: FlagCode) -> bool {
    match code {
        FlagCode::Unconfirmed => false,
        FlagCode::ClockNotSet => one.clock.state == ClockState::NotSet,
        FlagCode::ClockLost => one.clock.state == ClockState::Lost,
        FlagCode::ClockOff => clock_off_us(one).is_some_and(|off_us| off_us > CLOCK_OFF_US),
        FlagCode::NoPlace => one.pose.is_none(),
        FlagCode::OldPlace => one.pose.and_then(|pose| pose.age_s).is_some_and(|age_s| age_s > OLD_PLACE_S),
        FlagCode::LinesLost => one.effort.lines_lost.is_some_and(|lines| lines > 0),
    }
}

/// How far the receiver's clock is from the vessel's (µs); absent where it is not set.
fn clock_off_us(one: &Detection) -> Option<i64> {
    let heard_us = one.clock.utc()?.micros();
    Some(heard_us.saturating_sub(one.origin.reported.micros()).saturating_abs())
}

/// The flags that follow from a detection alone, one bit each, as in [`MARKS`].
pub(crate) fn marks(one: &Detection) -> u8 {
    MARKS.iter().enumerate().filter(|(_, code)| has(one, **code)).fold(0, |marks, (at, _)| marks | 1 << at)
}

impl Heard<'_> {
    /// Its flags, with their reasons.
    pub fn flags(&self) -> Vec<DetectionFlag> {
        let one = self.detection;
        let doubted = self.doubt().is_some().then_some(FlagCode::Unconfirmed);
        let own = MARKS.into_iter().filter(|code| has(one, *code));
        doubted.into_iter().chain(own).map(|code| self.flag(code)).collect()
    }

    fn flag(&self, code: FlagCode) -> DetectionFlag {
        let one = self.detection;
        let (reason, figure) = match code {
            FlagCode::Unconfirmed => (self.doubt().unwrap_or_default(), self.tag.and_then(confirming_s)),
            FlagCode::ClockNotSet => (
                "the receiver's clock was never set: the time is the vessel's, when the line came".to_owned(),
                None,
            ),
            FlagCode::ClockLost => (
                "the receiver's clock was lost: the time is the vessel's, when the line came".to_owned(),
                None,
            ),
            FlagCode::ClockOff => {
                let off_s = clock_off_us(one).unwrap_or_default() as f64 / 1e6;
                (format!("the receiver's clock is {off_s:.0} s off the vessel's"), Some(off_s))
            }
            FlagCode::NoPlace => ("the vessel did not know where it was".to_owned(), None),
            FlagCode::OldPlace => {
                let age_s = one.pose.and_then(|pose| pose.age_s).unwrap_or_default();
                (format!("the nearest measured position is {age_s:.0} s away"), Some(age_s))
            }
            FlagCode::LinesLost => {
                let lines = one.effort.lines_lost.unwrap_or_default();
                (format!("{lines} lines of the receiver were lost right before"), Some(lines.into()))
            }
        };
        DetectionFlag { code, reason, figure }
    }
}
