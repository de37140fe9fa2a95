//! `lutra-server user`, `token` and `vessel`: people and access, also while no server runs.

use super::Common;
use super::say::{complain, say};
use anyhow::Context as _;
use api::{NewToken, Role};
use clap::Subcommand;
use rusqlite::Connection;
use shore::clock;
use shore::identity::audit::{self, Act};
use shore::identity::db::within_transaction;
use shore::identity::tokens::{self, NewLink};
use shore::identity::{Fault, one_time_password, open, password, persons, vessels};
use std::io::Read as _;
use units::UtcTime;

#[derive(Debug, Subcommand)]
pub(super) enum UserCommand {
    /// Add a person and print a one-time password.
    Add {
        /// Name to log in with.
        name: String,
        /// viewer, researcher, operator or admin.
        #[arg(long, default_value = "viewer")]
        role: Role,
        /// Only on this vessel (name or IMC address).
        #[arg(long)]
        vessel: Option<String>,
        /// Read the password from standard input instead of making a one-time password.
        #[arg(long)]
        password_stdin: bool,
    },
    /// Give a person a one-time password; all sessions of the person end.
    Passwd {
        /// Who.
        name: String,
        /// Read the password from standard input instead of making a one-time password.
        #[arg(long)]
        password_stdin: bool,
    },
    /// List people and what they may do.
    List,
    /// Give a person a role, or take it with `none`.
    Role {
        /// Who.
        name: String,
        /// viewer, researcher, operator, admin or none.
        role: String,
        /// Only on this vessel (name or IMC address).
        #[arg(long)]
        vessel: Option<String>,
    },
    /// Remove a person with sessions and tokens.
    Remove {
        /// Who.
        name: String,
    },
}

#[derive(Debug, Subcommand)]
pub(super) enum TokenCommand {
    /// Make a token for a script (--person) or for a vessel's link (--link) and print it, this once.
    Create {
        /// For whom the script acts.
        #[arg(long, required_unless_present = "link", conflicts_with = "link")]
        person: Option<String>,
        /// The vessel (name or IMC address) whose link it opens.
        #[arg(long, value_name = "VESSEL")]
        link: Option<String>,
        /// The most that the script may do.
        #[arg(long, default_value = "viewer", conflicts_with = "link")]
        role: Role,
        /// Limit the script to this vessel.
        #[arg(long, conflicts_with = "link")]
        vessel: Option<String>,
        /// Days until the token ends [default: 90 for a script, never for a link].
        #[arg(long)]
        days: Option<u32>,
        /// What it is for.
        #[arg(long, default_value = "made on the command line")]
        label: String,
    },
    /// List tokens, without their secrets.
    List,
    /// Revoke a token by its number.
    Revoke {
        /// Number in `token list`.
        id: i64,
    },
}

#[derive(Debug, Subcommand)]
pub(super) enum VesselCommand {
    /// Name a vessel.
    Add {
        /// Its name on the pages.
        name: String,
        /// IMC address, like 2068 or 0x0814.
        #[arg(value_parser = vessels::address)]
        address: u16,
    },
    /// List the vessels that have names.
    List,
    /// Forget a vessel's name and revoke its link tokens; archive and history stay.
    Remove {
        /// Name or IMC address.
        vessel: String,
    },
}

/// `lutra-server user`.
pub(super) fn user(common: &Common, command: UserCommand) -> anyhow::Result<()> {
    let config = common.load_to_write()?;
    let mut db = open(&config.data)?;
    let least = config.people.password_length;
    match command {
        UserCommand::Add { name, role, vessel, password_stdin } => {
            let (new, told) = new_password(&name, password_stdin, least)?;
            let hash = password::hash(&new);
            act(&mut db, "person.add", &name, |db, now| {
                let vessel = vessel.as_deref().map(|vessel| vessels::named(db, vessel)).transpose()?;
                let id = persons::add(db, &name, &hash, told, now)?;
                persons::set_permission(db, id, vessel, Some(role))
            })?;
            tell_password(&name, &new, told);
        }
        UserCommand::Passwd { name, password_stdin } => {
            let (new, told) = new_password(&name, password_stdin, least)?;
            let hash = password::hash(&new);
            act(&mut db, "person.password", &name, |db, _| {
                persons::set_password(db, persons::known(db, &name)?.id, &hash, told, None)
            })?;
            tell_password(&name, &new, told);
        }
        UserCommand::List => list_people(&db)?,
        UserCommand::Role { name, role, vessel } => {
            let role: Option<Role> = match role.as_str() {
                "none" => None,
                role => Some(role.parse().map_err(anyhow::Error::msg)?),
            };
            let subject = format!("{name}: {}", role.map_or("nothing", Role::name));
            act(&mut db, "person.role", &subject, |db, _| {
                let vessel = vessel.as_deref().map(|vessel| vessels::named(db, vessel)).transpose()?;
                persons::set_permission(db, persons::known(db, &name)?.id, vessel, role)
            })?;
        }
        UserCommand::Remove { name } => {
            act(&mut db, "person.remove", &name, |db, _| persons::remove(db, &name))?;
        }
    }
    Ok(())
}

