//! The commands that the compass obeys: which sentences it sends, how often, at which speed, and what it answers.
//!
//! Commands are those of Hemisphere's Technical Reference that the boats use: `$JASC` (one sentence at a rate, 0 is off),
//! `$JOFF` (none at all), `$JATT,NMEAHE` (talker of the heading's sentences), `$JBAUD` (speed of the line), `$JSAVE`.
//! Each ends in CR or LF and has no checksum; what is obeyed is answered by a line that begins with `$>`, anything else is left
//! alone. What was not saved is forgotten without power. Assumed, for no manual at hand says it: a rate that the receiver does
//! not have is left alone too, and before its first command the receiver sends nothing.

use devices::nmea::{Sentence, Talker};
use std::collections::BTreeMap;

/// The longest command kept; anything longer is noise.
const LONGEST: usize = 80;
/// Speeds of the line (bit/s).
const SPEEDS: [u32; 6] = [4_800, 9_600, 19_200, 38_400, 57_600, 115_200];
/// Rates of a sentence (Hz) and the time between two of it (µs).
const RATES: [(&str, i64); 7] = [
    ("20", 50_000),
    ("10", 100_000),
    ("5", 200_000),
    ("2", 500_000),
    ("1", 1_000_000),
    ("0.2", 5_000_000),
    (".2", 5_000_000),
];

/// The output of a receiver before any command.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum AtFirst {
    /// The sentences of the boats at each epoch, as a receiver that was set up and saved it.
    #[default]
    Usual,
    /// Nothing: a receiver whose sentences are all off.
    Nothing,
}

/// The receiver's settings.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Settings {
    /// Time between two of a sentence (µs).
    periods_us: BTreeMap<Sentence, i64>,
    /// The talker of the heading's sentences.
    talker: Talker,
    /// Speed of the line (bit/s).
    baud: u32,
}

/// The settings of a receiver that is at work, and those that it saved.
#[derive(Debug, Clone)]
pub(crate) struct CompassSettings {
    /// Time between two epochs of the receiver (µs).
    epoch_us: i64,
    used: Settings,
    saved: Settings,
    text: Vec<u8>,
}

impl CompassSettings {
    /// A receiver with an epoch each `epoch_us`, at this speed of its line (bit/s).
    pub(crate) fn new(at_first: AtFirst, epoch_us: i64, baud: u32) -> Self {
        let (periods_us, talker) = match at_first {
            AtFirst::Usual => (Sentence::EPOCH.map(|sentence| (sentence, epoch_us)).into(), Talker::Gp),
            AtFirst::Nothing => (BTreeMap::new(), Talker::He),
        };
        let settings = Settings { periods_us, talker, baud };
        Self { epoch_us, used: settings.clone(), saved: settings, text: Vec::new() }
    }

    /// Speed of the line (bit/s); 0 sends without delay.
    pub(crate) const fn baud(&self) -> u32 {
        self.used.baud
    }

    /// The talker of the heading's sentences.
    pub(crate) const fn talker(&self) -> Talker {
        self.used.talker
    }

    /// The sentences of the epoch at this UTC (µs), in their order.
    pub(crate) fn due(&self, epoch_us: i64) -> impl Iterator<Item = Sentence> {
        let periods_us = &self.used.periods_us;
        Sentence::ALL.into_iter().filter(move |sentence| {
            periods_us.get(sentence).is_some_and(|period_us| epoch_us.rem_euclid(*period_us) == 0)
        })
    }

    /// The power was away: what was not saved is forgotten.
    pub(crate) fn restart(&mut self) {
        self.used = self.saved.clone();
        self.text.clear();
    }

    /// Takes bytes that were sent to the receiver; its answers.
    pub(crate) fn receive(&mut self, bytes: &[u8]) -> Vec<u8> {
        let mut answers = Vec::new();
        for &byte in bytes {
            match byte {
                b'$' => self.text = vec![byte],
                b'\r' | b'\n' => {
                    let text = std::mem::take(&mut self.text);
                    let answer = self.obey(&String::from_utf8_lossy(&text)).unwrap_or_default();
                    answers.extend(answer.bytes());
                }
                _ if self.text.len() < LONGEST => self.text.push(byte),
                _ => self.text.clear(),
            }
        }
        answers
    }

