//! `lutra-server fleet rotate` and `revoke`: new link tokens and VPN keys for a vessel, or an end to its access.

use super::files::{Became, Files};
use super::lock::FleetLock;
use super::vpn::{self, Leftover, tell_next, write_vpn};
use super::{Place, RotateArguments, state};
use crate::cli::Common;
use crate::cli::say::{complain, say};
use crate::tls::DAY_US;
use anyhow::{Context as _, ensure};
use provision::{Fleet, VpnKind};
use shore::clock;
use shore::identity::audit::Record;
use shore::identity::{Connection, Fault, Request, links, tokens, vessels, with, within_transaction};
use std::net::Ipv4Addr;
use std::path::Path;
use units::UtcTime;

/// `lutra-server fleet rotate`.
pub(super) fn rotate(common: &Common, arguments: &RotateArguments) -> anyhow::Result<()> {
    let config = common.load_to_write()?;
    let _lock = FleetLock::take(&config.data, "fleet rotate")?;
    let files = Files::of(&config, &arguments.place)?;
    let fleet = state::applied(&files)?;
    let vessel = fleet
        .vessel(&arguments.name)
        .with_context(|| format!("the fleet file that was applied last has no vessel {}", arguments.name))?;
    let name = vessel.name.clone();
    let now = clock::now();
    let grace_days = arguments.grace_days;
    let until = UtcTime::from_micros(now.micros() + i64::from(grace_days) * DAY_US);
    let older = if grace_days > 0 { Older::Until(until) } else { Older::End };
    let vpn = arguments.vpn.then_some((fleet.vpn.kind, vessel.vpn_address));
    if vpn.is_some() {
        vpn::require_server_key(&*vpn::of(fleet.vpn.kind, &files), &files)?;
        log_new_key(&config.data, &files, &fleet, &name, now)?;
    }
    let rotate = Rotate {
        name: name.clone(),
        vessel: vessel.imc_address,
        token: arguments.token.then_some(older),
        vpn,
        files: files.clone(),
        now,
    };
    with(&config.data, async |db| within_transaction(db, rotate).await)?;
    if arguments.token {
        say!("{name} has a new link token");
        match grace_days {
            0 => say!(
                "its old one opens nothing any more: the boat is off the link until it is provisioned again"
            ),
            _ => say!("its old one is good until {}: provision the boat before", clock::written(until)),
        }
    }
    say!("bring it aboard: lutra-server fleet bundle {name}");
    if arguments.vpn {
        say!(
            "{name} has a new VPN key: the boat is off the VPN from the restart below until it is provisioned again"
        );
        put_in_force(&files, &fleet, &name, now)?;
    }
    Ok(())
}

/// Logged before it is done: a kill in between leaves a superfluous line, not an unlogged key.
fn log_new_key(data: &Path, files: &Files, fleet: &Fleet, name: &String, now: UtcTime) -> anyhow::Result<()> {
    let mut lines = vec![(now, state::line("fleet.rotate", &format!("{name}: VPN key")))];
    let other = fleet.vpn.kind.other();
    if vpn::of(other, files).names()?.contains(name) {
        lines.push((now, vpn::ended(name, other)));
    }
    Ok(with(data, async |db| within_transaction(db, Record(lines)).await)?)
}

/// Writes the files of the VPN after a vessel's new key, and ends a key that it has by the other kind of VPN.
///
/// # Errors
/// A file cannot be written; or, after all is done, files of other vessels are damaged.
fn put_in_force(files: &Files, fleet: &Fleet, name: &str, now: UtcTime) -> anyhow::Result<()> {
    tell_doubts(files, fleet, now)?;
    let written = write_vpn(files, fleet).with_context(|| {
        format!(
            "not all files of the VPN were written: the old key of {name} may come in, and its new one may not. Run `lutra-server fleet \
             rotate {name} --vpn` again; until then {}",
            by_hand(fleet.vpn.kind, name)
        )
    })?;
    tell_next(fleet, files);
    vpn::of(fleet.vpn.kind.other(), files).forget(name)?;
    Leftover::look(files, fleet.vpn.kind)?.remove_files()?;
    written.whole()
}

/// What a person should know of the other boats' keys.
fn tell_doubts(files: &Files, fleet: &Fleet, now: UtcTime) -> anyhow::Result<()> {
    for doubt in vpn::of(fleet.vpn.kind, files).doubts(now)? {
        complain!("note: {doubt}");
    }
    Ok(())
}