/// `lutra-server token`.
pub(super) fn token(common: &Common, command: TokenCommand) -> anyhow::Result<()> {
    let mut db = open(&common.load_to_write()?.data)?;
    match command {
        TokenCommand::Create { person, link, role, vessel, days, label } => {
            let made = act(&mut db, "token.make", &label, |db, now| match (&person, &link) {
                (_, Some(link)) => {
                    let vessel = vessels::named(db, link)?;
                    tokens::make_link(db, &NewLink { label: &label, vessel, days }, now)
                }
                (person, None) => {
                    let account = persons::known(db, person.as_deref().unwrap_or_default())?;
                    let vessel = vessel.as_deref().map(|vessel| vessels::named(db, vessel)).transpose()?;
                    let new = NewToken { label: label.clone(), role, vessel, days: days.unwrap_or(90) };
                    tokens::make(db, account.id, &new, now)
                }
            })?;
            complain!("token {}; it is shown this once:", made.id);
            say!("{}", made.secret);
        }
        TokenCommand::List => {
            for token in tokens::list(&db, None)? {
                let owner = token.person.unwrap_or_else(|| "link".to_owned());
                let place = token.vessel.map_or_else(|| "all".to_owned(), |vessel| format!("0x{vessel:04X}"));
                let role = token.role.map_or("link", Role::name);
                let until = token.expires_us.map(|us| clock::written(UtcTime::from_micros(us)));
                let until = until.unwrap_or_else(|| "never".to_owned());
                say!("{}\t{owner}\t{role}\t{place}\tends {until}\t{}", token.id, token.label);
            }
        }
        TokenCommand::Revoke { id } => {
            let label = act(&mut db, "token.revoke", &id.to_string(), |db, _| tokens::revoke(db, id, None))?;
            complain!("revoked: {label}");
        }
    }
    Ok(())
}

/// `lutra-server vessel`.
pub(super) fn vessel(common: &Common, command: VesselCommand) -> anyhow::Result<()> {
    let mut db = open(&common.load_to_write()?.data)?;
    match command {
        VesselCommand::Add { name, address } => {
            act(&mut db, "vessel.add", &name, |db, now| vessels::add(db, address, &name, now))?;
            complain!("a token for its link: lutra-server token create --link {name}");
        }
        VesselCommand::List => {
            for vessel in vessels::list(&db)? {
                say!("{}\t0x{:04X}", vessel.name, vessel.address);
            }
        }
        VesselCommand::Remove { vessel } => {
            act(&mut db, "vessel.remove", &vessel, |db, _| {
                vessels::remove(db, vessels::named(db, &vessel)?)
            })?;
        }
    }
    Ok(())
}

fn list_people(db: &Connection) -> Result<(), Fault> {
    for person in persons::list(db)? {
        let roles = person.permissions.iter().map(|given| match given.vessel {
            None => given.role.to_string(),
            Some(vessel) => format!("{} on 0x{vessel:04X}", given.role),
        });
        let roles: Vec<String> = roles.collect();
        let pending = if person.must_change_password { "\tone-time password" } else { "" };
        say!("{}\t{}{pending}", person.name, roles.join(", "));
    }
    Ok(())
}

/// Does something with its line in the audit log.
fn act<R>(
    db: &mut Connection,
    action: &str,
    subject: &str,
    work: impl FnOnce(&Connection, UtcTime) -> Result<R, Fault>,
) -> Result<R, Fault> {
    let now = clock::now();
    within_transaction(db, |db| {
        let done = work(db, now)?;
        let act = Act { actor: "command line", address: "command line", action, subject, outcome: "done" };
        audit::record(db, act, now)?;
        Ok(done)
    })
}

/// A password, and whether it is a one-time password.
fn new_password(name: &str, from_stdin: bool, least: usize) -> anyhow::Result<(String, bool)> {
    if !from_stdin {
        return Ok((one_time_password(), true));
    }
    let mut text = String::new();
    std::io::stdin().take(4_096).read_to_string(&mut text).context("cannot read the password")?;
    let text = text.trim_end_matches(['\r', '\n']).to_owned();
    password::check_new(name, &text, least).map_err(anyhow::Error::msg)?;
    Ok((text, false))
}

fn tell_password(name: &str, password: &str, one_time: bool) {
    if one_time {
        complain!("one-time password of {name}; it must be changed at the first login:");
        say!("{password}");
    }
}
