//! Which value of each topic a broker holds, so that what it holds only moves forward in time.
//!
//! Packets come late: a vessel that was out of reach sends what it spooled, a log is brought in, a batch that was not confirmed comes
//! again. All of it is published, but only what is not older than what the broker holds replaces that. What it held before this
//! program was started is read once ([`super::Mqtt`]).

use super::message::Message;
use std::collections::BTreeMap;

/// Topics that are known at most; those beyond are published without being retained.
const MOST: usize = 100_000;

/// The order of the newest value of each topic ([`Message::order_us`]).
#[derive(Debug, Default)]
pub(super) struct Retained(BTreeMap<String, i64>);

impl Retained {
    /// The broker holds this for a topic.
    pub(super) fn note(&mut self, topic: &str, order_us: i64) {
        if let Some(newest) = self.0.get_mut(topic) {
            *newest = order_us.max(*newest);
        } else if self.0.len() < MOST {
            self.0.insert(topic.to_owned(), order_us);
        }
    }

    /// Whether a message is to be retained, which is then the newest one known. Even where it gets lost: what is older comes before
    /// it when it is sent again.
    pub(super) fn take(&mut self, message: &Message) -> bool {
        self.note(&message.topic, message.order_us);
        self.0.get(&message.topic) == Some(&message.order_us)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_retained_only_moves_forward_in_time() {
        let mut retained = Retained::default();
        let mut take = |topic: &str, order_us| {
            retained.take(&Message { topic: topic.to_owned(), payload: String::new(), order_us })
        };
        assert!(take("a", 5) && take("a", 6) && take("b", 1));
        // Late, and again after a batch that was not confirmed.
        assert!(!take("a", 5) && take("a", 6) && !take("b", 0));
        retained.note("a", 9);
        retained.note("a", 3);
        let mut take =
            |order_us| retained.take(&Message { topic: "a".to_owned(), payload: String::new(), order_us });
        assert!(!take(8) && take(10));
    }

    #[test]
    fn it_does_not_grow_without_bound() {
        let mut retained = Retained((0..MOST).map(|number| (number.to_string(), 0)).collect());
        let message = |topic: &str| Message { topic: topic.to_owned(), payload: String::new(), order_us: 1 };
        assert!(!retained.take(&message("one more")) && retained.take(&message("7")));
        assert_eq!(retained.0.len(), MOST);
    }
}
