//! A refused leg read again from the sentence that [`LegCheck`](crate::LegCheck) makes of it.
//!
//! IMC has only a text field for why a vessel refuses a plan. The shore reads leg, reason and place from that text here,
//! beside the function that writes it, and passes them on as values: no other code parses the sentence.

use crate::{Part, Reason};
use charts::depth_index::Restriction;
use units::LatLon;

/// A refused leg as read from a sentence.
#[derive(Debug, Clone, PartialEq)]
pub struct ReportedLeg {
    /// Whose leg it is, such as the name of a maneuver.
    pub label: String,
    /// What the vessel does.
    pub part: Part,
    /// Number of the leg within the part, from 0.
    pub number: u32,
    /// Why it is refused. The sentence does not say which of the two depth limits a shallow leg
    /// breaks: [`Reason::TooShallow`] stands for both.
    pub reason: Reason,
    /// The worst spot, to the fifth decimal of a degree.
    pub at: LatLon,
    /// Least charted depth (m), to a decimal; negative where it dries.
    pub least_m: Option<f64>,
    /// Depth that is needed (m), to a decimal.
    pub needed_m: Option<f64>,
    /// Class of the chart object that decides.
    pub class: Option<String>,
    /// Cell that it is from.
    pub cell: Option<String>,
    /// Name of the area that may not be entered, where that is the reason.
    pub area: Option<String>,
}

impl ReportedLeg {
    /// The first leg in a sentence, with any text before and after it.
    pub fn find(text: &str) -> Option<Self> {
        // A label stands in quotes after a space, and may hold quotes itself.
        let opens = text.match_indices('\'').map(|(at, _)| at);
        let begins = opens.filter(|at| *at == 0 || text[..*at].ends_with(char::is_whitespace));
        begins.map(|at| &text[at + 1..]).find_map(Self::read)
    }

    /// The text after the quote before a label.
    fn read(text: &str) -> Option<Self> {
        text.match_indices("' (").find_map(|(end, _)| {
            let (part, rest) = text[end + 3..].split_once(' ')?;
            let (number, rest) = rest.split_once("): ")?;
            let (part, number) = (part_of(part)?, number.parse::<u32>().ok()?.checked_sub(1)?);
            rest.match_indices(" at ").find_map(|(cut, at)| {
                let (at, after) = place(&rest[cut + at.len()..])?;
                let What { reason, least_m, needed_m, area } = What::read(&rest[..cut])?;
                let (class, cell) = match &area {
                    Some(_) => (None, None),
                    None => object(after),
                };
                let (area, of_area) = area.unzip();
                let label = text[..end].to_owned();
                let cell = of_area.or(cell);
                Some(Self { label, part, number, reason, at, least_m, needed_m, class, cell, area })
            })
        })
    }
}

/// The fault of a leg.
struct What {
    reason: Reason,
    least_m: Option<f64>,
    needed_m: Option<f64>,
    /// The area that may not be entered, and its cell.
    area: Option<(String, String)>,
}

impl What {
    fn read(words: &str) -> Option<Self> {
        let plain = [
            ("land", Reason::Land),
            ("an obstacle", Reason::Obstacle),
            ("unknown depth", Reason::UnknownDepth),
            ("not charted", Reason::NoData),
            ("too low overhead", Reason::TooLow),
        ];
        if let Some((_, reason)) = plain.into_iter().find(|(known, _)| *known == words) {
            return Some(Self { reason, least_m: None, needed_m: None, area: None });
        }
        match words.strip_prefix("enters ") {
            Some(entered) => Restriction::ALL.into_iter().find_map(|one| Self::area(one, entered)),
            None => Self::depth(words),
        }
    }

    fn area(restriction: Restriction, entered: &str) -> Option<Self> {
        let named = entered.strip_prefix(restriction.words())?.strip_prefix(": ")?;
        let (name, cell) = named.strip_suffix(')')?.rsplit_once(" (")?;
        let area = Some((name.to_owned(), cell.to_owned()));
        Some(Self { reason: Reason::Entry(restriction), least_m: None, needed_m: None, area })
    }

    fn depth(words: &str) -> Option<Self> {
        let (water, needed) = words.split_once("; needs ")?;
        let needed_m = needed.strip_suffix(" m")?.parse().ok()?;
        let least_m: f64 = match water.strip_prefix("dries ") {
            Some(dries) => -dries.strip_suffix(" m")?.parse::<f64>().ok()?,
            None => water.strip_suffix(" m deep")?.parse().ok()?,
        };
        let (least_m, needed_m) = (Some(least_m), Some(needed_m));
        Some(Self { reason: Reason::TooShallow, least_m, needed_m, area: None })
    }
}

/// Class and cell of a chart object, as ` (DEPARE of XX5LUTRA)` names it.
fn object(text: &str) -> (Option<String>, Option<String>) {
    let named = text.strip_prefix(" (").and_then(|rest| rest.split_once(" of "));
    let named = named.and_then(|(class, rest)| Some((class.to_owned(), rest.split_once(')')?.0.to_owned())));
    named.unzip()
}

