//! `lutra-server fleet rotate` and `revoke`: new link tokens and VPN keys for a vessel, or an end to its access.

use super::files::Files;
use super::vpn::{self, tell_next, write_vpn};
use super::{Place, RotateArguments, state};
use crate::cli::Common;
use crate::cli::say::say;
use anyhow::Context as _;
use provision::VpnKind;
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
        if write_vpn(&files, &fleet)? {
            tell_next(fleet.vpn.kind, &files)?;
        }
    }
    say!("bring it aboard: lutra-server fleet bundle {name}");
    Ok(())
}

/// `lutra-server fleet revoke`.
pub(super) fn revoke(common: &Common, name: &str, place: &Place) -> anyhow::Result<()> {
    let config = common.load_to_write()?;
    let files = Files::new(&config.data, place.vpn_dir.as_deref());
    let fleet = files.applied().exists().then(|| state::applied(&files)).transpose()?;
    take(&config.data, &files, name)?;
    if let Some(fleet) = fleet {
        if write_vpn(&files, &fleet)? {
            tell_next(fleet.vpn.kind, &files)?;
        }
        if fleet.vessel(name).is_some() {
            say!(
                "{name} is still in the fleet file: the next `fleet apply` makes new access for it, with new secrets"
            );
        }
    }
    Ok(())
}

/// Ends a vessel's link tokens and deletes its secrets; the caller updates the files of the VPN.
pub(super) fn take(data: &Path, files: &Files, name: &str) -> anyhow::Result<()> {
    let revoke = Revoke { name: name.to_owned(), files: files.clone(), now: clock::now() };
    let Revoked { tokens, had_key } = with(data, async |db| within_transaction(db, revoke).await)?;
    let s = if tokens == 1 { "" } else { "s" };
    let vpn = if had_key { ", its secrets are forgotten" } else { "" };
    say!("{name}: {tokens} link token{s} revoked{vpn}; its name and recordings stay");
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

struct Revoke {
    name: String,
    files: Files,
    now: UtcTime,
}

struct Revoked {
    tokens: u64,
    had_key: bool,
}

impl Request for Revoke {
    type Answer = Revoked;

    async fn run(self, db: &mut Connection) -> Result<Revoked, Fault> {
        let Self { name, files, now } = self;
        let known = vessels::List.run(db).await?.into_iter().find(|vessel| vessel.name == name);
        let has_key = has_key(&files, &name).map_err(|error| state::refused(&error))?;
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
        let had_key = forget(&files, &name, now).map_err(|error| state::refused(&error))?;
        Ok(Revoked { tokens, had_key })
    }
}

/// Whether a vessel has a key in a VPN of either kind.
pub(super) fn has_key(files: &Files, name: &str) -> anyhow::Result<bool> {
    for kind in VpnKind::ALL {
        if vpn::of(kind, files).names()?.iter().any(|known| known == name) {
            return Ok(true);
        }
    }
    Ok(false)
}

/// Deletes a vessel's secrets, of the VPNs of both kinds. Returns whether there were any.
fn forget(files: &Files, name: &str, now: UtcTime) -> anyhow::Result<bool> {
    let mut forgotten = files.forget_token(name)?;
    for kind in VpnKind::ALL {
        forgotten |= vpn::of(kind, files).forget(name, now)?;
    }
    Ok(forgotten)
}
