//! What the broker lets the server publish, as far as it has shown: what tells one topic that it denies from a broker that denies all.
//!
//! A few messages that it took are kept, by their text beside the cursor too ([`Access::note`]): where it denies everything of a batch,
//! one of them is sent again. If that is denied as well, the batch waits; otherwise its topics are denied for good.

use super::message::Message;
use std::collections::{BTreeSet, VecDeque};

/// Vessels of which a message that was taken is kept; beyond that, the one that was heard longest ago goes.
const MOST_TAKEN: usize = 4;
/// A larger message is not kept to be sent again.
const MOST_TAKEN_BYTES: usize = 4096;
/// Topics of which it is remembered that they are denied; for those beyond, a message that was taken is sent again each time.
const MOST_DENIED: usize = 10_000;

/// What was taken and denied.
#[derive(Debug, Default)]
pub(super) struct Access {
    /// One message of a vessel, the newest last.
    taken: VecDeque<Message>,
    /// Topics that were denied while the broker took something else.
    denied: BTreeSet<String>,
}

impl Access {
    /// The broker took these.
    pub(super) fn take(&mut self, messages: &[&Message]) {
        for message in messages {
            self.denied.remove(&message.topic);
        }
        let is_small = |message: &&&Message| message.topic.len() + message.payload.len() <= MOST_TAKEN_BYTES;
        let Some(newest) = messages.iter().rev().find(is_small) else { return };
        self.taken.retain(|other| other.vessel() != newest.vessel());
        if self.taken.len() >= MOST_TAKEN {
            self.taken.pop_front();
        }
        self.taken.push_back((*newest).clone());
    }

    /// The broker denied this topic, and took something else.
    pub(super) fn deny(&mut self, topic: &str) {
        if self.denied.len() < MOST_DENIED && !self.denied.contains(topic) {
            self.denied.insert(topic.to_owned());
        }
    }

    /// Whether it is known that this topic alone is denied.
    pub(super) fn denies(&self, topic: &str) -> bool {
        self.denied.contains(topic)
    }

    /// Messages that the broker took, the newest first.
    pub(super) fn taken(&self) -> Vec<Message> {
        self.taken.iter().rev().cloned().collect()
    }

    /// For [`Access::resume`].
    pub(super) fn note(&self) -> String {
        let taken: Vec<_> = self.taken.iter().map(|message| (&message.topic, &message.payload)).collect();
        serde_json::to_string(&taken).unwrap_or_default()
    }

    /// What was taken before a restart. A note that is not understood counts as none.
    pub(super) fn resume(&mut self, note: &str) {
        let taken: Vec<(String, String)> = serde_json::from_str(note).unwrap_or_default();
        let message = |(topic, payload)| Message { topic, payload, order_us: i64::MIN };
        self.taken = taken.into_iter().map(message).collect();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(topic: &str, payload_bytes: usize) -> Message {
        Message { topic: topic.to_owned(), payload: "x".repeat(payload_bytes), order_us: 1 }
    }

    fn topics(access: &Access) -> Vec<String> {
        access.taken().into_iter().map(|message| message.topic).collect()
    }

    #[test]
    fn one_small_message_of_a_few_vessels_is_kept_over_a_restart() {
        let mut access = Access::default();
        access.take(&[&message("a/1", 1), &message("a/2", 1), &message("a/3", MOST_TAKEN_BYTES)]);
        assert_eq!(topics(&access), ["a/2"]);
        for vessel in ["b/1", "c/1", "a/1", "d/1", "e/1"] {
            access.take(&[&message(vessel, 1)]);
        }
        let mut again = Access::default();
        again.resume(&access.note());
        assert_eq!(topics(&again), ["e/1", "d/1", "a/1", "c/1"]);
        again.resume("");
        assert!(topics(&again).is_empty());
    }

    #[test]
    fn a_topic_that_is_taken_is_not_denied_any_more() {
        let mut access = Access::default();
        access.deny("a/1");
        assert!(access.denies("a/1") && !access.denies("a/2"));
        access.take(&[&message("a/1", 1)]);
        assert!(!access.denies("a/1"));
    }
}
