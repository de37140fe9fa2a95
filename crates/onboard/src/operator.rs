//! Which remote-operation messages still act: only fresh ones, only from the peer that started the session.
//!
//! Messages that waited in a stalled connection say what the operator wanted seconds ago. A packet's age is computed
//! from its sender's clock, whose offset to the vessel's steady time is that of the fastest packet seen: the
//! first message of a session sets it and faster ones correct it. The offset is kept over a silence, so that messages
//! held back by a stall are late when they come all at once. It follows a clock that was set back within a minute
//! of messages; until then the messages are refused and the watchdog stops the motors.
//!
//! A session belongs to the peer that started it. A late message still stops: its `Stop` and `Exit` count,
//! nothing else of it does.

use crate::peer::Peer;
use imc::Address;
use mission::Operator;
use std::collections::BTreeMap;
use std::net::Ipv4Addr;
use std::time::Duration;
use units::MonoTime;

/// Clocks remembered; beyond that the one not heard for longest is forgotten.
const CLOCKS_KEPT: usize = 256;
/// The fastest packet of this span and of the previous one count.
const SPAN: Duration = Duration::from_secs(30);

/// A sender's clock against the vessel's steady time.
#[derive(Debug, Clone, Copy)]
struct SenderClock {
    /// Sender's time minus steady time (s) of the fastest packet in this span and in the previous one.
    fastest_s: f64,
    before_s: Option<f64>,
    since: MonoTime,
    heard: MonoTime,
}

/// Why keys have no effect.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub(crate) enum Unfit {
    /// They took too long, or have no valid time.
    #[error("the operator's keys come {0:.1} s late; they are ignored")]
    Late(f64),
    /// Newer ones have acted.
    #[error("the operator's keys come out of order; the older ones are ignored")]
    Older,
    /// They come from elsewhere than the session's start.
    #[error("keys come from another connection than the one that started the session; they are ignored")]
    Elsewhere,
}

/// The operators' clocks, and the session.
#[derive(Debug, Clone, Default)]
pub(crate) struct Operators {
    clocks: BTreeMap<Address, SenderClock>,
    /// The system that started the running plan, and its peer.
    starter: Option<(Address, Peer)>,
    /// Where the keys of the session come from.
    bound: Option<Peer>,
    /// Time of the newest keys that acted (s, the sender's).
    newest_s: Option<f64>,
    /// A refusal was reported; the next is reported after keys have acted again.
    told: bool,
}

impl Operators {
    /// A packet of a system, with the time in its header.
    pub(crate) fn heard(&mut self, now: MonoTime, system: Address, sent_s: f64) {
        if !sent_s.is_finite() {
            return;
        }
        if !self.clocks.contains_key(&system) && self.clocks.len() >= CLOCKS_KEPT {
            let oldest = self.clocks.iter().min_by_key(|(_, clock)| clock.heard).map(|(system, _)| *system);
            oldest.map(|system| self.clocks.remove(&system));
        }
        let offset_s = sent_s - seconds(now);
        let new = SenderClock { fastest_s: offset_s, before_s: None, since: now, heard: now };
        let clock = self.clocks.entry(system).or_insert(new);
        clock.heard = now;
        if now.since(clock.since) >= SPAN {
            *clock = SenderClock { before_s: Some(clock.fastest_s), ..new };
        }
        clock.fastest_s = clock.fastest_s.max(offset_s);
    }

    /// A plan begins that this system started from there.
    pub(crate) fn started(&mut self, system: Address, from: Peer) {
        self.starter = Some((system, from));
        (self.bound, self.newest_s, self.told) = (None, None, false);
    }

    /// Whether keys of a system may act, and how much longer than usual they took. `host` is where the system is in
    /// contact by UDP.
    ///
    /// # Errors
    /// Why not.
    pub(crate) fn admit(
        &mut self,
        now: MonoTime,
        longest_age: Duration,
        keys: &Keys,
        host: Option<Ipv4Addr>,
    ) -> Result<Duration, Unfit> {
        let home = self.bound.or_else(|| {
            // An operator who is named but did not start the session brings a peer of its own.
            let (system, from) = self.starter?;
            keys.operator.admits(system.0).then_some(from)
        });
        if home.is_some_and(|home| !is_same(home, keys.from, host)) {
            return Err(Unfit::Elsewhere);
        }
        let late_s = self.late_s(now, keys);
        if late_s.is_none_or(|late_s| late_s > longest_age.as_secs_f64()) {
            return Err(Unfit::Late(late_s.unwrap_or(f64::INFINITY)));
        }
        // A message in time and yet much older than the newest comes from a clock that was set back.
        let longest_s = 2.0 * longest_age.as_secs_f64();
        let behind_s = self.newest_s.map_or(0.0, |newest_s| newest_s - keys.sent_s);
        if behind_s > 0.0 && behind_s < longest_s {
            return Err(Unfit::Older);
        }
        (self.bound, self.newest_s, self.told) = (Some(home.unwrap_or(keys.from)), Some(keys.sent_s), false);
        Ok(Duration::try_from_secs_f64(late_s.unwrap_or_default().max(0.0)).unwrap_or_default())
    }

    /// Whether a refusal is worth telling: the first since keys have acted.
    pub(crate) fn is_news(&mut self) -> bool {
        !std::mem::replace(&mut self.told, true)
    }

    /// How much longer than the fastest packet this one took (s).
    fn late_s(&self, now: MonoTime, keys: &Keys) -> Option<f64> {
        let clock = self.clocks.get(&keys.system).filter(|_| keys.sent_s.is_finite())?;
        let fastest_s = clock.before_s.map_or(clock.fastest_s, |before_s| before_s.max(clock.fastest_s));
        Some(fastest_s - (keys.sent_s - seconds(now)))
    }
}

