//! What goes down one vessel's link: the numbers there, the commands behind them, and the log's lines about both.

use hub::{CommandId, Tag};
use imc::Address;
use link::{ConnectionId, Outcome, Receipt};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// The packets on a vessel's link whose outcome is not known.
pub(super) struct LinkOrders {
    vessel: Address,
    next: u64,
    /// The first number that this start of the program gave out.
    first: u64,
    /// Orders of people by their number on the link; `true` for a copy, whose outcome says nothing of the order's.
    orders: BTreeMap<u64, (CommandId, bool)>,
    /// Stick positions; those that did not come in time are counted.
    sticks: BTreeSet<u64>,
    late: Arc<AtomicU64>,
    /// The names of the vessel's ways, by connection.
    ways: BTreeMap<ConnectionId, String>,
    /// What became of the latest orders, by their number on the link: a receipt that comes later may say another thing.
    ended: BTreeMap<u64, &'static str>,
}

/// Most orders whose outcome is remembered.
const ENDED: usize = 1_000;

impl LinkOrders {
    /// None yet. Numbers begin at `first`, which no start of the program repeats; `late` counts stick positions.
    pub(super) fn new(vessel: Address, first: u64, late: Arc<AtomicU64>) -> Self {
        let (orders, ways, ended) = (BTreeMap::new(), BTreeMap::new(), BTreeMap::new());
        Self { vessel, next: first, first, orders, sticks: BTreeSet::new(), late, ways, ended }
    }

    /// The number of a packet that is given to the link, and of its order ashore (0 for none).
    pub(super) fn given(&mut self, tag: Option<&Tag>) -> (u64, u64) {
        let id = self.next;
        self.next += 1;
        match tag.map(|tag| (tag.id, tag.is_copy)) {
            Some((Some(command), is_copy)) => drop(self.orders.insert(id, (command, is_copy))),
            Some((None, _)) => drop(self.sticks.insert(id)),
            None => {}
        }
        (id, tag.and_then(|tag| tag.id).map_or(0, |command| command.0))
    }

    /// A connection by a way of this name greets; of the others `stand` says whether they are there.
    pub(super) fn greeted(
        &mut self,
        id: ConnectionId,
        way: Option<&str>,
        stand: impl Fn(&ConnectionId) -> bool,
    ) {
        self.ways.retain(|id, _| stand(id));
        self.ways.extend(way.map(|way| (id, way.to_owned())));
    }

    /// A command went over a connection, for this time, or was not taken by it.
    pub(super) fn sent(&self, (id, order): (u64, u64), (over, is_taken): (ConnectionId, bool), times: u32) {
        let (vessel, way) = (self.vessel, self.ways.get(&over).map_or("", String::as_str));
        if is_taken {
            tracing::info!(command = order, %vessel, link = id, way, times, "sent on the link");
        } else {
            let text = "not sent on this connection, which takes nothing more and is closed";
            tracing::warn!(command = order, %vessel, link = id, way, times, "{text}");
        }
    }

    /// The outcome of a packet: the command that it is the outcome of.
    pub(super) fn outcome(&mut self, id: u64, outcome: &Outcome) -> Option<CommandId> {
        let word = match outcome {
            Outcome::Received => "received",
            Outcome::Expired => "expired",
            Outcome::Refused(_) => "refused",
            Outcome::Unanswered => "unanswered",
        };
        metrics::counter!("lutra_link_commands_total", "outcome" => word).increment(1);
        if self.sticks.remove(&id) {
            self.late.fetch_add(u64::from(*outcome != Outcome::Received), Ordering::Relaxed);
            return None;
        }
        let Some((command, is_copy)) = self.orders.remove(&id) else {
            if !matches!(outcome, Outcome::Received | Outcome::Expired) {
                tracing::warn!(vessel = %self.vessel, id, ?outcome, "a packet did not arrive");
            }
            return None;
        };
        self.ended.insert(id, word);
        if self.ended.len() > ENDED {
            self.ended.pop_first();
        }
        let (vessel, command_id) = (self.vessel, command.0);
        match outcome {
            Outcome::Received => {
                tracing::info!(command = command_id, %vessel, link = id, "the vessel has it");
            }
            // The order itself, or another copy of it, may have gone.
            Outcome::Expired => {
                tracing::info!(command = command_id, %vessel, link = id, "not sent, or too late");
            }
            Outcome::Refused(why) => {
                tracing::warn!(command = command_id, %vessel, link = id, why, "the vessel refused it");
            }
            Outcome::Unanswered => {
                tracing::warn!(command = command_id, %vessel, link = id, "sent, and the vessel did not answer");
            }
        }
        (!is_copy).then_some(command)
    }

