//! Rows of tables, with everything written out for people.

use super::actions;
use super::words::{said, t};
use api::{AuditEntry, Person, Role, Session, Token, Vessel};
use shore::clock::written;
use shore::identity::{Language, audit as log};
use units::UtcTime;

pub(super) struct PersonRow {
    pub(super) name: String,
    pub(super) roles: Vec<String>,
    pub(super) one_time: bool,
    pub(super) since: String,
    /// What ends with the account, in words.
    pub(super) loses: String,
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
    /// What ends with it, in words.
    pub(super) loses: String,
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

/// The address of older rows under the same filter.
pub(super) fn older(path: &str, filter: &[(&str, &str)], before: i64) -> String {
    let kept = filter.iter().filter(|(_, value)| !value.is_empty());
    let mut query = form_urlencoded::Serializer::new(String::new());
    query.extend_pairs(kept).append_pair("before", &before.to_string());
    format!("{path}?{}", query.finish())
}

/// A time as it is typed or picked, in UTC (µs since 1970); nothing where it is empty.
pub(super) fn picked_us(text: &str) -> Result<Option<i64>, ()> {
    let text = text.trim().trim_end_matches(['Z', 'z']).replacen(' ', "T", 1);
    if text.is_empty() {
        return Ok(None);
    }
    // People and pickers leave seconds out where they are zero.
    let whole =
        if text.len() == "2026-06-01T12:00".len() { format!("{text}:00Z") } else { format!("{text}Z") };
    whole.parse::<UtcTime>().map(|time| Some(time.micros())).map_err(|_| ())
}

pub(super) fn at(us: i64) -> String {
    written(UtcTime::from_micros(us))
}

/// The name of a vessel, or its address.
pub(super) fn vessel_name(address: u16, vessels: &[Vessel]) -> String {
    let named = vessels.iter().find(|vessel| vessel.address == address);
    named.map_or_else(|| format!("0x{address:04X}"), |vessel| vessel.name.clone())
}

/// `sessions` and `tokens` are those of everybody.
pub(super) fn person(
    language: Language,
    person: Person,
    vessels: &[Vessel],
    sessions: &[Session],
    tokens: &[Token],
) -> PersonRow {
    let place = |vessel: Option<u16>| {
        vessel.map_or_else(|| t(language, "all vessels").to_string(), |vessel| vessel_name(vessel, vessels))
    };
    let roles = person.permissions.iter();
    let roles: Vec<String> = roles.map(|given| role_on(language, given.role, &place(given.vessel))).collect();
    let sessions = sessions.iter().filter(|session| session.person == person.name).count();
    let tokens = tokens.iter().filter(|token| token.person.as_ref() == Some(&person.name));
    let tokens: Vec<&str> = tokens.map(|token| &*token.label).collect();
    let loses = [
        if roles.is_empty() { t(language, "no role").to_string() } else { roles.join(", ") },
        match sessions {
            1 => t(language, "1 session").to_string(),
            more => t(language, "{n} sessions").with("n", more).to_string(),
        },
        if tokens.is_empty() {
            t(language, "no tokens").to_string()
        } else {
            t(language, "the tokens {names}").with("names", tokens.join(", ")).to_string()
        },
    ];
    PersonRow {
        name: person.name,
        roles,
        loses: loses.join("; "),
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

/// A role with where it holds.
fn role_on(language: Language, role: Role, place: &str) -> String {
    let role = said(language, role.name()).to_owned();
    t(language, "{role} on {place}").with("role", role).with("place", place).to_string()
}

pub(super) fn token(language: Language, token: Token, vessels: &[Vessel]) -> TokenRow {
    let everywhere = || t(language, "all vessels").to_string();
    let place = token.vessel.map_or_else(everywhere, |vessel| vessel_name(vessel, vessels));
    let never = || t(language, "never").to_string();
    let loses = match &token.person {
        Some(person) => t(language, "Scripts that use it in the name of {person} are refused at once.")
            .with("person", person),
        None => {
            t(language, "The link of {vessel} ends at once, and the vessel does not come in by it again.")
                .with("vessel", &place)
        }
    };
    let scope = match token.role {
        Some(role) => role_on(language, role, &place),
        None => t(language, "link of {vessel}").with("vessel", &place).to_string(),
    };
    TokenRow {
        id: token.id,
        loses: loses.to_string(),
        label: token.label,
        scope,
        person: token.person.unwrap_or_else(|| "—".to_owned()),
        since: at(token.created_us),
        until: token.expires_us.map_or_else(never, at),
        used: token.used_us.map_or_else(never, at),
    }
}

/// `vessels` gives names to what was done to a vessel. What became of it begins with a word in `language`; details stay as
/// they were reported.
pub(super) fn audit(language: Language, mut entry: AuditEntry, vessels: &[Vessel]) -> AuditRow {
    entry.action = actions::words(&entry.action).to_owned();
    let (first, rest) = entry.subject.split_once(' ').unwrap_or((&entry.subject, ""));
    let named = vessels.iter().find(|vessel| imc::Address(vessel.address).to_string() == first);
    if let Some(vessel) = named {
        entry.subject = if rest.is_empty() { vessel.name.clone() } else { format!("{} {rest}", vessel.name) };
    }
    let bad = log::is_bad(&entry.outcome);
    let stage = entry.outcome.split(':').next().unwrap_or_default();
    if let Some(words) = actions::stage(stage) {
        entry.outcome = format!("{}{}", said(language, words), &entry.outcome[stage.len()..]);
    }
    AuditRow { time: at(entry.time_us), bad, entry }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_ends_with_an_account_and_a_token_is_named() {
        let token = |id, person: Option<&str>, label: &str| Token {
            id,
            label: label.to_owned(),
            person: person.map(str::to_owned),
            vessel: Some(7),
            role: person.map(|_| api::Role::Viewer),
            created_us: 0,
            expires_us: None,
            used_us: None,
        };
        let tokens = [
            token(1, Some("nils"), "R"),
            token(2, Some("anna"), "grafana"),
            token(3, Some("nils"), "cron"),
            token(4, None, "boat"),
        ];
        let session = |person: &str| Session {
            id: 1,
            person: person.to_owned(),
            created_us: 0,
            seen_us: 0,
            address: String::new(),
            agent: String::new(),
        };
        let vessels = [Vessel { address: 7, name: "otter-7".to_owned() }];
        let nils = |permissions| Person {
            name: "nils".to_owned(),
            must_change_password: false,
            created_us: 0,
            permissions,
        };
        let role = api::Permission { vessel: Some(7), role: api::Role::Operator };
        let told = |permissions, sessions: &[Session]| {
            person(Language::English, nils(permissions), &vessels, sessions, &tokens).loses
        };
        assert_eq!(
            told(vec![role], &[session("nils"), session("anna")]),
            "operator on otter-7; 1 session; the tokens R, cron"
        );
        assert!(told(vec![], &[]).starts_with("no role; 0 sessions"));
        let [script, .., link] = tokens.map(|token| super::token(Language::English, token, &vessels).loses);
        assert!(
            script.contains("in the name of nils") && link.contains("link of otter-7"),
            "{script} {link}"
        );
    }

    #[test]
    fn sizes_have_units_that_people_know() {
        let told = [0, 1_023, 1_024, 1_536 << 10, 2_000 << 30, u64::MAX].map(bytes);
        assert_eq!(told, ["0 B", "1023 B", "1.0 KiB", "1.5 MiB", "2.0 TiB", "16.0 EiB"]);
    }
}