    /// Carries a command out and returns the answer; `None` for a command that the receiver does not have.
    fn obey(&mut self, command: &str) -> Option<&'static str> {
        const DONE: &str = "$>\r\n";
        let fields: Vec<&str> = command.split(',').collect();
        match fields[..] {
            ["$JASC", name, rate] => self.set_rate(Sentence::named(name)?, rate)?,
            ["$JOFF"] => self.used.periods_us.clear(),
            ["$JATT", "NMEAHE", choice] => {
                self.used.talker = match choice {
                    "0" => Talker::Gp,
                    "1" => Talker::He,
                    _ => return None,
                };
                return Some("$>JATT,NMEAHE,OK\r\n");
            }
            ["$JBAUD", speed] => {
                self.used.baud = speed.parse().ok().filter(|baud| SPEEDS.contains(baud))?;
            }
            ["$JSAVE"] => {
                self.saved = self.used.clone();
                return Some("$> Saving Configuration. Please Wait...\r\n$> Save Complete\r\n");
            }
            // The pulse is not simulated here; the receiver takes its width all the same.
            ["$JPPS", ..] => {}
            _ => return None,
        }
        Some(DONE)
    }

    /// Has a sentence sent at a rate that the receiver has.
    fn set_rate(&mut self, sentence: Sentence, rate: &str) -> Option<()> {
        if rate == "0" {
            self.used.periods_us.remove(&sentence);
            return Some(());
        }
        let (_, period_us) = RATES.into_iter().find(|(text, _)| *text == rate)?;
        (period_us % self.epoch_us == 0).then(|| self.used.periods_us.insert(sentence, period_us))?;
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEN_HZ_US: i64 = 100_000;

    fn told(commands: &str) -> (CompassSettings, String) {
        let mut settings = CompassSettings::new(AtFirst::Nothing, TEN_HZ_US, 19_200);
        let answers = settings.receive(commands.as_bytes());
        (settings, String::from_utf8(answers).unwrap())
    }

    #[test]
    fn sentences_come_at_the_rates_that_were_ordered() {
        let (settings, answers) = told("$JASC,GPGGA,5\r\n$JASC,GPHPR,1\r\n$JASC,GPZDA,.2\r\n");
        assert_eq!(answers, "$>\r\n".repeat(3));
        let count = |wanted| {
            (0..100)
                .filter(|epoch| settings.due(epoch * TEN_HZ_US).any(|sentence| sentence == wanted))
                .count()
        };
        assert_eq!([Sentence::Gga, Sentence::Hpr, Sentence::Zda, Sentence::Hdt].map(count), [50, 10, 2, 0]);
    }

    #[test]
    fn what_is_no_command_of_the_receiver_changes_nothing_and_has_no_answer() {
        let (before, _) = told("$JASC,GPGGA,1\r\n");
        for wrong in [
            "$JASC,GPGGB,1\r\n",
            "$JASC,GPVTG,3\r\n",
            "$JASC,GPVTG,20\r\n",
            "$JASC,GPVTG\r\n",
            "JASC,GPVTG,1\r\n",
            "$jasc,GPVTG,1\r\n",
            "$JBAUD,12345\r\n",
            "$JATT,NMEAHE,2\r\n",
            "$JASC,GPVTG,1",
        ] {
            let (settings, answers) = told(&format!("$JASC,GPGGA,1\r\n{wrong}"));
            assert_eq!((&settings.used, answers.as_str()), (&before.used, "$>\r\n"), "{wrong}");
        }
    }

    #[test]
    fn only_what_was_saved_outlives_the_power() {
        let (mut settings, answers) =
            told("$JASC,GPGGA,1\r\n$JATT,NMEAHE,0\r\n$JSAVE\r\n$JASC,GPVTG,1\r\n$JBAUD,115200\r\n");
        assert!(answers.contains("$>JATT,NMEAHE,OK\r\n") && answers.contains("Save Complete"), "{answers}");
        assert_eq!(settings.due(0).collect::<Vec<_>>(), [Sentence::Gga, Sentence::Vtg]);
        assert_eq!((settings.baud(), settings.talker()), (115_200, Talker::Gp));
        settings.restart();
        assert_eq!(settings.due(0).collect::<Vec<_>>(), [Sentence::Gga]);
        assert_eq!((settings.baud(), settings.talker()), (19_200, Talker::Gp));
        settings.receive(b"$JOFF\r\n");
        assert_eq!(settings.due(0).count(), 0);
    }
}
