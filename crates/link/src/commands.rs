//! Commands at both ends: which wait for an answer ashore, which were seen aboard.

use crate::ConnectionId;
use crate::frame::{Receipt, Verdict};
use bytes::Bytes;
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::time::Duration;
use units::MonoTime;

/// Commands that may wait for an answer at once.
pub(crate) const MOST_WAITING: usize = 256;
/// Identities that a vessel remembers. More than can wait, so that one that is sent again is always known.
const MOST_REMEMBERED: usize = 1024;
/// An answer may come this much after the time to live.
const GRACE: Duration = Duration::from_secs(3);

/// A command without an answer goes over the other connections too after this.
const ELSEWHERE_AFTER: Duration = Duration::from_millis(500);

/// A command ashore.
#[derive(Debug, Clone)]
pub(crate) struct Waiting {
    /// Epoch of the lease under which it is given; 0 for none.
    pub(crate) lease: u64,
    /// The number of the order ashore; 0 for none.
    pub(crate) order: u64,
    pub(crate) packet: Bytes,
    pub(crate) expires: MonoTime,
    /// Sent at least once.
    pub(crate) sent: bool,
    /// How often it was sent, over all connections.
    pub(crate) times: u32,
    /// Sent to an earlier start of the vessel's program, which may have carried it out: what a later start says of it is not
    /// the whole truth.
    pub(crate) sent_before_start: bool,
    /// A stop followed: it is not sent again.
    pub(crate) called_off: bool,
    /// When it was sent first, and over which open connections.
    pub(crate) first_sent: Option<MonoTime>,
    pub(crate) over: Vec<ConnectionId>,
}

impl Waiting {
    pub(crate) fn new(lease: u64, order: u64, packet: Bytes, expires: MonoTime) -> Self {
        Self {
            lease,
            order,
            packet,
            expires,
            sent: false,
            times: 0,
            sent_before_start: false,
            called_off: false,
            first_sent: None,
            over: Vec::new(),
        }
    }

    /// When it is to go over the other connections too.
    fn elsewhere_at(&self) -> Option<MonoTime> {
        self.first_sent.filter(|_| !self.called_off).map(|at| at + ELSEWHERE_AFTER)
    }
}

/// The shore's commands without an answer, by identity.
#[derive(Debug, Clone, Default)]
pub(crate) struct Pending {
    waiting: BTreeMap<u64, Waiting>,
}

impl Pending {
    /// A stop follows: what was not sent is taken out, and what was sent is not sent again.
    pub(crate) fn call_off(&mut self) -> Vec<u64> {
        let unsent: Vec<u64> = self.waiting.iter().filter(|(_, one)| !one.sent).map(|(id, _)| *id).collect();
        self.waiting.retain(|_, one| one.sent);
        for one in self.waiting.values_mut() {
            one.called_off = true;
        }
        unsent
    }

    /// Takes a command; answers false when too many wait or the identity is taken. For a stop there is always room: what
    /// it called off does not count.
    pub(crate) fn put(&mut self, id: u64, waiting: Waiting) -> bool {
        let count = self.waiting.values().filter(|one| !one.called_off).count();
        if count >= MOST_WAITING || self.waiting.contains_key(&id) {
            return false;
        }
        self.waiting.insert(id, waiting);
        true
    }

    /// Takes out the command that was answered.
    pub(crate) fn answered(&mut self, id: u64) -> Option<Waiting> {
        self.waiting.remove(&id)
    }

    /// The vessel's program was started again: it knows nothing of what was sent before.
    pub(crate) fn started_again(&mut self) {
        for one in self.waiting.values_mut() {
            one.sent_before_start = one.sent;
        }
    }

