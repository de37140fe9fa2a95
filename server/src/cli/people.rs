//! `lutra-server user`, `token` and `vessel`: people and access, also while no server runs.

use super::Common;
use super::say::{complain, say};
use crate::config::Config;
use anyhow::{Context as _, ensure};
use api::{NewToken, Person, Role, Token};
use clap::Subcommand;
use shore::clock;
use shore::identity::audit::Acted;
use shore::identity::{
    Connection, Fault, Line, Request, one_time_password, password, persons, tokens, vessels, with,
    within_transaction,
};
use std::io::Read as _;
use units::UtcTime;

#[derive(Debug, Subcommand)]
pub(super) enum UserCommand {
    /// Add a person and print a one-time password.
    Add {
        /// Name to log in with.
        name: String,
        /// viewer, researcher, operator, admin, or none for one who sees only what is shared with them.
        #[arg(long, default_value = "viewer")]
        role: String,
        /// Only on this vessel (name or IMC address).
        #[arg(long)]
        vessel: Option<String>,
        /// Read the password from standard input instead of making a one-time password.
        #[arg(long)]
        password_stdin: bool,
    },
    /// Give a person a one-time password; all sessions of the person end.
    Passwd {
        /// The person's name.
        name: String,
        /// Read the password from standard input instead of making a one-time password.
        #[arg(long)]
        password_stdin: bool,
    },
    /// List people and what they may do.
    List,
    /// Give a person a role, or take it with `none`.
    Role {
        /// The person's name.
        name: String,
        /// viewer, researcher, operator, admin or none.
        role: String,
        /// Only on this vessel (name or IMC address).
        #[arg(long)]
        vessel: Option<String>,
    },
    /// Remove a person with sessions and tokens.
    Remove {
        /// The person's name.
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

/// The configuration of a data folder that has people already: a mistyped one must not look like one without anybody.
pub(super) fn existing(common: &Common) -> anyhow::Result<Config> {
    let config = common.load_to_write()?;
    ensure!(
        config.data.join("app.db").is_file(),
        "{} has no app.db: give --data the folder of the server; `lutra-server user add` makes the first person of a new one",
        config.data.display()
    );
    Ok(config)
}

/// The same for a command with which a data folder may begin; it says so, as the folder may be mistyped.
fn may_make(common: &Common) -> anyhow::Result<Config> {
    let config = common.load_to_write()?;
    if !config.data.join("app.db").exists() {
        complain!("{} has no app.db yet: it is made", config.data.display());
    }
    Ok(config)
}

/// `lutra-server user`.
pub(super) fn user(common: &Common, command: UserCommand) -> anyhow::Result<()> {
    let may_be_new = matches!(command, UserCommand::Add { .. });
    let config = if may_be_new { may_make(common)? } else { existing(common)? };
    let (data, least) = (&config.data, config.people.password_length);
    match command {
        UserCommand::Add { name, role, vessel, password_stdin } => {
            let role = role_or_none(&role)?;
            let (new, told) = new_password(&name, password_stdin, least)?;
            let (person, password_hash, now) = (name.clone(), password::hash(&new), clock::now());
            with(data, async |db| {
                let vessel = find(db, vessel.as_deref()).await?;
                let add = persons::Add { name: person, password_hash, must_change: told, vessel, role, now };
                act(db, "person.add", &name, add).await
            })?;
            tell_password(&name, &new, told);
        }
        UserCommand::Passwd { name, password_stdin } => {
            let (new, told) = new_password(&name, password_stdin, least)?;
            let (person, password_hash) = (name.clone(), password::hash(&new));
            let set = persons::SetPassword { name: person, password_hash, must_change: told, keep: None };
            with(data, async |db| act(db, "person.password", &name, set).await)?;
            tell_password(&name, &new, told);
        }
        UserCommand::List => list_people(with(data, async |db| persons::List.run(db).await)?),
        UserCommand::Role { name, role, vessel } => {
            let role = role_or_none(&role)?;
            let subject = format!("{name}: {}", role.map_or("nothing", Role::name));
            with(data, async |db| {
                let vessel = find(db, vessel.as_deref()).await?;
                act(db, "person.role", &subject, persons::SetRole { name, vessel, role }).await
            })?;
        }
        UserCommand::Remove { name } => {
            let remove = persons::Remove(name.clone());
            with(data, async |db| act(db, "person.remove", &name, remove).await)?;
        }
    }
    Ok(())
}

fn role_or_none(text: &str) -> anyhow::Result<Option<Role>> {
    if text == "none" {
        return Ok(None);
    }
    text.parse().map(Some).map_err(|why: String| anyhow::anyhow!("{why}, or none for no role"))
}

/// `lutra-server token`.
pub(super) fn token(common: &Common, command: TokenCommand) -> anyhow::Result<()> {
    let data = existing(common)?.data;
    match command {
        TokenCommand::Create { person, link, role, vessel, days, label } => {
            let (now, subject) = (clock::now(), label.clone());
            let made = with(&data, async |db| {
                if let Some(link) = link {
                    let vessel = vessels::named(db, &link).await?;
                    let make = tokens::MakeLink { label, vessel, days, now };
                    return act(db, "token.make", &subject, make).await;
                }
                let person = persons::Named(person.unwrap_or_default()).run(db).await?.0;
                let vessel = find(db, vessel.as_deref()).await?;
                let new = NewToken { label, role, vessel, days: days.unwrap_or(90) };
                act(db, "token.make", &subject, tokens::Make { person, new, now }).await
            })?;
            complain!("token {}; it is shown this once:", made.id);
            say!("{}", made.secret);
        }
        TokenCommand::List => {
            list_tokens(with(&data, async |db| tokens::List(None).run(db).await)?);
        }
        TokenCommand::Revoke { id } => {
            let revoke = tokens::Revoke { id, person: None };
            let label = with(&data, async |db| act(db, "token.revoke", &id.to_string(), revoke).await)?;
            complain!("revoked: {label}");
        }
    }
    Ok(())
}

/// `lutra-server vessel`.
pub(super) fn vessel(common: &Common, command: VesselCommand) -> anyhow::Result<()> {
    let may_be_new = matches!(command, VesselCommand::Add { .. });
    let data = if may_be_new { may_make(common)? } else { existing(common)? }.data;
    match command {
        VesselCommand::Add { name, address } => {
            let add = vessels::Add { address, name: name.clone(), now: clock::now() };
            with(&data, async |db| act(db, "vessel.add", &name, add).await)?;
            complain!("a token for its link: lutra-server token create --link {name}");
        }
        VesselCommand::List => {
            for vessel in with(&data, async |db| vessels::List.run(db).await)? {
                say!("{}\t0x{:04X}", vessel.name, vessel.address);
            }
        }
        VesselCommand::Remove { vessel } => with(&data, async |db| {
            let remove = vessels::Remove(vessels::named(db, &vessel).await?);
            act(db, "vessel.remove", &vessel, remove).await
        })?,
    }
    Ok(())
}

fn list_people(people: Vec<Person>) {
    for person in people {
        let roles = person.permissions.iter().map(|given| match given.vessel {
            None => given.role.to_string(),
            Some(vessel) => format!("{} on 0x{vessel:04X}", given.role),
        });
        let mut roles: Vec<String> = roles.collect();
        if roles.is_empty() {
            roles.push("none".to_owned());
        }
        let pending = if person.must_change_password { "\tone-time password" } else { "" };
        say!("{}\t{}{pending}", person.name, roles.join(", "));
    }
}

fn list_tokens(tokens: Vec<Token>) {
    for token in tokens {
        let owner = token.person.unwrap_or_else(|| "link".to_owned());
        let place = token.vessel.map_or_else(|| "all".to_owned(), |vessel| format!("0x{vessel:04X}"));
        let role = token.role.map_or("link", Role::name);
        let until = token.expires_us.map(|us| clock::written(UtcTime::from_micros(us)));
        let until = until.unwrap_or_else(|| "never".to_owned());
        say!("{}\t{owner}\t{role}\t{place}\tends {until}\t{}", token.id, token.label);
    }
}

/// The address of the vessel that is named or whose address is given.
async fn find(db: &mut Connection, vessel: Option<&str>) -> Result<Option<u16>, Fault> {
    match vessel {
        Some(text) => vessels::named(db, text).await.map(Some),
        None => Ok(None),
    }
}

/// Who acts, in the audit log.
pub(super) const ACTOR: &str = "command line";

/// Carries out a request, with its line in the audit log.
pub(super) async fn act<R: Request>(
    db: &mut Connection,
    action: &'static str,
    subject: &str,
    request: R,
) -> Result<R::Answer, Fault> {
    let by = || ACTOR.to_owned();
    let (subject, outcome) = (subject.to_owned(), "done".to_owned());
    let line = Line { actor: by(), address: by(), action, subject, outcome };
    within_transaction(db, Acted { request, line, now: clock::now() }).await
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
