//! How large a message may be, as far as the broker has shown by what it refused: what is as large is not tried any more, as each
//! trial may cost a connection.

use super::under_way::Refusal;

/// The most that the broker may take, bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Largest {
    payload_bytes: usize,
    /// Topic and payload.
    packet_bytes: usize,
}

impl Default for Largest {
    /// It has refused nothing.
    fn default() -> Self {
        Self { payload_bytes: usize::MAX, packet_bytes: usize::MAX }
    }
}

impl Largest {
    /// Why it would refuse a message of this size, if it would.
    pub(super) const fn refusal(&self, topic_bytes: usize, payload_bytes: usize) -> Option<Refusal> {
        if payload_bytes > self.payload_bytes {
            return Some(Refusal::TooLarge);
        }
        if topic_bytes + payload_bytes > self.packet_bytes {
            return Some(Refusal::PacketTooLarge);
        }
        None
    }

    /// It refused a message of this size.
    pub(super) fn note(&mut self, refusal: &Refusal, topic_bytes: usize, payload_bytes: usize) {
        let (largest, bytes) = match refusal {
            Refusal::TooLarge => (&mut self.payload_bytes, payload_bytes),
            Refusal::PacketTooLarge => (&mut self.packet_bytes, topic_bytes + payload_bytes),
            Refusal::Denied | Refusal::Invalid(_) => return,
        };
        *largest = bytes.saturating_sub(1).min(*largest);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_limit_of_packets_is_of_topic_and_payload_and_one_of_payloads_is_not() {
        let mut largest = Largest::default();
        largest.note(&Refusal::PacketTooLarge, 100, 50);
        assert_eq!(largest.refusal(100, 50), Some(Refusal::PacketTooLarge));
        assert_eq!(largest.refusal(10, 139), None, "a larger payload, a smaller packet");
        largest.note(&Refusal::TooLarge, 1, 120);
        largest.note(&Refusal::TooLarge, 1, 130);
        assert_eq!(largest.refusal(10, 120), Some(Refusal::TooLarge));
        assert_eq!(largest.refusal(10, 119), None);
    }
}
