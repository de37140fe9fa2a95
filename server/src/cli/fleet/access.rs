//! `lutra-server fleet rotate` and `revoke`: new link tokens and VPN keys for a vessel, or an end to its access.

use super::files::Files;
use super::lock::FleetLock;
use super::vpn::{self, Leftover, tell_next, write_vpn};
use super::{Place, RotateArguments, state};
use crate::cli::Common;
use crate::cli::say::{complain, say};
use anyhow::{Context as _, ensure};
use provision::{Fleet, VpnKind};
use shore::clock;
use shore::identity::audit::Record;
use shore::identity::{Connection, Fault, Request, links, tokens, vessels, with, within_transaction};
use std::net::Ipv4Addr;
use std::path::Path;
use units::UtcTime;

pub(super) const DAY_US: i64 = 86_400_000_000;

/// `lutra-server fleet rotate`.
pub(super) fn rotate(common: &Common, arguments: &RotateArguments) -> anyhow::Result<()> {
    let config = common.load_to_write()?;
    let _lock = FleetLock::take(&config.data, "fleet rotate")?;
    let files = Files::new(&config.data, arguments.place.vpn_dir.as_deref());
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
        // Logged before it is done: a kill in between leaves a superfluous line, not an unlogged key.
        let line = (now, state::line("fleet.rotate", &format!("{name}: VPN key")));
        with(&config.data, async |db| within_transaction(db, Record(vec![line])).await)?;
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
    if arguments.vpn {
        say!(
            "{name} has a new VPN key: the boat is off the VPN from the restart below until it is provisioned again"
        );
        put_in_force(&files, &fleet, &name, now)?;
    }
    say!("bring it aboard: lutra-server fleet bundle {name}");
    Ok(())
}

/// Writes the files of the VPN after a vessel's new key, and ends a key that it has by the other kind of VPN.
fn put_in_force(files: &Files, fleet: &Fleet, name: &str, now: UtcTime) -> anyhow::Result<()> {
    if write_vpn(files, fleet)?.whole()? {
        tell_next(fleet.vpn.kind, files)?;
    }
    vpn::of(fleet.vpn.kind.other(), files).forget(name, now)?;
    Leftover::look(files, fleet.vpn.kind)?.remove_files()
}

/// `lutra-server fleet revoke`.
pub(super) fn revoke(common: &Common, name: &str, place: &Place) -> anyhow::Result<()> {
    let config = common.load_to_write()?;
    let _lock = FleetLock::take(&config.data, "fleet revoke")?;
    let files = Files::new(&config.data, place.vpn_dir.as_deref());
    let mut failed = take(&config.data, &files, name)?;
    if files.applied().exists() {
        match update(&files, name) {
            Ok(damaged) => failed.extend(damaged),
            Err(error) => failed.push(format!("files of the VPN: {error:#}")),
        }
    }
    report(name, &failed)
}

/// Brings the files of the VPN up to date after a vessel was revoked. Returns what is damaged, of other vessels too.
fn update(files: &Files, name: &str) -> anyhow::Result<Vec<String>> {
    let fleet = state::applied(files)?;
    let written = write_vpn(files, &fleet)?;
    if written.changed {
        tell_next(fleet.vpn.kind, files)?;
    }
    if fleet.vessel(name).is_some() {
        say!(
            "{name} is still in the fleet file: the next `fleet apply` makes new access for it, with new secrets"
        );
    }
    Leftover::look(files, fleet.vpn.kind)?.remove_files()?;
    let mut damaged = written.damaged;
    if !vpn::of(fleet.vpn.kind, files).has_shore()? {
        damaged.push(format!(
            "the server's key of the VPN is not there, so nothing was written that refuses {name}: bring it back from a backup and run \
             this again; until then {}",
            by_hand(fleet.vpn.kind, name)
        ));
    }
    Ok(damaged)
}

/// Ends a vessel's access, part by part: what fails holds up no other part. The caller updates the files of the VPN.
/// Returns what failed.
///
/// # Errors
/// There is no such vessel.
pub(super) fn take(data: &Path, files: &Files, name: &str) -> anyhow::Result<Vec<String>> {
    let now = clock::now();
    let has_key = has_key(files, name);
    let revoke = Revoke { name: name.to_owned(), has_key, now };
    let mut failed = Vec::new();
    match with(data, async |db| within_transaction(db, revoke).await) {
        Ok(tokens) => {
            let s = if tokens == 1 { "" } else { "s" };
            say!("{name}: {tokens} link token{s} revoked; its name and recordings stay");
        }
        Err(error) if has_key => failed.push(format!("link tokens: {error}")),
        Err(error) => return Err(error.into()),
    }
    if let Err(error) = files.forget_token(name) {
        failed.push(format!("stored link token: {error:#}"));
    }
    for kind in VpnKind::ALL {
        match vpn::of(kind, files).forget(name, now) {
            Ok(true) => say!("{name}: its key by {} is ended", kind.name()),
            Ok(false) => {}
            Err(error) => {
                failed.push(format!("{}: {error:#}; until then {}", kind.name(), by_hand(kind, name)));
            }
        }
    }
    Ok(failed)
}

/// How root refuses a boat without the files of the fleet.
fn by_hand(kind: VpnKind, name: &str) -> String {
    match kind {
        VpnKind::WireGuard => format!(
            "take the [Peer] of {name} out of /etc/wireguard/lutra.conf by hand and `sudo systemctl try-restart wg-quick@lutra`"
        ),
        VpnKind::OpenVpn => format!(
            "refuse it by hand: `sudo rm -f /etc/openvpn/server/lutra.ccd/{name} && sudo systemctl try-restart openvpn-server@lutra`"
        ),
    }
}

/// Reports what could not be done.
///
/// # Errors
/// Something failed.
pub(super) fn report(name: &str, failed: &[String]) -> anyhow::Result<()> {
    for part in failed {
        complain!("not done: {part}");
    }
    let s = if failed.len() == 1 { "" } else { "s" };
    ensure!(
        failed.is_empty(),
        "{} part{s} of this could not be done, all others are: mend that, then run `lutra-server fleet revoke {name}` again",
        failed.len()
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
    now: UtcTime,
}

impl Request for Revoke {
    /// How many tokens ended.
    type Answer = u64;

    async fn run(self, db: &mut Connection) -> Result<u64, Fault> {
        let Self { name, has_key, now } = self;
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
        Record(vec![(now, state::line("fleet.revoke", &name))]).run(db).await?;
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