    /// Marks all that can still be in time as sent over a connection, in order; what was sent over it before is left out.
    pub(crate) fn sendable(&mut self, now: MonoTime, over: ConnectionId) -> Vec<(u64, Waiting)> {
        let due = self.waiting.iter_mut();
        let due = due.filter(|(_, one)| one.expires > now && !one.called_off && !one.over.contains(&over));
        due.map(|(id, one)| {
            one.sent = true;
            one.times += 1;
            one.first_sent = one.first_sent.or(Some(now));
            one.over.push(over);
            (*id, one.clone())
        })
        .collect()
    }

    /// A connection is gone.
    pub(crate) fn forget(&mut self, connection: ConnectionId) {
        for one in self.waiting.values_mut() {
            one.over.retain(|over| *over != connection);
        }
    }

    /// Whether something has waited so long for its answer that it is to go over every connection.
    pub(crate) fn is_late(&self, now: MonoTime) -> bool {
        self.waiting.values().any(|one| one.elsewhere_at().is_some_and(|at| now >= at))
    }

    /// When that will be so next.
    pub(crate) fn late_at(&self, now: MonoTime) -> Option<MonoTime> {
        self.waiting.values().filter_map(Waiting::elsewhere_at).filter(|at| *at > now).min()
    }

    /// Those that will not be answered any more, and whether they were ever sent.
    pub(crate) fn overdue(&mut self, now: MonoTime) -> Vec<(u64, bool)> {
        let over: Vec<(u64, bool)> =
            self.waiting.iter().filter(|(_, one)| now >= end(one)).map(|(id, one)| (*id, one.sent)).collect();
        for (id, _) in &over {
            self.waiting.remove(id);
        }
        over
    }

    pub(crate) fn next_end(&self) -> Option<MonoTime> {
        self.waiting.values().map(end).min()
    }
}

fn end(one: &Waiting) -> MonoTime {
    if one.sent { one.expires + GRACE } else { one.expires }
}

/// The vessel's record of commands it has seen.
#[derive(Debug, Clone, Default)]
pub(crate) struct Seen {
    known: BTreeMap<u64, Known>,
    order: VecDeque<u64>,
}

/// A command that was seen: the number of its order, the ways that it came on while it had no answer, its answer, and when that was given.
#[derive(Debug, Clone, Default)]
struct Known {
    order: u64,
    came_on: BTreeSet<usize>,
    answer: Option<(MonoTime, Receipt)>,
}

/// The decision on a received command.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum First {
    /// It was never seen.
    New,
    /// It was delivered and its answer is still to come.
    Unanswered,
    /// It was answered so.
    Answered(Receipt),
}

impl Seen {
    /// Looks a command of an order up that came on a way, and remembers all three.
    pub(crate) fn look(&mut self, id: u64, order: u64, place: usize) -> First {
        if let Some(known) = self.known.get_mut(&id) {
            if let Some((_, receipt)) = &known.answer {
                return First::Answered(receipt.clone());
            }
            known.came_on.insert(place);
            return First::Unanswered;
        }
        if self.order.len() == MOST_REMEMBERED
            && let Some(oldest) = self.order.pop_front()
        {
            self.known.remove(&oldest);
        }
        self.order.push_back(id);
        self.known.insert(id, Known { order, came_on: BTreeSet::from([place]), answer: None });
        First::New
    }

    /// Keeps the answer to a command that was looked up, and gives it with the ways that the command came on; `None` when it
    /// is unknown or was answered before.
    pub(crate) fn answer(
        &mut self,
        now: MonoTime,
        id: u64,
        verdict: Verdict,
        text: String,
    ) -> Option<(Receipt, BTreeSet<usize>)> {
        let known = self.known.get_mut(&id)?;
        if known.answer.is_some() {
            return None;
        }
        let receipt = Receipt { id, verdict, text, order: known.order };
        known.answer = Some((now, receipt.clone()));
        Some((receipt, std::mem::take(&mut known.came_on)))
    }

