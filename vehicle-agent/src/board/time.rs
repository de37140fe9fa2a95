//! GNSS time: the pulse per second as the kernel records it, and the receiver's messages for chrony.
//!
//! The kernel keeps the last pulse of a source in a text file, `/sys/class/pps/pps0/assert` for `/dev/pps0`: the computer's
//! clock at that moment and a count (`1700000000.000001234#57`). Chrony's SOCK source takes datagrams of C's
//! `struct sock_sample` (chrony.conf(5), refclock SOCK).

use super::post::{Post, Shown};
use crate::io::Report;
use devices::{PulseReading, Reading};
use drivers::Note;
use std::os::unix::net::UnixDatagram;
use std::path::{Path, PathBuf};
use std::time::Duration;
use units::{MonoTime, Now, UtcTime};

/// How often the kernel's record is read: a pulse is seen within a tenth of its second.
const EVERY: Duration = Duration::from_millis(100);
/// How soon an absent file or socket is tried again.
const AGAIN: Duration = Duration::from_secs(10);
/// Chrony takes a sample a second at most.
const SAMPLE_EVERY: Duration = Duration::from_secs(1);

/// Reads the kernel's record of the pulse.
pub(super) struct PulsePost {
    file: PathBuf,
    clock: crate::clock::Clock,
    last: Option<u32>,
    due: MonoTime,
    absent: bool,
}

impl PulsePost {
    /// The pulse of a device such as `/dev/pps0`; any other path is a file in the kernel's format.
    pub(super) fn new(device: &str, clock: crate::clock::Clock) -> Self {
        let source = device.strip_prefix("/dev/").filter(|name| name.starts_with("pps"));
        let file = source
            .map_or_else(|| device.into(), |name| Path::new("/sys/class/pps").join(name).join("assert"));
        Self { file, clock, last: None, due: MonoTime::default(), absent: false }
    }

    fn look(&mut self, now: Now) -> Result<Option<PulseReading>, String> {
        let text = std::fs::read_to_string(&self.file).map_err(|error| {
            format!("the pulse per second cannot be read from {}: {error}", self.file.display())
        })?;
        let reading = noted(&text).ok_or_else(|| {
            format!("{} has no pulse of the kernel's form: {:?}", self.file.display(), text.trim())
        })?;
        let news = self.last.replace(reading.sequence).is_some_and(|last| last != reading.sequence);
        // A pulse from before the start, or from before the clock was set, is not valid now.
        Ok(Some(reading).filter(|_| news && (now.utc - reading.utc).abs() < 1_000_000))
    }
}

impl Post for PulsePost {
    fn turn(&mut self, now: MonoTime, _: &Shown) -> Vec<Report> {
        if now < self.due {
            return Vec::new();
        }
        let moment = self.clock.now();
        match self.look(moment) {
            Ok(reading) => {
                self.absent = false;
                self.due = now + EVERY;
                reading.map(|reading| Report::Reading(moment, Reading::Pulse(reading))).into_iter().collect()
            }
            Err(text) => {
                self.due = now + AGAIN;
                let first = !std::mem::replace(&mut self.absent, true);
                first.then_some(Report::Note(Note { warning: true, text })).into_iter().collect()
            }
        }
    }

    fn due(&self) -> Option<MonoTime> {
        Some(self.due)
    }

    fn end(&mut self, _: bool) {}
}

/// Parses the kernel's record: seconds and nanoseconds of the computer's clock, and the count.
fn noted(text: &str) -> Option<PulseReading> {
    let (time, sequence) = text.trim().split_once('#')?;
    let (seconds, nanos) = time.split_once('.')?;
    let (seconds, nanos): (i64, i64) = (seconds.parse().ok()?, nanos.parse().ok()?);
    // A source that never had a pulse gives zero.
    let valid = (1..=9_000_000_000).contains(&seconds) && (0..1_000_000_000).contains(&nanos);
    let micros = seconds.checked_mul(1_000_000)?.checked_add((nanos + 500) / 1000)?;
    valid.then_some(())?;
    Some(PulseReading { utc: UtcTime::from_micros(micros), sequence: sequence.parse().ok()? })
}

/// Gives chrony the time of the receiver's messages.
pub(super) struct ChronyPost {
    socket: PathBuf,
    sent: Option<UtcTime>,
    due: MonoTime,
    absent: bool,
}

impl ChronyPost {
    pub(super) fn new(socket: &str) -> Self {
        Self { socket: socket.into(), sent: None, due: MonoTime::default(), absent: false }
    }

    fn send(&self, at: UtcTime, ahead_us: i64) -> std::io::Result<()> {
        let from = UnixDatagram::unbound()?;
        // A sample that chrony does not take at once is lost: this thread also feeds the watchdog and must not block.
        from.set_nonblocking(true)?;
        from.send_to(&sample(at, ahead_us), &self.socket).map(|_| ())
    }
}