fn part_of(code: &str) -> Option<Part> {
    [Part::Transit, Part::Track, Part::Circle, Part::Station, Part::Drift]
        .into_iter()
        .find(|part| part.code() == code)
}

/// Latitude and longitude in degrees with five decimals, and what follows them.
fn place(text: &str) -> Option<(LatLon, &str)> {
    let (lat, rest) = degrees(text)?;
    let (lon, rest) = degrees(rest.strip_prefix(", ")?)?;
    Some((LatLon::from_deg(lat, lon).ok()?, rest))
}

fn degrees(text: &str) -> Option<(f64, &str)> {
    let point = text.find('.')?;
    let (number, rest) = text.split_at_checked(point + 6)?;
    let plain = number
        .bytes()
        .enumerate()
        .all(|(at, byte)| byte.is_ascii_digit() || at == point || (at == 0 && byte == b'-'));
    Some((number.parse().ok().filter(|_| plain)?, rest))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Entered, LegCheck, Spot};

    fn spot(least_m: Option<f64>, margin_m: Option<f64>) -> Spot {
        Spot {
            at: LatLon::from_deg(63.440_12, -10.350_01).unwrap(),
            least_m,
            margin_m,
            class: Some("DEPARE"),
            name: None,
            record: None,
            cell: Some("XX5LUTRA".to_owned()),
            edition: None,
            scale: None,
            zone: None,
        }
    }

    fn leg(label: &str, reason: Reason, spot: Spot) -> LegCheck {
        let (part, at) = (Part::Track, spot.at);
        let restriction = if let Reason::Entry(restriction) = reason { Some(restriction) } else { None };
        let named = Spot { name: Some("Birds at Tautra (west)".to_owned()), ..spot.clone() };
        let area = restriction.map(|restriction| Entered { restriction, spot: named });
        let (label, reason) = (label.to_owned(), Some(reason));
        LegCheck { label, part, number: 2, from: at, to: at, half_width_m: 5.0, reason, spot, area }
    }

    /// Text around the sentence as it comes from a vessel.
    fn around(leg: &LegCheck) -> String {
        format!("late: the vessel's guard refuses: {leg} (and 2 more legs)")
    }

    #[test]
    fn every_reason_that_is_written_is_read_again() {
        let restricted = Restriction::ALL.map(Reason::Entry);
        let plain = [Reason::Land, Reason::Obstacle, Reason::UnknownDepth, Reason::NoData, Reason::TooLow];
        for reason in plain.into_iter().chain(restricted) {
            for label in ["P2", "Bird's nest", "a' (b)", "'", "the way at 63.00000, 10.00000"] {
                let leg = leg(label, reason, spot(None, None));
                let told = ReportedLeg::find(&around(&leg)).unwrap_or_else(|| panic!("{leg}"));
                assert_eq!((&told.label[..], told.part, told.number), (label, Part::Track, 2), "{leg}");
                assert_eq!((told.reason, told.least_m), (reason, None), "{leg}");
                assert!((told.at.lat_deg() - 63.440_12).abs() < 1e-9, "{leg}");
                assert!((told.at.lon_deg() + 10.350_01).abs() < 1e-9, "{leg}");
                let entry = matches!(reason, Reason::Entry(_));
                assert_eq!(told.area.as_deref(), entry.then_some("Birds at Tautra (west)"), "{leg}");
                assert_eq!(told.class.as_deref(), (!entry).then_some("DEPARE"), "{leg}");
                assert_eq!(told.cell.as_deref(), Some("XX5LUTRA"), "{leg}");
            }
        }
    }

    #[test]
    fn depths_are_read_with_what_is_needed_above_and_below_chart_datum() {
        for (least_m, margin_m) in [(2.5, -2.5), (-0.4, -5.4), (0.0, -5.0)] {
            for reason in [Reason::TooShallow, Reason::TooShallowAlone] {
                let leg = leg("P2", reason, spot(Some(least_m), Some(margin_m)));
                let told = ReportedLeg::find(&around(&leg)).unwrap();
                assert_eq!(told.reason, Reason::TooShallow);
                assert!((told.least_m.unwrap() - least_m).abs() < 0.06, "{leg}");
                assert!((told.needed_m.unwrap() - 5.0).abs() < 0.06, "{leg}");
            }
        }
    }

    #[test]
    fn nothing_else_is_taken_for_a_leg() {
        let none = [
            "",
            "'",
            "Take control first.",
            "the vessel was at 63.44012, 10.35001",
            "'P2' (transit 1): land at 99.00000, 10.35000",
            "'P2' (transit 1): land at 63.4, 10.3",
            "'P2' (transit 0): land at 63.44000, 10.35000",
            "'P2' (dance 1): land at 63.44000, 10.35000",
            "'P2' (transit 1): cheese at 63.44000, 10.35000",
            "'P2' (transit 1): land at 63.4400ø, 10.35000",
        ];
        for text in none {
            assert_eq!(ReportedLeg::find(text), None, "{text}");
        }
    }
}