/// `lutra-server fleet revoke`.
pub(super) fn revoke(common: &Common, name: &str, place: &Place) -> anyhow::Result<()> {
    let config = common.load_to_write()?;
    let files = Files::of(&config, place)?;
    let names = [name.to_owned()];
    // The link ends before the lock, so that no other command holds that up.
    let first = end_tokens(&config.data, &files, name, false);
    if first.is_err() && !has_key(&files, name) {
        return first;
    }
    let _lock = match FleetLock::take(&config.data, "fleet revoke") {
        Ok(lock) => lock,
        Err(error) => {
            let tokens = first.err().map(|error| format!("{name}: link tokens: {error:#}"));
            let keys = format!("{name}: stored link token and keys of the VPN: {error:#}");
            return report(&names, &tokens.into_iter().chain([keys]).collect::<Vec<_>>());
        }
    };
    // The command before may have made a token.
    let failed = take(&config.data, &files, name, first.is_ok());
    if state::applied(&files).is_ok_and(|fleet| fleet.vessel(name).is_some()) {
        say!(
            "{name} is still in the fleet file: the next `fleet apply` makes new access for it, with new secrets"
        );
    }
    finish(&files, &names, failed)
}

/// Takes the access of vessels; what fails for one holds up none of the others. The caller holds the lock, and updates the
/// files of the VPN. Returns what failed.
pub(super) fn take_all(data: &Path, files: &Files, names: &[String]) -> Vec<String> {
    names.iter().flat_map(|name| take(data, files, name, false)).collect()
}

/// Brings the files of the VPN up to date after vessels were revoked, and reports what failed.
///
/// # Errors
/// Something failed, here or before.
pub(super) fn finish(files: &Files, names: &[String], mut failed: Vec<String>) -> anyhow::Result<()> {
    if files.applied().exists() {
        match update(files, names) {
            Ok(damaged) => failed.extend(damaged),
            Err(error) => failed.push(format!("files of the VPN: {error:#}{}", until(files, names))),
        }
    } else if !until(files, names).is_empty() {
        let lost = files.applied();
        failed.push(format!(
            "files of the VPN: {} is not there: apply the fleet file again{}",
            lost.display(),
            until(files, names)
        ));
    }
    report(names, &failed)
}

/// How root refuses boats until the files of the VPN are written; empty where there never was one.
fn until(files: &Files, names: &[String]) -> String {
    let had = |kind: &VpnKind| vpn::of(*kind, files).has_shore().unwrap_or(true);
    let steps: Vec<String> = VpnKind::ALL
        .into_iter()
        .filter(had)
        .flat_map(|kind| names.iter().map(move |name| by_hand(kind, name)))
        .collect();
    if steps.is_empty() { String::new() } else { format!("; until then {}", steps.join("; ")) }
}

/// Returns what is damaged, of other vessels too.
fn update(files: &Files, names: &[String]) -> anyhow::Result<Vec<String>> {
    let fleet = state::applied(files)?;
    let tunnel = vpn::of(fleet.vpn.kind, files);
    let missing = match tunnel.has_shore() {
        Ok(true) => None,
        Ok(false) => Some(format!(
            "the files of the VPN were not all written again. {}",
            files.server_key_is(Became::Lost, &tunnel.shore_path())
        )),
        Err(error) => Some(format!("{error:#}")),
    };
    let mut damaged = Vec::new();
    if let Some(why) = missing {
        let until: Vec<String> = names.iter().map(|name| by_hand(fleet.vpn.kind, name)).collect();
        damaged.push(format!("{why}; until then {}", until.join("; ")));
    } else {
        damaged.extend(write_vpn(files, &fleet)?.damaged);
        tell_doubts(files, &fleet, clock::now())?;
        tell_next(&fleet, files);
    }
    Leftover::look(files, fleet.vpn.kind)?.remove_files()?;
    Ok(damaged)
}

/// Ends a vessel's link tokens. Where this was done a moment ago (`again`) it speaks of further ones alone.
///
/// # Errors
/// There is no such vessel, or app.db cannot be written.
fn end_tokens(data: &Path, files: &Files, name: &str, again: bool) -> anyhow::Result<()> {
    let revoke = Revoke { name: name.to_owned(), has_key: has_key(files, name), again, now: clock::now() };
    let tokens = with(data, async |db| within_transaction(db, revoke).await)?;
    if tokens > 0 || !again {
        let s = if tokens == 1 { "" } else { "s" };
        say!("{name}: {tokens} link token{s} revoked; its name and recordings stay");
    }
    Ok(())
}

