//! Rows of tables, with everything written out for people.

use crate::clock::written;
use api::{AuditEntry, Person, Session, Token, Vessel};
use units::UtcTime;

pub(super) struct PersonRow {
    pub(super) name: String,
    pub(super) roles: Vec<String>,
    pub(super) one_time: bool,
    pub(super) since: String,
}

pub(super) struct SessionRow {
    pub(super) id: i64,
    pub(super) person: String,
    pub(super) since: String,
    pub(super) seen: String,
    pub(super) address: String,
    pub(super) agent: String,
    /// Whether it is the one that looks at the page.
    pub(super) own: bool,
}

pub(super) struct TokenRow {
    pub(super) id: i64,
    pub(super) label: String,
    pub(super) person: String,
    pub(super) scope: String,
    pub(super) since: String,
    pub(super) until: String,
    pub(super) used: String,
}

pub(super) struct AuditRow {
    pub(super) time: String,
    pub(super) entry: AuditEntry,
    pub(super) bad: bool,
}

/// A size as people read it.
pub(super) fn bytes(count: u64) -> String {
    const UNITS: [&str; 5] = ["KiB", "MiB", "GiB", "TiB", "PiB"];
    let mut size = count as f64 / 1_024.0;
    if count < 1_024 {
        return format!("{count} B");
    }
    for unit in UNITS {
        if size < 1_000.0 {
            return format!("{size:.1} {unit}");
        }
        size /= 1_024.0;
    }
    format!("{size:.1} EiB")
}

fn at(us: i64) -> String {
    written(UtcTime::from_micros(us))
}

/// The name of a vessel, or its address.
pub(super) fn vessel_name(address: u16, vessels: &[Vessel]) -> String {
    let named = vessels.iter().find(|vessel| vessel.address == address);
    named.map_or_else(|| format!("0x{address:04X}"), |vessel| vessel.name.clone())
}

pub(super) fn person(person: Person, vessels: &[Vessel]) -> PersonRow {
    let place = |vessel: Option<u16>| {
        vessel.map_or_else(|| "all vessels".to_owned(), |vessel| vessel_name(vessel, vessels))
    };
    let roles = person.permissions.iter();
    PersonRow {
        name: person.name,
        roles: roles.map(|given| format!("{} on {}", given.role, place(given.vessel))).collect(),
        one_time: person.must_change_password,
        since: at(person.created_us),
    }
}

pub(super) fn session(session: Session, own: Option<i64>) -> SessionRow {
    SessionRow {
        id: session.id,
        person: session.person,
        since: at(session.created_us),
        seen: at(session.seen_us),
        address: session.address,
        agent: session.agent,
        own: Some(session.id) == own,
    }
}

pub(super) fn token(token: Token, vessels: &[Vessel]) -> TokenRow {
    let place = token.vessel.map_or_else(|| "all vessels".to_owned(), |vessel| vessel_name(vessel, vessels));
    TokenRow {
        id: token.id,
        label: token.label,
        scope: token.role.map_or_else(|| format!("link of {place}"), |role| format!("{role} on {place}")),
        person: token.person.unwrap_or_else(|| "—".to_owned()),
        since: at(token.created_us),
        until: token.expires_us.map_or_else(|| "never".to_owned(), at),
        used: token.used_us.map_or_else(|| "never".to_owned(), at),
    }
}

pub(super) fn audit(entry: AuditEntry) -> AuditRow {
    AuditRow { time: at(entry.time_us), bad: entry.outcome != "done", entry }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_have_units_that_people_know() {
        let told = [0, 1_023, 1_024, 1_536 << 10, 2_000 << 30, u64::MAX].map(bytes);
        assert_eq!(told, ["0 B", "1023 B", "1.0 KiB", "1.5 MiB", "2.0 TiB", "16.0 EiB"]);
    }
}