/// A message of keys: who sent it, from where and when.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Keys {
    pub(crate) system: Address,
    pub(crate) from: Peer,
    /// Time in the header (s).
    pub(crate) sent_s: f64,
    /// The system that may steer; anyone at the session's peer if none.
    pub(crate) operator: Operator,
}

/// A console may use several ports of its host, and both transports once its host is known.
fn is_same(home: Peer, from: Peer, host: Option<Ipv4Addr>) -> bool {
    match (home, from) {
        (Peer::Tcp(one), Peer::Tcp(other)) => one == other,
        (Peer::Udp(one), Peer::Udp(other)) => one.ip() == other.ip(),
        (Peer::Tcp(_), Peer::Udp(at)) | (Peer::Udp(at), Peer::Tcp(_)) => host == Some(*at.ip()),
    }
}

fn seconds(now: MonoTime) -> f64 {
    now.since(MonoTime::default()).as_secs_f64()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::net::SocketAddrV4;

    const CONSOLE: Address = Address(0x4001);
    const BOUND: Duration = Duration::from_secs(1);

    fn at(seconds: f64) -> MonoTime {
        MonoTime::from_micros((seconds * 1e6) as u64)
    }

    fn keys(from: Peer, sent_s: f64) -> Keys {
        Keys { system: CONSOLE, from, sent_s, operator: Operator::System(CONSOLE.0) }
    }

    /// A packet of keys made at `sent_s` that arrives at `now_s`.
    fn arrive(operators: &mut Operators, now_s: f64, sent_s: f64) -> Result<Duration, Unfit> {
        operators.heard(at(now_s), CONSOLE, sent_s);
        operators.admit(at(now_s), BOUND, &keys(Peer::Tcp(1), sent_s), None)
    }

    #[test]
    fn a_burst_after_a_stall_is_late_however_long_the_stall() {
        for stall_s in [3.0, 45.0, 1000.0] {
            let mut operators = Operators::default();
            operators.started(CONSOLE, Peer::Tcp(1));
            for n in 0..20 {
                let now_s = 10.0 + 0.1 * f64::from(n);
                assert_eq!(arrive(&mut operators, now_s, 5000.0 + now_s), Ok(Duration::ZERO));
            }
            let end_s = 12.0 + stall_s;
            for n in 0..(stall_s as u32 - 2) {
                let sent_s = 5012.0 + f64::from(n);
                assert!(
                    matches!(arrive(&mut operators, end_s, sent_s), Err(Unfit::Late(_))),
                    "{stall_s} {n}"
                );
            }
            assert_eq!(arrive(&mut operators, end_s + 0.1, 5000.0 + end_s + 0.1), Ok(Duration::ZERO));
        }
    }

    #[test]
    fn a_first_message_that_was_late_is_mended_by_the_next() {
        let mut operators = Operators::default();
        assert_eq!(arrive(&mut operators, 10.0, 5005.0), Ok(Duration::ZERO));
        assert_eq!(arrive(&mut operators, 10.1, 5010.1), Ok(Duration::ZERO));
        assert!(matches!(arrive(&mut operators, 10.2, 5005.3), Err(Unfit::Late(_))));
    }

    #[test]
    fn a_clock_set_back_is_followed_within_a_minute() {
        let mut operators = Operators::default();
        assert_eq!(arrive(&mut operators, 0.0, 5000.0), Ok(Duration::ZERO));
        let accepted = (1..100)
            .find(|second| arrive(&mut operators, f64::from(*second), 1000.0 + f64::from(*second)).is_ok());
        assert_eq!(accepted, Some(60));
    }

    #[test]
    fn older_keys_and_those_from_elsewhere_have_no_effect() {
        let mut operators = Operators::default();
        operators.started(CONSOLE, Peer::Tcp(1));
        operators.heard(at(0.0), CONSOLE, 5000.0);
        assert_eq!(operators.admit(at(0.0), BOUND, &keys(Peer::Tcp(1), 5000.0), None), Ok(Duration::ZERO));
        assert_eq!(operators.admit(at(0.1), BOUND, &keys(Peer::Tcp(1), 4999.9), None), Err(Unfit::Older));
        let udp = |last: u8, port| Peer::Udp(SocketAddrV4::new([10, 0, 0, last].into(), port));
        for (from, host) in
            [(Peer::Tcp(2), None), (udp(9, 6001), None), (udp(9, 6001), Some([10, 0, 0, 8].into()))]
        {
            let found = operators.admit(at(0.1), BOUND, &keys(from, 5000.1), host);
            assert_eq!(found, Err(Unfit::Elsewhere), "{from:?}");
        }
        let known = Some([10, 0, 0, 9].into());
        assert_eq!(operators.admit(at(0.1), BOUND, &keys(udp(9, 6001), 5000.1), known), Ok(Duration::ZERO));
        assert!(operators.admit(at(0.1), BOUND, &keys(Peer::Tcp(1), f64::NAN), None).is_err());
    }

    #[test]
    fn an_operator_who_did_not_start_the_session_brings_a_peer() {
        let mut operators = Operators::default();
        operators.started(Address(0x4002), Peer::Tcp(2));
        operators.heard(at(0.0), CONSOLE, 5000.0);
        assert_eq!(operators.admit(at(0.0), BOUND, &keys(Peer::Tcp(1), 5000.0), None), Ok(Duration::ZERO));
        let other = operators.admit(at(0.0), BOUND, &keys(Peer::Tcp(2), 5000.0), None);
        assert_eq!(other, Err(Unfit::Elsewhere));
    }
}