    /// A receipt that nothing waits for: one of many that came by several ways, or an earlier start of this program waited.
    pub(super) fn stray(&self, Receipt { id, verdict, text, order }: &Receipt) {
        let (vessel, outcome) = (self.vessel, verdict.name());
        if let Some(before) = self.changed(*id, outcome) {
            let late = "the vessel answers late, and other than was taken for its outcome";
            tracing::info!(command = order, %vessel, link = id, outcome, before, text, "{late}");
        } else if (self.first..self.next).contains(id) {
            tracing::debug!(command = order, %vessel, link = id, outcome, text, "answered again on the link");
        } else {
            let earlier = "the vessel answers a command that was given before this server started";
            tracing::info!(command = order, %vessel, link = id, outcome, text, "{earlier}");
        }
    }
}

impl LinkOrders {
    /// What the outcome of an order was taken to be, where a receipt says another.
    fn changed(&self, id: u64, outcome: &str) -> Option<&'static str> {
        self.ended.get(&id).copied().filter(|before| *before != outcome)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hub::Urgency;

    #[test]
    fn a_copy_has_the_number_of_its_order_and_its_outcome_is_not_the_orders() {
        let late = Arc::new(AtomicU64::new(0));
        let mut orders = LinkOrders::new(Address(0x2810), 100, Arc::clone(&late));
        let tag = |id: Option<u64>, is_copy| Tag {
            id: id.map(CommandId),
            is_copy,
            epoch: 0,
            expires: units::MonoTime::default(),
            urgency: Urgency::Stop,
        };
        assert_eq!(orders.given(Some(&tag(Some(7), true))), (100, 7));
        assert_eq!(orders.given(Some(&tag(Some(7), false))), (101, 7));
        assert_eq!(orders.given(Some(&tag(None, false))), (102, 0));
        assert_eq!(orders.given(None), (103, 0));
        let outcomes = [100, 101, 102, 103].map(|id| orders.outcome(id, &Outcome::Expired));
        assert_eq!(outcomes, [None, Some(CommandId(7)), None, None]);
        assert_eq!(late.load(Ordering::Relaxed), 1, "the stick position alone");
    }

    #[test]
    fn a_late_receipt_is_news_where_it_says_another_thing_than_was_taken_for_the_outcome() {
        let mut orders = LinkOrders::new(Address(0x2810), 100, Arc::default());
        let tag = Tag {
            id: Some(CommandId(7)),
            is_copy: false,
            epoch: 0,
            expires: units::MonoTime::default(),
            urgency: Urgency::Stop,
        };
        for outcome in [Outcome::Unanswered, Outcome::Received] {
            let (id, _) = orders.given(Some(&tag));
            assert_eq!(orders.changed(id, "received"), None, "it is not known yet");
            orders.outcome(id, &outcome);
        }
        assert_eq!(orders.changed(100, "received"), Some("unanswered"));
        assert_eq!(orders.changed(101, "received"), None, "it came by a second way");
        assert_eq!(orders.changed(101, "refused"), Some("received"));
        for _ in 0..ENDED {
            let (id, _) = orders.given(Some(&tag));
            orders.outcome(id, &Outcome::Received);
        }
        assert_eq!((orders.ended.len(), orders.changed(100, "received")), (ENDED, None));
    }
}