impl Post for ChronyPost {
    fn turn(&mut self, now: MonoTime, shown: &Shown) -> Vec<Report> {
        let Some((at, ahead_us)) = shown.vitals.satellite_time.filter(|(at, _)| self.sent != Some(*at))
        else {
            return Vec::new();
        };
        if now < self.due {
            return Vec::new();
        }
        self.sent = Some(at);
        match self.send(at, ahead_us) {
            Ok(()) => {
                self.due = now + SAMPLE_EVERY;
                let back = std::mem::take(&mut self.absent);
                let text = "chrony takes the satellites' time".to_owned();
                back.then_some(Report::Note(Note { warning: false, text })).into_iter().collect()
            }
            Err(error) => {
                self.due = now + AGAIN;
                let first = !std::mem::replace(&mut self.absent, true);
                let text = format!(
                    "chrony does not take the satellites' time at {} ({error}): see whether it runs with Lutra's \
                     configuration",
                    self.socket.display()
                );
                first.then_some(Report::Note(Note { warning: true, text })).into_iter().collect()
            }
        }
    }

    fn due(&self) -> Option<MonoTime> {
        None
    }

    fn end(&mut self, _: bool) {}
}

/// `struct sock_sample` of a 64-bit computer, whose byte order it has: the computer's time of the sample (seconds,
/// microseconds), the true time minus it (s), no pulse, no leap second, padding, and the magic number "SOCK".
fn sample(at: UtcTime, ahead_us: i64) -> Vec<u8> {
    let (seconds, micros) = (at.micros().div_euclid(1_000_000), at.micros().rem_euclid(1_000_000));
    let mut bytes = Vec::with_capacity(40);
    bytes.extend(seconds.to_ne_bytes());
    bytes.extend(micros.to_ne_bytes());
    bytes.extend((ahead_us as f64 / 1e6).to_ne_bytes());
    for field in [0_i32, 0, 0, 0x534F_434B] {
        bytes.extend(field.to_ne_bytes());
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clock::Clock;
    use onboard::Vitals;
    use std::sync::Arc;
    use std::sync::atomic::{AtomicI64, Ordering};

    #[test]
    fn the_kernels_note_is_read_to_the_microsecond() {
        let reading = |micros, sequence| Some(PulseReading { utc: UtcTime::from_micros(micros), sequence });
        assert_eq!(noted("1700000000.000001234#57\n"), reading(1_700_000_000_000_001, 57));
        assert_eq!(noted("1700000000.999999700#4294967295"), reading(1_700_000_001_000_000, u32::MAX));
        for broken in [
            "",
            "0.000000000#0",
            "1700000000#5",
            "1700000000.5",
            "x.5#1",
            "1.-5#1",
            "99999999999.0#1",
            "1.0#99999999999",
        ] {
            assert_eq!(noted(broken), None, "{broken}");
        }
    }

    #[test]
    fn each_pulse_is_read_once_and_an_absent_file_is_told_once() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("assert");
        let utc = Arc::new(AtomicI64::new(0));
        let shown_utc = Arc::clone(&utc);
        let clock =
            Clock::of(|| Duration::ZERO, move || UtcTime::from_micros(shown_utc.load(Ordering::Relaxed)));
        let mut post = PulsePost::new(file.to_str().unwrap(), clock);
        let mut turn = |at_s: u64| {
            utc.store(1_700_000_000_000_000 + at_s as i64 * 1_000_000, Ordering::Relaxed);
            post.turn(MonoTime::from_micros(at_s * 1_000_000), &Shown::default())
        };
        assert!(matches!(&turn(0)[..], [Report::Note(Note { warning: true, .. })]));
        assert!(turn(11).is_empty(), "told once");
        std::fs::write(&file, "1700000015.000000000#4\n").unwrap();
        assert!(turn(22).is_empty(), "one from before the start");
        std::fs::write(&file, "1700000023.000002000#5\n").unwrap();
        let read = turn(23);
        assert!(
            matches!(&read[..], [Report::Reading(_, Reading::Pulse(PulseReading { sequence: 5, .. }))]),
            "{read:?}"
        );
        assert!(turn(24).is_empty());
    }

    #[test]
    fn chrony_gets_each_time_once_and_its_absence_is_told_once() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("lutra.sock");
        let mut post = ChronyPost::new(path.to_str().unwrap());
        let mut turn = |at_s: u64, told: i64| {
            let satellite_time = Some((UtcTime::from_micros(told), -300_000));
            let vitals = Vitals { satellite_time, ..Vitals::default() };
            post.turn(MonoTime::from_micros(at_s * 1_000_000), &Shown { vitals, ..Shown::default() })
        };
        assert!(matches!(&turn(0, 1)[..], [Report::Note(Note { warning: true, .. })]));
        assert!(turn(11, 2).is_empty());
        let chrony = UnixDatagram::bind(&path).unwrap();
        assert!(matches!(&turn(22, 1_700_000_000_250_000)[..], [Report::Note(Note { warning: false, .. })]));
        turn(23, 1_700_000_000_250_000);
        let mut bytes = [0; 100];
        assert_eq!(chrony.recv(&mut bytes).unwrap(), 40);
        assert_eq!(bytes[..8], 1_700_000_000_i64.to_ne_bytes());
        assert_eq!(bytes[8..16], 250_000_i64.to_ne_bytes());
        assert_eq!(bytes[16..24], (-0.3_f64).to_ne_bytes());
        chrony.set_nonblocking(true).unwrap();
        assert!(chrony.recv(&mut bytes).is_err(), "the same time is not a second sample");
    }
}
