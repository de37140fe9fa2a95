//! Finds packets in a stream of bytes, however it is cut and whatever is between them.
//!
//! A packet is taken where sync, length and checksum agree. Everything else is damage: the search continues
//! one byte after the false start, so that no whole packet behind damage is ever lost, also when a damaged
//! length reaches over it. Finding the next packet costs one pass however many false starts there are.

use crate::crc::PrefixCrc;
use crate::header::{FOOTER_BYTES, FrameError, MAX_PACKET_BYTES, PacketView, SYNC};
use crate::wire::ByteOrder;
use std::ops::Range;

/// One finding in a stream.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Frame<'a> {
    /// A whole packet with a right checksum.
    Packet {
        /// Its first byte, counted from the start of the stream.
        offset: u64,
        /// The packet.
        view: PacketView<'a>,
    },
    /// Bytes that are not a packet.
    Damage(Damage),
}

/// A run of bytes that is not a packet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Damage {
    /// Its first byte, counted from the start of the stream.
    pub offset: u64,
    /// How many bytes it has.
    pub bytes: u64,
    /// What is wrong at its first byte.
    pub error: FrameError,
}

/// The packets and damage of bytes that are all there.
#[derive(Debug)]
pub struct Frames<'a> {
    bytes: &'a [u8],
    at: usize,
    search: Search,
}

impl<'a> Frames<'a> {
    /// Over a whole log, datagram or message.
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0, search: Search::default() }
    }
}

impl<'a> Iterator for Frames<'a> {
    type Item = Frame<'a>;

    #[inline]
    fn next(&mut self) -> Option<Frame<'a>> {
        let offset = self.at as u64;
        let rest = &self.bytes[self.at..];
        match self.search.step(rest, true) {
            Step::Packet { bytes, order } => {
                self.at += bytes;
                Some(Frame::Packet { offset, view: PacketView::checked_before(&rest[..bytes], order) })
            }
            Step::Damage { bytes, error } => {
                self.at += bytes;
                Some(Frame::Damage(Damage { offset, bytes: bytes as u64, error }))
            }
            Step::NeedMore => None,
        }
    }
}

/// The packets and damage of bytes that come bit by bit.
///
/// Holds at most one packet (64 KiB) and what was pushed since the last call of [`Self::next_frame`], or a
/// run of damage of at most 64 KiB more; a longer run is reported in pieces.
#[derive(Debug, Default)]
pub struct Deframer {
    buffer: Vec<u8>,
    /// Bytes of the buffer that were handed out.
    at: usize,
    /// Position of the buffer's first byte in the stream.
    base: u64,
    search: Search,
    ended: bool,
}

impl Deframer {
    /// At the start of a stream.
    pub fn new() -> Self {
        Self::default()
    }

    /// At byte `offset` of a stream.
    pub(crate) fn at(offset: u64) -> Self {
        Self { base: offset, ..Self::default() }
    }

    /// Appends bytes of the stream.
    pub fn push(&mut self, bytes: &[u8]) {
        if self.at > 0 {
            self.buffer.drain(..self.at);
            self.base += self.at as u64;
            self.at = 0;
        }
        self.buffer.extend_from_slice(bytes);
    }

    /// Gives up the packet that waits for its rest, if one does.
    ///
    /// A damaged length can claim 64 KiB, which on a slow link take seconds to come while whole packets wait
    /// behind it. Call this when [`Self::pending`] bytes have stood for longer than any real packet needs, or when
    /// [`Self::holds_packet`] says that they do.
    pub fn give_up(&mut self) {
        let rest = &self.buffer[self.at..];
        if !rest.is_empty() {
            self.search.give_up(rest);
        }
    }

    /// Whether a whole packet follows inside the one that waits for its rest, whose length is then damaged.
    pub fn holds_packet(&self) -> bool {
        let mut behind = Self::new();
        behind.push(self.buffer.get(self.at + 1..).unwrap_or_default());
        behind.finish();
        std::iter::from_fn(|| behind.find()).any(|found| matches!(found, Found::Packet { .. }))
    }

    /// Says that no more bytes come: what waits for its rest is damage.
    pub fn finish(&mut self) {
        self.ended = true;
    }

