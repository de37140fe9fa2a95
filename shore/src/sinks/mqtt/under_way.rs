//! Messages of a batch on their way to the broker, and what it said of each.

use rumqttc::v5::mqttbytes::v5::PubAckReason;
use std::collections::{BTreeMap, VecDeque};
use std::fmt;

/// Why a broker will never take a message.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Refusal {
    /// Its payload is larger than the broker takes.
    TooLarge,
    /// Its topic and payload together are.
    PacketTooLarge,
    /// The broker does not let the server publish to its topic.
    Denied,
    /// As the broker calls it.
    Invalid(String),
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooLarge | Self::PacketTooLarge => f.write_str("it is more than the broker takes"),
            Self::Denied => f.write_str("the broker does not let the server publish it"),
            Self::Invalid(why) => write!(f, "the broker calls it {why}"),
        }
    }
}

/// How a connection ended before all was answered.
#[derive(Debug)]
pub(super) enum Ended {
    /// Over one of the messages under way; the broker does not say which.
    Refused(Refusal),
    /// Without a reason: it may have been a message, or the network.
    Lost(anyhow::Error),
}

/// What is under way over one connection, by its place in the batch.
#[derive(Debug, Default)]
pub(super) struct UnderWay {
    /// Handed over, in this order, and not sent yet.
    queued: VecDeque<usize>,
    /// Sent, under the number of the packet.
    sent: BTreeMap<u16, usize>,
    /// The broker has it.
    pub(super) taken: Vec<usize>,
    /// The broker will never take it, and why.
    pub(super) refused: Vec<(usize, Refusal)>,
}

impl UnderWay {
    pub(super) fn is_empty(&self) -> bool {
        self.queued.is_empty() && self.sent.is_empty()
    }

    /// The places below `count` of which the broker has said nothing.
    pub(super) fn unanswered(&self, count: usize) -> Vec<usize> {
        let mut is_answered = vec![false; count];
        for place in self.taken.iter().chain(self.refused.iter().map(|(place, _)| place)) {
            is_answered[*place] = true;
        }
        (0..count).filter(|place| !is_answered[*place]).collect()
    }

    pub(super) fn queue(&mut self, place: usize) {
        self.queued.push_back(place);
    }

    /// The next that was handed over went out under this number.
    pub(super) fn sent(&mut self, packet: u16) {
        if let Some(place) = self.queued.pop_front() {
            self.sent.insert(packet, place);
        }
    }

    /// The broker answers a packet.
    ///
    /// # Errors
    /// It takes nothing now.
    pub(super) fn confirmed(&mut self, packet: u16, reason: PubAckReason) -> anyhow::Result<()> {
        let Some(place) = self.sent.remove(&packet) else { return Ok(()) };
        let refusal = match reason {
            PubAckReason::Success | PubAckReason::NoMatchingSubscribers => {
                self.taken.push(place);
                return Ok(());
            }
            PubAckReason::NotAuthorized => Refusal::Denied,
            PubAckReason::TopicNameInvalid | PubAckReason::PayloadFormatInvalid => {
                Refusal::Invalid(format!("{reason:?}"))
            }
            _ => anyhow::bail!("it does not take messages now: {reason:?}"),
        };
        self.refused.push((place, refusal));
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn answers_find_their_messages_in_whatever_order_they_come() {
        let mut under_way = UnderWay::default();
        for place in 0..4 {
            under_way.queue(place);
        }
        for packet in [7, 8, 1] {
            under_way.sent(packet);
        }
        under_way.confirmed(8, PubAckReason::NotAuthorized).unwrap();
        under_way.confirmed(7, PubAckReason::Success).unwrap();
        under_way.confirmed(1, PubAckReason::NoMatchingSubscribers).unwrap();
        assert_eq!(under_way.taken, [0, 2]);
        assert_eq!(under_way.refused, [(1, Refusal::Denied)]);
        assert_eq!(under_way.unanswered(5), [3, 4]);
        assert!(!under_way.is_empty(), "the last has not been sent");
        under_way.sent(9);
        assert!(under_way.confirmed(9, PubAckReason::QuotaExceeded).is_err());
        under_way.confirmed(77, PubAckReason::Success).unwrap();
    }
}