/// Ends a vessel's access, part by part: what fails holds up no other part. Returns what failed.
fn take(data: &Path, files: &Files, name: &str, again: bool) -> Vec<String> {
    let mut failed = Vec::new();
    if let Err(error) = end_tokens(data, files, name, again) {
        failed.push(format!("{name}: link tokens: {error:#}"));
    }
    if let Err(error) = files.forget_token(name) {
        failed.push(format!("{name}: stored link token: {error:#}"));
    }
    for kind in VpnKind::ALL {
        match vpn::of(kind, files).forget(name) {
            Ok(true) => say!("{name}: its key by {} is ended", kind.name()),
            Ok(false) => {}
            Err(error) => {
                let until = by_hand(kind, name);
                failed.push(format!("{name}: {}: {error:#}; until then {until}", kind.name()));
            }
        }
    }
    failed
}

/// How root refuses a boat without the files of the fleet.
fn by_hand(kind: VpnKind, name: &str) -> String {
    match kind {
        VpnKind::WireGuard => format!(
            "take the [Peer] of {name} out of /etc/wireguard/lutra.conf by hand and `sudo systemctl try-restart wg-quick@lutra`"
        ),
        // One `?` for each digit of the serial number, so that no other boat's file matches.
        VpnKind::OpenVpn => format!(
            "refuse it by hand: `sudo find /etc/openvpn/server/lutra.ccd -name '{name}.????????????????' -delete && sudo systemctl \
             try-restart openvpn-server@lutra`"
        ),
    }
}

/// Reports what could not be done.
///
/// # Errors
/// Something failed.
fn report(names: &[String], failed: &[String]) -> anyhow::Result<()> {
    for part in failed {
        complain!("not done: {part}");
    }
    let s = if failed.len() == 1 { "" } else { "s" };
    let again: Vec<String> = names.iter().map(|name| format!("`lutra-server fleet revoke {name}`")).collect();
    ensure!(
        failed.is_empty(),
        "{} part{s} of this could not be done, all others are: mend that, then run {} again",
        failed.len(),
        again.join(" and ")
    );
    Ok(())
}

/// How a vessel's older tokens end when it gets a new one.
#[derive(Debug, Clone, Copy)]
enum Older {
    /// They are invalid at once.
    End,
    /// They stay valid until then.
    Until(UtcTime),
}

/// A new token, a new key, or both: all of it or nothing. The key is in the audit log already.
struct Rotate {
    name: String,
    vessel: u16,
    /// `Some` for a new token.
    token: Option<Older>,
    /// `Some` for a new key in the VPN of this kind, at this address.
    vpn: Option<(VpnKind, Ipv4Addr)>,
    files: Files,
    now: UtcTime,
}

impl Request for Rotate {
    type Answer = ();

    async fn run(self, db: &mut Connection) -> Result<(), Fault> {
        let Self { name, vessel, token, vpn, files, now } = self;
        let mut lines = Vec::new();
        if let Some(older) = token {
            let at = match older {
                Older::End => None,
                Older::Until(at) => Some(at),
            };
            let made =
                tokens::MakeLink { label: format!("fleet: {name}"), vessel, days: None, now }.run(db).await?;
            links::End { vessel, but: Some(made.id), label: None, at }.run(db).await?;
            files.keep_token(&name, &made.secret).map_err(|error| state::refused(&error))?;
            lines.push((now, state::line("fleet.rotate", &format!("{name}: link token"))));
        }
        if let Some((kind, address)) = vpn {
            let given = vpn::of(kind, &files).give(&name, address, true, now);
            given.map_err(|error| state::refused(&error))?;
        }
        Record(lines).run(db).await
    }
}

/// Ends a vessel's link tokens.
struct Revoke {
    name: String,
    /// Whether it has a key of a VPN: then app.db may not know it.
    has_key: bool,
    /// Whether the audit log has it already, unless a token ends.
    again: bool,
    now: UtcTime,
}

impl Request for Revoke {
    /// How many tokens ended.
    type Answer = u64;

    async fn run(self, db: &mut Connection) -> Result<u64, Fault> {
        let Self { name, has_key, again, now } = self;
        let known = vessels::List.run(db).await?.into_iter().find(|vessel| vessel.name == name);
        if known.is_none() && !has_key {
            return Err(Fault::refused(
                api::say("There is no vessel {name}; see `lutra-server vessel list`.").with("name", name),
            ));
        }
        let tokens = match known {
            Some(vessel) => {
                links::End { vessel: vessel.address, but: None, label: None, at: None }.run(db).await?
            }
            None => 0,
        };
        if tokens > 0 || !again {
            Record(vec![(now, state::line("fleet.revoke", &name))]).run(db).await?;
        }
        Ok(tokens)
    }
}

/// Whether a vessel has a key in a VPN of either kind, or may have one, where that cannot be read.
pub(super) fn has_key(files: &Files, name: &str) -> bool {
    let knows = |kind: VpnKind| {
        vpn::of(kind, files).names().map_or(true, |names| names.iter().any(|known| known == name))
    };
    VpnKind::ALL.into_iter().any(knows)
}