    /// The next packet or damage; `None` when more bytes are needed, or after [`Self::finish`] at the end.
    pub fn next_frame(&mut self) -> Option<Frame<'_>> {
        self.find().map(|found| self.frame(found))
    }

    /// As [`Self::next_frame`], without holding on to the buffer.
    pub(crate) fn find(&mut self) -> Option<Found> {
        let offset = self.base + self.at as u64;
        let start = self.at;
        match self.search.step(&self.buffer[start..], self.ended) {
            Step::Packet { bytes, order } => {
                self.at += bytes;
                Some(Found::Packet { offset, place: start..self.at, order })
            }
            Step::Damage { bytes, error } => {
                self.at += bytes;
                Some(Found::Damage(Damage { offset, bytes: bytes as u64, error }))
            }
            Step::NeedMore => None,
        }
    }

    /// What was found, until the next push.
    pub(crate) fn frame(&self, found: Found) -> Frame<'_> {
        match found {
            Found::Packet { offset, place, order } => {
                Frame::Packet { offset, view: PacketView::checked_before(&self.buffer[place], order) }
            }
            Found::Damage(damage) => Frame::Damage(damage),
        }
    }

    /// Bytes that were pushed and belong to nothing handed out yet.
    pub fn pending(&self) -> usize {
        self.buffer.len() - self.at
    }
}

/// A frame by its place in the buffer.
#[derive(Debug)]
pub(crate) enum Found {
    Packet { offset: u64, place: Range<usize>, order: ByteOrder },
    Damage(Damage),
}

enum Step {
    Packet { bytes: usize, order: ByteOrder },
    Damage { bytes: usize, error: FrameError },
    NeedMore,
}

/// The position of a run of damage, between two calls.
#[derive(Debug, Default)]
struct Search {
    run: Option<Run>,
    prefixes: PrefixCrc,
    /// Bytes that must pass without damage before checksums are taken one packet at a time again. Until then
    /// they come from the prefixes, so that false starts between real packets cost no more than one pass.
    wary_bytes: usize,
}

#[derive(Debug, Clone, Copy)]
struct Run {
    /// Bytes from its start that are certainly no packet's.
    bytes: usize,
    /// What is wrong at its start.
    error: FrameError,
    /// Where the damaged packet at its start says that it ends, if that is known.
    claimed_end: Option<usize>,
}

impl Search {
    /// What `bytes` start with. Until something is returned the next call must start with the same bytes, and
    /// afterwards with those behind what was returned.
    #[inline]
    fn step(&mut self, bytes: &[u8], ended: bool) -> Step {
        if self.run.is_none() {
            if bytes.is_empty() {
                return Step::NeedMore;
            }
            let first = if self.wary_bytes == 0 { PacketView::new(bytes) } else { self.wary(bytes, 0) };
            match first {
                Ok(view) => {
                    let (count, order) = (view.bytes().len(), view.order());
                    if self.wary_bytes > 0 {
                        self.consume(bytes, count);
                    }
                    return Step::Packet { bytes: count, order };
                }
                Err(FrameError::Truncated { .. }) if !ended => return Step::NeedMore,
                Err(error) => self.open(bytes, error),
            }
        }
        self.extend(bytes, ended)
    }

