//! Limits how often passwords may be guessed.
//!
//! Three budgets of failures, each refilled with time: per address, per address and account, and per account.
//! The last slows guesses that come from many addresses at once. So that a stranger cannot lock a person out by
//! guessing, a browser in which that person was logged in before has a budget of its own and none of these
//! (OWASP, "Slow Down Online Guessing Attacks with Device Cookies").
//!
//! The crate governor cannot do this: a guess takes from three budgets or from none, and a correct password gives back what
//! it took.

use std::collections::BTreeMap;
use std::net::{IpAddr, Ipv6Addr};
use std::time::Duration;
use units::MonoTime;

/// Most budgets kept; beyond that the fullest are dropped, where it matters least.
const BUDGETS: usize = 20_000;

/// Source and target of a guess.
#[derive(Debug, Clone)]
pub(crate) struct Guess {
    pub address: IpAddr,
    /// Name of the account in lower case, whether it exists or not.
    pub account: String,
    /// The hash of the browser's cookie, when the browser is known to be the account's.
    pub device: Option<[u8; 32]>,
}

#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
enum Key {
    Address(IpAddr),
    Both(IpAddr, String),
    Account(String),
    Device([u8; 32]),
    Link(IpAddr),
}

impl Key {
    /// Failures (for links: uses) at once, and the time after which one is restored.
    const fn allowance(&self) -> (u32, Duration) {
        match self {
            Self::Address(_) => (30, Duration::from_secs(20)),
            Self::Both(..) => (6, Duration::from_secs(30)),
            Self::Account(_) => (60, Duration::from_secs(10)),
            Self::Device(_) => (10, Duration::from_secs(10)),
            Self::Link(_) => (300, Duration::from_secs(1)),
        }
    }
}

/// When a budget will be full again; the later, the emptier it is.
type WholeAt = MonoTime;

/// The budgets.
#[derive(Debug, Default)]
pub(crate) struct Limiter(BTreeMap<Key, WholeAt>);

impl Limiter {
    /// Takes one guess from the budgets before the password is checked.
    ///
    /// # Errors
    /// The time after which to try again.
    pub(crate) fn take(&mut self, guess: &Guess, now: MonoTime) -> Result<(), Duration> {
        self.take_all(keys(guess), now)
    }

    /// Takes one use of a link by an address.
    ///
    /// # Errors
    /// The time after which to try again.
    pub(crate) fn take_link(&mut self, address: IpAddr, now: MonoTime) -> Result<(), Duration> {
        self.take_all(vec![Key::Link(network(address))], now)
    }

    fn take_all(&mut self, keys: Vec<Key>, now: MonoTime) -> Result<(), Duration> {
        let wait = keys.iter().filter_map(|key| self.wait(key, now)).max();
        if let Some(wait) = wait {
            return Err(wait);
        }
        for key in keys {
            let (_, each) = key.allowance();
            let whole_at = self.0.get(&key).copied().unwrap_or_default().max(now) + each;
            self.0.insert(key, whole_at);
        }
        if self.0.len() > BUDGETS {
            self.forget(now);
        }
        Ok(())
    }

    /// Gives the guess back, because it was correct.
    pub(crate) fn give_back(&mut self, guess: &Guess) {
        for key in keys(guess) {
            let (_, each) = key.allowance();
            if let Some(whole_at) = self.0.get_mut(&key) {
                let micros = whole_at.micros().saturating_sub(each.as_micros() as u64);
                *whole_at = MonoTime::from_micros(micros);
            }
        }
    }

    fn wait(&self, key: &Key, now: MonoTime) -> Option<Duration> {
        let (count, each) = key.allowance();
        let behind = self.0.get(key)?.since(now);
        let allowed = each * (count - 1);
        (behind > allowed).then(|| behind.saturating_sub(allowed))
    }

    /// Keeps the emptier half.
    fn forget(&mut self, now: MonoTime) {
        self.0.retain(|_, whole_at| *whole_at > now);
        if self.0.len() > BUDGETS {
            let spent = |key: &Key, whole_at: MonoTime| {
                whole_at.since(now).as_micros() / key.allowance().1.as_micros()
            };
            let mut order: Vec<u128> = self.0.iter().map(|(key, at)| spent(key, *at)).collect();
            order.sort_unstable();
            let middle = order[order.len() / 2];
            let emptier = order.iter().filter(|spent| **spent > middle).count();
            let mut room = (BUDGETS / 2).saturating_sub(emptier);
            self.0.retain(|key, at| {
                let spent = spent(key, *at);
                let tie = spent == middle && room > 0;
                room -= usize::from(tie);
                spent > middle || tie
            });
        }
    }
}

