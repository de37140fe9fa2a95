//! Bytes to be sent: in order, at their time, and no faster than the device accepts them.
//!
//! One slot is for bytes of which only the newest counts, such as motor commands: they go ahead of all others, and are
//! dropped once they are too old. So a port that was blocked for a while does not send a stale command afterwards.

use std::collections::VecDeque;
use std::time::Duration;
use units::MonoTime;

/// Most queued bytes. Settings and clock commands of a device are some hundred bytes; a port that is blocked for longer is
/// as good as lost.
const MOST_BYTES: usize = 16 << 10;

/// Queued bytes.
#[derive(Debug)]
struct Letter {
    bytes: Vec<u8>,
    sent: usize,
    /// When the next byte may leave.
    next: MonoTime,
    /// Time from one byte to the next.
    pace: Duration,
    /// Instead of bytes: a change of the line's speed (bit/s).
    speed: Option<u32>,
}

/// Bytes of which only the newest counts.
#[derive(Debug)]
struct Newest {
    bytes: Vec<u8>,
    until: Option<MonoTime>,
}

/// The queue of bytes to be sent.
#[derive(Debug, Default)]
pub(super) struct Outbox {
    newest: Option<Newest>,
    letters: VecDeque<Letter>,
    bytes: usize,
}

impl Outbox {
    /// Queues bytes to be sent from `at` on. Returns whether there was room: they are queued as a whole or not at all.
    pub(super) fn put(&mut self, bytes: Vec<u8>, at: MonoTime, pace: Duration) -> bool {
        let fits = self.bytes + bytes.len() <= MOST_BYTES;
        if fits && !bytes.is_empty() {
            self.bytes += bytes.len();
            self.letters.push_back(Letter { bytes, sent: 0, next: at, pace, speed: None });
        }
        fits
    }

    /// Queues a change of the line's speed (bit/s), from `at` on. Returns whether there was room.
    pub(super) fn put_speed(&mut self, baud: u32, at: MonoTime) -> bool {
        let fits = self.bytes < MOST_BYTES;
        if fits {
            // It counts as a byte, so that speed changes are limited too.
            self.bytes += 1;
            let speed = Some(baud);
            self.letters.push_back(Letter {
                bytes: Vec::new(),
                sent: 0,
                next: at,
                pace: Duration::ZERO,
                speed,
            });
        }
        fits
    }

    /// The speed to which the line changes now; returned once.
    pub(super) fn speed_due(&mut self, now: MonoTime) -> Option<u32> {
        let baud = self.letters.front().filter(|letter| letter.next <= now)?.speed?;
        self.letters.pop_front();
        self.bytes -= 1;
        Some(baud)
    }

    /// Queues bytes ahead of everything whose sending has not begun, replacing earlier ones of this kind. Their sending
    /// does not begin from `until` on.
    pub(super) fn put_newest(&mut self, bytes: Vec<u8>, until: Option<MonoTime>) {
        self.newest = Some(Newest { bytes, until }).filter(|newest| !newest.bytes.is_empty());
    }

    /// Bytes that may be written now; `None` if none are due.
    pub(super) fn due(&mut self, now: MonoTime) -> Option<&[u8]> {
        self.newest.take_if(|newest| newest.until.is_some_and(|until| until <= now));
        // A partial line or frame would corrupt the next one.
        if !self.has_begun()
            && let Some(newest) = &self.newest
        {
            return Some(&newest.bytes);
        }
        let letter = self.letters.front().filter(|letter| letter.next <= now && letter.speed.is_none())?;
        let rest = &letter.bytes[letter.sent..];
        Some(if letter.pace.is_zero() { rest } else { &rest[..1] })
    }

    /// `count` of the due bytes have been written.
    pub(super) fn sent(&mut self, now: MonoTime, count: usize) {
        if !self.has_begun()
            && let Some(Newest { bytes, .. }) = self.newest.take()
        {
            if count < bytes.len() {
                self.bytes += bytes.len() - count;
                let pace = Duration::ZERO;
                self.letters.push_front(Letter { bytes, sent: count, next: now, pace, speed: None });
            }
            return;
        }
        let Some(letter) = self.letters.front_mut() else { return };
        letter.sent += count;
        self.bytes -= count;
        // Counted from the actual sending of the last byte: late bytes are not sent faster.
        letter.next = now + letter.pace;
        if letter.sent >= letter.bytes.len() {
            self.letters.pop_front();
        }
    }

    /// Whether the first entry has been sent in part.
    fn has_begun(&self) -> bool {
        self.letters.front().is_some_and(|letter| letter.sent > 0)
    }

    /// When the next bytes are due; `None` when none wait.
    pub(super) fn next_due(&self) -> Option<MonoTime> {
        if self.newest.is_some() && !self.has_begun() {
            return Some(MonoTime::default());
        }
        self.letters.front().map(|letter| letter.next)
    }