    /// The packet at `at`, with its checksum from the prefixes.
    fn wary<'a>(&mut self, bytes: &'a [u8], at: usize) -> Result<PacketView<'a>, FrameError> {
        let view = PacketView::unchecked(&bytes[at..])?;
        let computed = self.prefixes.range(bytes, at, at + view.bytes().len() - FOOTER_BYTES);
        let stated = view.stated_crc();
        if stated == computed { Ok(view) } else { Err(FrameError::BadCrc { stated, computed }) }
    }

    /// Starts a run of damage at the first byte.
    #[cold]
    fn open(&mut self, bytes: &[u8], error: FrameError) {
        let claimed_end = match error {
            FrameError::BadCrc { .. } => PacketView::unchecked(bytes).ok().map(|view| view.bytes().len()),
            FrameError::BadSync { .. } | FrameError::Truncated { .. } => None,
        };
        if self.wary_bytes == 0 {
            self.prefixes.clear();
        }
        self.wary_bytes = 2 * MAX_PACKET_BYTES;
        self.run = Some(Run { bytes: 1, error, claimed_end });
    }

    /// Looks for the end of the run of damage that `bytes` start with.
    #[cold]
    fn extend(&mut self, bytes: &[u8], ended: bool) -> Step {
        let Some(mut run) = self.run else { return Step::NeedMore };
        while run.bytes < bytes.len() {
            run.bytes += next_sync(&bytes[run.bytes..]);
            let left = bytes.len() - run.bytes;
            if left == 0 {
                break;
            }
            let ends = match self.wary(bytes, run.bytes) {
                Err(FrameError::BadSync { .. }) => false,
                // Half a sync number may still turn out to be something else.
                Err(_) if left == 1 && !ended => return self.wait(run),
                // A second damaged packet right behind the first is a run of its own.
                _ if run.claimed_end == Some(run.bytes) => true,
                Ok(_) => true,
                Err(FrameError::Truncated { .. }) if !ended && run.bytes < MAX_PACKET_BYTES => {
                    return self.wait(run);
                }
                // Report a long run in pieces rather than hold it.
                Err(FrameError::Truncated { .. }) => !ended,
                Err(FrameError::BadCrc { .. }) => false,
            };
            if ends {
                return self.close(bytes, run);
            }
            run.bytes += 1;
        }
        if ended || run.bytes >= MAX_PACKET_BYTES { self.close(bytes, run) } else { self.wait(run) }
    }

    fn wait(&mut self, run: Run) -> Step {
        self.run = Some(run);
        Step::NeedMore
    }

    fn close(&mut self, bytes: &[u8], run: Run) -> Step {
        self.run = None;
        self.prefixes.consume(bytes, run.bytes);
        Step::Damage { bytes: run.bytes, error: run.error }
    }

    /// A packet that `bytes` start with was returned while wary.
    fn consume(&mut self, bytes: &[u8], count: usize) {
        self.prefixes.consume(bytes, count);
        self.wary_bytes = self.wary_bytes.saturating_sub(count);
    }

    /// Continues behind the start of the packet that waits for its rest in `bytes`.
    fn give_up(&mut self, bytes: &[u8]) {
        match &mut self.run {
            None => {
                let need = PacketView::unchecked(bytes).err();
                let cut = FrameError::Truncated { need: bytes.len() + 1, have: bytes.len() };
                self.open(bytes, need.unwrap_or(cut));
            }
            Some(run) if run.bytes < bytes.len() => run.bytes += 1,
            Some(_) => {}
        }
    }
}