fn keys(guess: &Guess) -> Vec<Key> {
    if let Some(device) = guess.device {
        return vec![Key::Device(device)];
    }
    let network = network(guess.address);
    let account = guess.account.clone();
    vec![Key::Address(network), Key::Both(network, account.clone()), Key::Account(account)]
}

/// IPv6 customers are handed a /64: all of it is one address here.
pub fn network(address: IpAddr) -> IpAddr {
    match address.to_canonical() {
        IpAddr::V6(address) => IpAddr::V6(Ipv6Addr::from_bits(address.to_bits() & !u128::from(u64::MAX))),
        address @ IpAddr::V4(_) => address,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(seconds: u64) -> MonoTime {
        MonoTime::from_micros(seconds * 1_000_000)
    }

    fn guess(address: &str, account: &str) -> Guess {
        Guess { address: address.parse().unwrap(), account: account.to_owned(), device: None }
    }

    #[test]
    fn links_are_opened_300_times_at_once_from_a_network_and_then_once_a_second() {
        let mut limiter = Limiter::default();
        let (here, there) = ("192.0.2.1".parse().unwrap(), "192.0.2.2".parse().unwrap());
        let taken = (0..400).filter(|_| limiter.take_link(here, at(1)).is_ok()).count();
        assert_eq!(taken, 300);
        assert!(limiter.take_link(here, at(1)).is_err() && limiter.take_link(here, at(2)).is_ok());
        assert!(
            limiter.take_link(there, at(2)).is_ok()
                && limiter.take(&guess("192.0.2.1", "nils"), at(2)).is_ok()
        );
    }

    #[test]
    fn six_guesses_then_one_in_half_a_minute() {
        let mut limiter = Limiter::default();
        let guess = guess("192.0.2.1", "nils");
        let taken = (0..20).filter(|_| limiter.take(&guess, at(1)).is_ok()).count();
        assert_eq!(taken, 6);
        assert_eq!(limiter.take(&guess, at(1)).unwrap_err(), Duration::from_secs(30));
        assert!(limiter.take(&guess, at(30)).is_err());
        assert!(limiter.take(&guess, at(31)).is_ok());
        assert!(limiter.take(&guess, at(31)).is_err());
    }

    #[test]
    fn a_right_guess_costs_nothing() {
        let mut limiter = Limiter::default();
        let guess = guess("192.0.2.1", "nils");
        for _ in 0..100 {
            limiter.take(&guess, at(1)).unwrap();
            limiter.give_back(&guess);
        }
    }

    #[test]
    fn trying_many_accounts_from_one_address_is_slowed() {
        let mut limiter = Limiter::default();
        let taken = (0..100).filter(|n| limiter.take(&guess("192.0.2.1", &n.to_string()), at(1)).is_ok());
        assert_eq!(taken.count(), 30);
        assert!(limiter.take(&guess("192.0.2.2", "1"), at(1)).is_ok());
    }

    #[test]
    fn an_ipv6_network_is_one_address() {
        let mut limiter = Limiter::default();
        let taken =
            (0..100).filter(|n| limiter.take(&guess(&format!("2001:db8::{n}"), "nils"), at(1)).is_ok());
        assert_eq!(taken.count(), 6);
    }

    #[test]
    fn a_stranger_slows_strangers_but_not_the_persons_own_browser() {
        let mut limiter = Limiter::default();
        for n in 0..200 {
            limiter.take(&guess(&format!("192.0.2.{n}"), "nils"), at(1)).ok();
        }
        let elsewhere = guess("198.51.100.1", "nils");
        assert!(limiter.take(&elsewhere, at(1)).is_err());
        let own = Guess { device: Some([7; 32]), ..elsewhere };
        assert!(limiter.take(&own, at(1)).is_ok());
        let own_elsewhere = Guess { address: "192.0.2.1".parse().unwrap(), ..own };
        assert!(limiter.take(&own_elsewhere, at(1)).is_ok());
    }

    #[test]
    fn memory_is_bounded_and_the_worst_are_remembered() {
        let mut limiter = Limiter::default();
        let worst = guess("192.0.2.1", "nils");
        while limiter.take(&worst, at(1)).is_ok() {}
        for n in 0_u32..30_000 {
            let address = IpAddr::V4(std::net::Ipv4Addr::from_bits(0x0A00_0000 + n));
            limiter.take(&Guess { address, account: n.to_string(), device: None }, at(1)).unwrap();
        }
        assert!(limiter.0.len() <= BUDGETS + 3, "{}", limiter.0.len());
        assert!(limiter.take(&worst, at(1)).is_err());
    }
}
