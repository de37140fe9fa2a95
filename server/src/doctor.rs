//! Checks a server and its data, with remedies: for `lutra-server doctor` and the page about storage.

use crate::config::Config;
use crate::tls::{self, Pair};
use api::Role;
use shore::identity::{self, Fault, Request as _, persons};
use shore::{clock, folder};
use store::{Check, Health};
use units::UtcTime;

/// Days before its end from which an authority should be replaced: every boat must be visited for that.
const AUTHORITY_TOLD_DAYS: i64 = 365;

/// A check whose text includes its remedy, if it needs one.
pub(crate) fn check(name: &'static str, outcome: Result<String, String>) -> Check {
    let health = if outcome.is_ok() { Health::Good } else { Health::Problem };
    let (Ok(found) | Err(found)) = outcome;
    Check { name, health, found, remedy: String::new() }
}

/// Checks everything but sockets. `thorough` reads the whole archive and every page of the history, too; `backup` has the
/// checks of the backup and of retention.
pub(crate) fn look(
    config: &Config,
    thorough: bool,
    backup: impl FnOnce(&Config) -> [Check; 2],
) -> Vec<Check> {
    let mut checks =
        vec![check("clock", clock_is_right()), encryption(config, clock::now()), check("pages", pages())];
    // Not even a lock file may be made in a foreign folder.
    if let Err(error) = folder::check(&config.data) {
        checks.push(check("data folder", Err(format!("{error:#}"))));
        return checks;
    }
    if let Err(error) = folder::refuse_newer(&config.data) {
        checks.push(check("data folder", Err(format!("{error:#}"))));
        return checks;
    }
    checks.push(check("people", people_are_well(config)));
    if config.data.exists() {
        checks.push(rights(config));
        checks.extend(recordings(config, thorough));
        checks.push(store::check_compression(&config.data, config.archive.compress_after_days, clock::now()));
        checks.push(store::check_month_compression(
            &config.data,
            config.history.compress_after_days,
            clock::now(),
        ));
        checks.extend(backup(config));
    } else {
        checks.push(check("data folder", Ok(no_folder(config))));
    }
    checks
}

/// Permissions of the data.
fn rights(config: &Config) -> Check {
    let told = shore::private::look(&config.data).map(|found| found.told(false));
    let (health, found) = match told {
        Ok(told) if told.is_empty() => (Health::Good, "only this user can reach the data".to_owned()),
        Ok(told) => (Health::Warning, told.join("; ")),
        Err(error) => (Health::Problem, error.to_string()),
    };
    Check { name: "rights", health, found, remedy: String::new() }
}

/// The archive and the history.
fn recordings(config: &Config, thorough: bool) -> Vec<Check> {
    store::doctor(&config.data, clock::now(), thorough, &mut |_| true).unwrap_or_else(|error| {
        let remedy = "look whether the folder can be read".to_owned();
        vec![Check { name: "recordings", health: Health::Problem, found: error.to_string(), remedy }]
    })
}

/// Normal before the first start, and probably a typo after it.
fn no_folder(config: &Config) -> String {
    let folder = config.data.display();
    format!(
        "there is no {folder} yet: the first start makes it; if there should be one, look at --data or `data`"
    )
}

fn clock_is_right() -> Result<String, String> {
    let now = clock::now();
    clock::check(now).map(|()| clock::written(now))
}

fn people_are_well(config: &Config) -> Result<String, String> {
    if !config.data.join("app.db").exists() {
        return Ok(format!("no account yet; the first start makes an admin in {}", config.data.display()));
    }
    let (verdict, people) =
        identity::with(&config.data, look_at_people).map_err(|error| error.to_string())?;
    if verdict != "ok" {
        return Err(format!("app.db is damaged ({verdict}): stop the server and put a backup in its place"));
    }
    let waiting = people.iter().filter(|person| person.must_change_password).count();
    let admin = |person: &&api::Person| {
        person.permissions.iter().any(|given| given.vessel.is_none() && given.role == Role::Admin)
    };
    let admins = people.iter().filter(admin).count();
    Ok(format!("{} accounts, {admins} of them admins, {waiting} with a one-time password", people.len()))
}

/// SQLite's check of app.db, and its people.
async fn look_at_people(db: &mut identity::Connection) -> Result<(String, Vec<api::Person>), Fault> {
    let verdict = identity::check(db).await?;
    let people = if verdict == "ok" { persons::List.run(db).await? } else { Vec::new() };
    Ok((verdict, people))
}

/// The certificate: whether it is usable, and how long it and its authority are valid.
fn encryption(config: &Config, now: UtcTime) -> Check {
    let name = "encryption";
    if !config.tls.is_given() {
        return check(name, Ok("not used; the server serves loopback or a VPN".to_owned()));
    }
    let file = config.tls.certificate.display();
    let facts = match Pair::read(&config.tls) {
        Ok(pair) => pair.facts,
        Err(error) => return check(name, Err(format!("{error:#}"))),
    };
    let (days, until) = (tls::days_left(facts.until, now), clock::written(facts.until));
    let renew = "`lutra-server tls renew` renews one that `tls init` made; one from elsewhere is renewed there, and the \
                 server takes the new files by itself"
        .to_owned();
    if facts.from > now {
        let found = format!(
            "{file} is valid only from {}: it was made while a clock was ahead, or this clock is behind. Browsers and boats refuse it until then",
            clock::written(facts.from)
        );
        return Check { name, health: Health::Problem, found, remedy: renew };
    }
    if facts.until <= now {
        let found = format!("{file} ended on {until}: browsers and boats refuse it");
        return Check { name, health: Health::Problem, found, remedy: renew };
    }
    if days < tls::TOLD_DAYS {
        let found = format!("{file} ends on {until}, in {days} days");
        return Check { name, health: Health::Warning, found, remedy: renew };
    }
    let authority = config.data.join("tls/ca.pem");
    if let Ok((_, facts)) = tls::first_in(&authority)
        && tls::days_left(facts.until, now) < AUTHORITY_TOLD_DAYS
    {
        let found = format!("the authority {} ends on {}", authority.display(), clock::written(facts.until));
        let remedy = "make a new one in time (move DATA/tls away, then `lutra-server tls init`): each boat needs a new \
                      bundle, and each browser the new ca.pem"
            .to_owned();
        return Check { name, health: Health::Warning, found, remedy };
    }
    check(name, Ok(format!("{file} and its key fit, until {until}")))
}

fn pages() -> Result<String, String> {
    if crate::web::asset_path("main.css").is_empty() {
        return Err(
            "this program was built without scripts and styles: run `make web` and build it again".to_owned()
        );
    }
    Ok("scripts and styles are there".to_owned())
}