/// How many bytes to pass over to the next one where a sync number may start.
fn next_sync(bytes: &[u8]) -> usize {
    let [low, high] = SYNC.to_le_bytes();
    let start = |at: usize| match bytes.get(at + 1) {
        Some(&second) => (bytes[at] == low && second == high) || (bytes[at] == high && second == low),
        None => bytes[at] == low || bytes[at] == high,
    };
    (0..bytes.len()).find(|&at| start(at)).unwrap_or(bytes.len())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Header, Packet, messages::DevDataBinary, messages::Heartbeat};

    fn heartbeat(time: f64) -> Vec<u8> {
        Packet::new(Header { timestamp: time, ..Header::default() }, Heartbeat).encode().unwrap()
    }

    fn kinds(bytes: &[u8]) -> Vec<(u64, u64, &'static str)> {
        Frames::new(bytes)
            .map(|frame| match frame {
                Frame::Packet { offset, view } => (offset, view.bytes().len() as u64, "packet"),
                Frame::Damage(damage) => (damage.offset, damage.bytes, damage.error.class()),
            })
            .collect()
    }

    #[test]
    fn rubbish_between_packets_is_one_damage() {
        let bytes = [&heartbeat(1.0)[..], b"rubbish \x54", &heartbeat(2.0)].concat();
        assert_eq!(kinds(&bytes), [(0, 22, "packet"), (22, 9, "bad_sync"), (31, 22, "packet")]);
    }

    #[test]
    fn a_damaged_length_loses_only_its_own_packet() {
        let mut bytes = [heartbeat(1.0), heartbeat(2.0), heartbeat(3.0)].concat();
        bytes[22 + 5] = 0xFF;
        assert_eq!(kinds(&bytes), [(0, 22, "packet"), (22, 22, "truncated"), (44, 22, "packet")]);
    }

    #[test]
    fn neighbouring_damaged_packets_count_apart() {
        let mut bytes = [heartbeat(1.0), heartbeat(2.0), heartbeat(3.0)].concat();
        bytes[8] ^= 1;
        bytes[22 + 8] ^= 1;
        assert_eq!(kinds(&bytes), [(0, 22, "bad_crc"), (22, 22, "bad_crc"), (44, 22, "packet")]);
    }

    #[test]
    fn a_cut_tail_is_truncated() {
        let bytes = [&heartbeat(1.0)[..], &heartbeat(2.0)[..21]].concat();
        assert_eq!(kinds(&bytes), [(0, 22, "packet"), (22, 21, "truncated")]);
        assert_eq!(kinds(&bytes[..1]), [(0, 1, "truncated")]);
        assert_eq!(kinds(b""), []);
    }

    #[test]
    fn packets_inside_a_packet_stay_inside() {
        let inner = [heartbeat(1.0), heartbeat(2.0)].concat();
        let outer = Packet::new(Header::default(), DevDataBinary { value: inner }).encode().unwrap();
        assert_eq!(kinds(&outer), [(0, outer.len() as u64, "packet")]);
    }

    #[test]
    fn false_starts_cost_one_pass() {
        // Every second byte starts a packet of 65 108 bytes: checked one by one these are 17 GB of hashing.
        let bytes: Vec<u8> = [0x54, 0xFE].repeat(1 << 18);
        let found = kinds(&bytes);
        assert!(found.iter().all(|(_, _, class)| *class != "packet"));
        assert_eq!(found.iter().map(|(_, bytes, _)| bytes).sum::<u64>(), 1 << 19);
    }

    #[test]
    fn false_starts_between_packets_cost_one_pass() {
        // Each false start claims 64 KiB. Checked one by one these are 3 GB of hashing.
        let unit = [&[0x54, 0xFE, 0, 0, 0xFF, 0xFF][..], &heartbeat(1.0)].concat();
        let found = kinds(&unit.repeat(50_000));
        assert_eq!(found.iter().filter(|(_, _, class)| *class == "packet").count(), 50_000);
        assert_eq!(found.len(), 100_000);
    }

    #[test]
    fn a_packet_that_never_ends_can_be_given_up() {
        let mut deframer = Deframer::new();
        let mut claim = heartbeat(1.0);
        claim[5] = 0xFF;
        deframer.push(&[&claim[..], &heartbeat(2.0), &heartbeat(3.0)[..10]].concat());
        assert_eq!(deframer.next_frame(), None);
        deframer.give_up();
        assert!(matches!(deframer.next_frame(), Some(Frame::Damage(Damage { offset: 0, bytes: 22, .. }))));
        assert!(matches!(deframer.next_frame(), Some(Frame::Packet { offset: 22, .. })));
        assert_eq!(deframer.next_frame(), None);
        deframer.push(&heartbeat(3.0)[10..]);
        assert!(matches!(deframer.next_frame(), Some(Frame::Packet { offset: 44, .. })));
        assert_eq!(deframer.next_frame(), None);
        assert_eq!(deframer.pending(), 0);
    }

    #[test]
    fn a_packet_behind_one_that_claims_too_much_is_seen_and_a_half_one_is_none() {
        let mut deframer = Deframer::new();
        deframer.push(&heartbeat(1.0)[..10]);
        assert!(deframer.next_frame().is_none() && !deframer.holds_packet());
        deframer.push(&heartbeat(1.0)[10..]);
        assert!(matches!(deframer.next_frame(), Some(Frame::Packet { .. })));
        assert!(!deframer.holds_packet(), "nothing waits");
        let mut claim = heartbeat(2.0);
        claim[5] = 0xFF;
        deframer.push(&claim);
        deframer.push(&heartbeat(3.0)[..15]);
        assert!(deframer.next_frame().is_none() && !deframer.holds_packet());
        deframer.push(&heartbeat(3.0)[15..]);
        assert!(deframer.next_frame().is_none() && deframer.holds_packet());
    }

    #[test]
    fn damage_does_not_depend_on_the_cut() {
        let mut bytes = heartbeat(1.0);
        bytes[8] ^= 1;
        bytes.extend_from_slice(&[0x54, 0, 1, 2, 3]);
        bytes.extend_from_slice(&heartbeat(2.0));
        let whole: Vec<Frame<'_>> = Frames::new(&bytes).collect();
        for cut in 0..bytes.len() {
            let (mut deframer, mut at) = (Deframer::new(), 0);
            for piece in [&bytes[..cut], &bytes[cut..]] {
                deframer.push(piece);
                while let Some(frame) = deframer.next_frame() {
                    assert_eq!(frame, whole[at], "cut at {cut}");
                    at += 1;
                }
            }
            assert_eq!(at, whole.len());
        }
    }

    #[test]
    fn a_long_run_of_rubbish_is_not_held() {
        let mut deframer = Deframer::new();
        let mut damaged = 0;
        for _ in 0..1_000 {
            deframer.push(&[0x55; 1_000]);
            while let Some(frame) = deframer.next_frame() {
                let Frame::Damage(damage) = frame else { panic!("{frame:?}") };
                assert_eq!(damage.offset, damaged);
                damaged += damage.bytes;
            }
            assert!(deframer.buffer.capacity() < 3 * MAX_PACKET_BYTES);
        }
        assert!(damaged > 900_000);
    }
}