    /// Clears the queue: its port is gone.
    pub(super) fn clear(&mut self) {
        *self = Self::default();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: Duration = Duration::from_millis(1);

    fn at(ms: u64) -> MonoTime {
        MonoTime::from_micros(ms * 1000)
    }

    #[test]
    fn paced_bytes_leave_one_by_one_from_their_instant_and_others_wait_behind() {
        let mut outbox = Outbox::default();
        assert!(outbox.put(b"(+)".to_vec(), at(100), MS));
        assert!(outbox.put(b"EX!".to_vec(), at(0), Duration::ZERO));
        assert_eq!(outbox.due(at(99)), None);
        assert_eq!(outbox.next_due(), Some(at(100)));
        let mut left = Vec::new();
        for ms in 100..110 {
            while let Some(bytes) = outbox.due(at(ms)) {
                let bytes = bytes.to_vec();
                outbox.sent(at(ms), bytes.len());
                left.push((ms, String::from_utf8(bytes).unwrap()));
            }
        }
        let expected = [(100, "("), (101, "+"), (102, ")"), (102, "EX!")];
        assert_eq!(left, expected.map(|(ms, text)| (ms, text.to_owned())));
        assert_eq!(outbox.next_due(), None);
    }

    /// Everything that is sent at once, piece by piece.
    fn all(outbox: &mut Outbox, now: MonoTime) -> Vec<String> {
        let mut left = Vec::new();
        while let Some(bytes) = outbox.due(now).map(<[u8]>::to_vec) {
            outbox.sent(now, bytes.len());
            left.push(String::from_utf8(bytes).unwrap());
        }
        left
    }

    #[test]
    fn of_commands_the_newest_leaves_alone_and_first_and_none_that_is_too_old() {
        let mut outbox = Outbox::default();
        outbox.put(b"power".to_vec(), at(0), Duration::ZERO);
        outbox.put_newest(b"ahead".to_vec(), Some(at(500)));
        outbox.put_newest(b"stop".to_vec(), None);
        assert_eq!(outbox.next_due(), Some(MonoTime::default()));
        assert_eq!(all(&mut outbox, at(10_000)), ["stop", "power"]);
        outbox.put_newest(b"ahead".to_vec(), Some(at(10_500)));
        outbox.put(b"power".to_vec(), at(0), Duration::ZERO);
        assert_eq!(all(&mut outbox, at(10_500)), ["power"]);
        assert_eq!((outbox.next_due(), outbox.bytes), (None, 0));
    }

    #[test]
    fn the_line_changes_its_speed_between_what_was_to_be_sent_before_and_after() {
        let mut outbox = Outbox::default();
        outbox.put(b"at the old".to_vec(), at(0), Duration::ZERO);
        assert!(outbox.put_speed(4_800, at(100)));
        outbox.put(b"at the new".to_vec(), at(0), Duration::ZERO);
        assert_eq!(outbox.speed_due(at(200)), None, "what was put before has not left");
        assert_eq!(all(&mut outbox, at(10)), ["at the old"]);
        assert_eq!((outbox.speed_due(at(99)), outbox.next_due()), (None, Some(at(100))));
        assert_eq!(outbox.due(at(100)), None);
        assert_eq!(outbox.speed_due(at(100)), Some(4_800));
        assert_eq!(outbox.speed_due(at(100)), None);
        assert_eq!(all(&mut outbox, at(100)), ["at the new"]);
        assert_eq!(outbox.bytes, 0);
        while outbox.put_speed(4_800, at(0)) {}
        assert_eq!(outbox.bytes, MOST_BYTES, "these do not pile up");
    }

    #[test]
    fn what_has_begun_to_leave_is_brought_to_its_end_before_a_newer_command() {
        let mut outbox = Outbox::default();
        outbox.put_newest(b"ahead".to_vec(), Some(at(500)));
        assert_eq!(outbox.due(at(0)), Some(&b"ahead"[..]));
        outbox.sent(at(0), 2);
        outbox.put_newest(b"stop".to_vec(), None);
        assert_eq!(all(&mut outbox, at(900)), ["ead", "stop"]);
        outbox.put(b"power".to_vec(), at(0), Duration::ZERO);
        outbox.sent(at(900), 2);
        outbox.put_newest(b"stop".to_vec(), None);
        assert_eq!((all(&mut outbox, at(900)), outbox.bytes), (vec!["wer".to_owned(), "stop".to_owned()], 0));
    }

    #[test]
    fn a_byte_that_is_late_does_not_hurry_the_next() {
        let mut outbox = Outbox::default();
        outbox.put(b"ab".to_vec(), at(0), MS);
        outbox.sent(at(50), 1);
        assert_eq!(outbox.due(at(50)), None);
        assert_eq!(outbox.due(at(51)), Some(&b"b"[..]));
    }

    #[test]
    fn a_port_that_takes_nothing_does_not_fill_the_memory() {
        let mut outbox = Outbox::default();
        assert!(outbox.put(vec![0; MOST_BYTES], at(0), Duration::ZERO));
        assert!(!outbox.put(vec![0], at(0), Duration::ZERO));
        outbox.sent(at(0), 10);
        assert!(outbox.put(vec![0; 10], at(0), Duration::ZERO));
        outbox.clear();
        assert!(outbox.due(at(1000)).is_none() && outbox.put(vec![0; MOST_BYTES], at(0), MS));
    }
}