    /// The answers that are no older than this, as many as the shore can wait for.
    pub(crate) fn answered_within(&self, now: MonoTime, age: Duration) -> Vec<Receipt> {
        let newest = self.order.iter().rev().take(MOST_WAITING).filter_map(|id| self.known.get(id));
        let young = newest.filter_map(|known| known.answer.as_ref()).filter(|(at, _)| now.since(*at) <= age);
        young.map(|(_, receipt)| receipt.clone()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_command_is_new_once_and_its_answer_is_kept() {
        let mut seen = Seen::default();
        let at = |s| MonoTime::default() + Duration::from_secs(s);
        assert_eq!(seen.look(9, 77, 0), First::New);
        assert_eq!(seen.look(9, 77, 2), First::Unanswered);
        let (receipt, ways) = seen.answer(at(1), 9, Verdict::Received, String::new()).unwrap();
        assert_eq!((receipt.order, ways), (77, BTreeSet::from([0, 2])));
        assert_eq!(seen.answer(at(1), 9, Verdict::Refused, String::new()), None);
        assert_eq!(seen.look(9, 77, 1), First::Answered(receipt.clone()));
        assert_eq!(seen.answered_within(at(4), Duration::from_secs(3)), [receipt]);
        assert_eq!(seen.answered_within(at(5), Duration::from_secs(3)), []);
        for id in 10..10 + MOST_REMEMBERED as u64 {
            assert_eq!(seen.look(id, 0, 0), First::New);
        }
        assert_eq!(seen.known.len(), MOST_REMEMBERED);
    }

    #[test]
    fn what_a_stop_calls_off_is_not_sent_after_it() {
        let mut pending = Pending::default();
        let at = |s| MonoTime::default() + Duration::from_secs(s);
        let one = Waiting::new(0, 0, Bytes::new(), at(9));
        let (first, next) = (ConnectionId(1), ConnectionId(2));
        assert!(pending.put(1, one.clone()));
        assert_eq!(pending.sendable(at(0), first).len(), 1);
        assert!(pending.put(2, one.clone()));
        assert_eq!(pending.call_off(), [2]);
        assert!(pending.put(3, one));
        let sent: Vec<u64> = pending.sendable(at(1), next).into_iter().map(|(id, _)| id).collect();
        assert_eq!(sent, [3], "over the next connection");
        assert!(pending.answered(1).is_some(), "whether the first arrived is still asked");
    }

    #[test]
    fn what_an_earlier_start_of_the_vessel_may_have_carried_out_is_marked() {
        let mut pending = Pending::default();
        let at = |s| MonoTime::default() + Duration::from_secs(s);
        assert!(pending.put(1, Waiting::new(0, 0, Bytes::new(), at(9))));
        assert_eq!(pending.sendable(at(0), ConnectionId(1)).len(), 1);
        assert!(pending.put(2, Waiting::new(0, 0, Bytes::new(), at(9))));
        pending.started_again();
        assert_eq!(pending.sendable(at(1), ConnectionId(2)).len(), 2);
        let marked = [1, 2].map(|id| pending.answered(id).map(|one| one.sent_before_start));
        assert_eq!(marked, [Some(true), Some(false)]);
    }

    #[test]
    fn waiting_commands_are_bounded_and_end() {
        let mut pending = Pending::default();
        let at = |s| MonoTime::default() + Duration::from_secs(s);
        let one = Waiting::new(0, 0, Bytes::new(), at(1));
        let (first, next) = (ConnectionId(1), ConnectionId(2));
        for id in 0..MOST_WAITING as u64 {
            assert!(pending.put(id, one.clone()));
        }
        assert!(!pending.put(999, one));
        assert_eq!(pending.sendable(at(0), first).len(), MOST_WAITING);
        assert!(pending.sendable(at(0), first).is_empty());
        assert_eq!(pending.sendable(at(0), next).len(), MOST_WAITING);
        assert!(pending.answered(0).is_some() && pending.answered(0).is_none());
        assert!(pending.overdue(at(3)).is_empty());
        assert_eq!(pending.overdue(at(4)).len(), MOST_WAITING - 1);
        assert_eq!(pending.next_end(), None);
    }
}
