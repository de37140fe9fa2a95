//! The commands that set the hydrophone's clock and its settings, and how it answers them.
//!
//! `(+)` alone rounds the clock to the nearest ten seconds and is answered with `ack01`; `(+)` with nine digits
//! of Unix time and a Luhn digit sets it to that ten seconds, `ack02`; `UT=` with ten digits sets it to that
//! second, `ack03`. `LIVECM` enters command mode, where every command is echoed as the receiver's setting, and
//! `EX!` leaves it (DUNE task `Sensors.ThelmaHydrophone`, github.com/core-marine-dev/tb-live). Commands have no
//! line end: a pause ends them. Answers end in a carriage return.

/// A command to the receiver.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ClockCommand {
    /// The clock is to be rounded to the nearest ten seconds.
    Round,
    /// The clock is to be set to this Unix time, a whole ten seconds (s).
    SetTens(i64),
    /// The clock is to be set to this Unix time (s).
    SetSecond(i64),
    /// Command mode begins.
    EnterCommands,
    /// Command mode ends.
    LeaveCommands,
    /// Which firmware is it?
    Version,
    /// A setting; it has effect in command mode only.
    Setting(String),
}

impl ClockCommand {
    /// Reads a command; `None` for anything else, which the receiver does not answer.
    pub fn parse(text: &str) -> Option<Self> {
        if let Some(digits) = text.strip_prefix("(+)") {
            if digits.is_empty() {
                return Some(Self::Round);
            }
            let tens = ten_digits(digits).filter(|_| luhn_holds(digits))? / 10;
            return Some(Self::SetTens(tens * 10));
        }
        if let Some(digits) = text.strip_prefix("UT=") {
            return ten_digits(digits).map(Self::SetSecond);
        }
        match text {
            "LIVECM" => Some(Self::EnterCommands),
            "EX!" => Some(Self::LeaveCommands),
            "FV?" => Some(Self::Version),
            setting if setting.contains('=') => Some(Self::Setting(setting.to_owned())),
            _ => None,
        }
    }

    /// As it is sent: the time of the setting commands with its Luhn digit. A time beyond ten digits cannot be sent and is
    /// cut; the last second that can is in the year 2286.
    pub fn text(&self) -> String {
        match self {
            Self::Round => "(+)".to_owned(),
            Self::SetTens(seconds) => {
                let nine = format!("{:09}", seconds.div_euclid(10).clamp(0, 999_999_999));
                format!("(+){nine}{}", luhn_digit(&nine))
            }
            Self::SetSecond(seconds) => format!("UT={:010}", (*seconds).clamp(0, 9_999_999_999)),
            Self::EnterCommands => "LIVECM".to_owned(),
            Self::LeaveCommands => "EX!".to_owned(),
            Self::Version => "FV?".to_owned(),
            Self::Setting(setting) => setting.clone(),
        }
    }

    /// The receiver's answer once it has obeyed.
    pub fn answer(&self) -> Vec<u8> {
        let text = match self {
            Self::Round => "ack01",
            Self::SetTens(_) => "ack02",
            Self::SetSecond(_) => "ack03",
            Self::EnterCommands => "LIVECM",
            Self::LeaveCommands => "EX!",
            Self::Version => "FV=v1.0.6",
            Self::Setting(setting) => setting,
        };
        format!("{text}\r").into_bytes()
    }
}

fn ten_digits(text: &str) -> Option<i64> {
    (text.len() == 10 && text.bytes().all(|b| b.is_ascii_digit())).then(|| text.parse().ok()).flatten()
}

/// The Luhn digit of some digits.
fn luhn_digit(digits: &str) -> char {
    ('0'..='9').find(|digit| luhn_holds(&format!("{digits}{digit}"))).unwrap_or('0')
}

/// Whether the last of some digits is the Luhn digit of those before (ISO/IEC 7812-1, annex B).
fn luhn_holds(digits: &str) -> bool {
    let sum: u32 = digits
        .bytes()
        .rev()
        .enumerate()
        .map(|(place, byte)| {
            let value = u32::from(byte - b'0') * if place % 2 == 1 { 2 } else { 1 };
            if value > 9 { value - 9 } else { value }
        })
        .sum();
    sum.is_multiple_of(10)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_read_only_with_all_digits_and_the_right_luhn_digit() {
        for (text, expected) in [
            ("(+)", Some(ClockCommand::Round)),
            ("(+)1500000003", Some(ClockCommand::SetTens(1_500_000_000))),
            ("(+)1500000004", None),
            ("(+)150000000", None),
            ("UT=1500000004", Some(ClockCommand::SetSecond(1_500_000_004))),
            ("UT=12", None),
            ("noise", None),
        ] {
            assert_eq!(ClockCommand::parse(text), expected, "{text}");
        }
    }

    #[test]
    fn commands_are_sent_as_they_are_read() {
        for command in [
            ClockCommand::Round,
            ClockCommand::SetTens(1_500_000_000),
            ClockCommand::SetSecond(1_500_000_004),
            ClockCommand::EnterCommands,
            ClockCommand::LeaveCommands,
            ClockCommand::Version,
            ClockCommand::Setting("FC=69".to_owned()),
        ] {
            assert_eq!(ClockCommand::parse(&command.text()), Some(command));
        }
    }

    #[test]
    fn every_vector_of_the_clock_is_met() {
        let Some(path) = testkit::shared("data/onboard/tbr_sync_vectors.csv") else { return };
        for row in std::fs::read_to_string(path).unwrap().lines().skip(1) {
            let mut cells = row.split(',');
            let seconds = cells.next().unwrap().parse().unwrap();
            assert_eq!(ClockCommand::SetTens(seconds).text(), cells.next().unwrap());
        }
    }
}
