//! `lutra-server fleet apply`: prints what is to be done, then does it.
//!
//! The lines of the audit log about keys come first, then the keys, then one transaction of app.db with names, tokens and their
//! lines, then the files of the VPN, then the end of what a VPN of the other kind or an earlier version left, then the copy of
//! the fleet file. So every key is in the log; after a kill a line may be there twice. Each step is atomic, and the next run
//! checks each again: after any interruption, the same command finishes the work.

use super::files::{self, Files};
use super::lock::FleetLock;
use super::state::{self, Known};
use super::vpn::{self, Leftover, Tunnel, tell_next, write_vpn};
use super::{ApplyArguments, access, look};
use crate::cli::Common;
use crate::cli::say::{complain, say};
use crate::tls::DAY_US;
use anyhow::ensure;
use provision::{Fleet, Vessel};
use shore::clock;
use shore::identity::audit::Record;
use shore::identity::{Connection, Fault, Request, links, tokens, vessels, with, within_transaction};
use std::net::Ipv4Addr;
use std::path::{Path, PathBuf};
use units::UtcTime;

/// A token that the fleet's folder no longer holds stays valid for this long: the boat may have it.
const GRACE_DAYS: i64 = 14;

/// `lutra-server fleet apply`.
pub(super) fn apply(common: &Common, arguments: &ApplyArguments) -> anyhow::Result<()> {
    let config = if arguments.dry_run { common.load(Vec::new())? } else { common.load_to_write()? };
    let (fleet, text) = look::read(&arguments.file)?;
    let _lock = if arguments.dry_run { None } else { Some(FleetLock::take(&config.data, "fleet apply")?) };
    let files = Files::of(&config, &arguments.place)?;
    let known = Known::look(&config.data, &files, &fleet, clock::now())?;
    let tunnel = vpn::of(fleet.vpn.kind, &files);
    refuse(&conflicts(&files, &*tunnel, &fleet, &known, &arguments.revoke)?)?;
    let allowed = if arguments.new_server_key {
        Ok(())
    } else {
        vpn::require_no_lost_server_key(fleet.vpn.kind, &files, known.bundled)
    };
    let plan = match allowed.and_then(|()| Plan::make(&files, &*tunnel, &fleet, &text, &known)) {
        // A revocation waits for no other boat's file.
        Err(error) if !arguments.revoke.is_empty() && !arguments.dry_run => {
            let mut failed = access::take_all(&config.data, &files, &arguments.revoke);
            failed.push(format!("the rest of {}: {error:#}", arguments.file.display()));
            return access::finish(&files, &arguments.revoke, failed);
        }
        plan => plan?,
    };
    for doubt in look::doubts(&fleet, &config).into_iter().chain(tunnel.doubts(clock::now())?) {
        complain!("note: {doubt}");
    }
    if arguments.new_server_key && !plan.server_key {
        complain!("note: --new-server-key does nothing: the server has its key of the VPN, which stays");
    }
    tell_left(&*tunnel, &fleet, &known, &arguments.revoke)?;
    for name in &arguments.revoke {
        say!("will take the access of {name}");
    }
    plan.tell(&files, &*tunnel);
    if plan.is_empty() && arguments.revoke.is_empty() {
        ensure!(plan.damaged.is_empty(), "{}", plan.damaged.join("; "));
        if !arguments.dry_run {
            files.remember(&arguments.place)?;
        }
        say!("nothing to do: all is as {} says", arguments.file.display());
        return Ok(());
    }
    if arguments.dry_run {
        say!("nothing was done (--dry-run)");
        return Ok(());
    }
    // All of these, before anything else: what cannot be done for one holds up none of the others.
    let failed = access::take_all(&config.data, &files, &arguments.revoke);
    if !failed.is_empty() {
        return access::finish(&files, &arguments.revoke, failed);
    }
    files.remember(&arguments.place)?;
    plan.carry_out(&config.data, &files, &fleet, &text)?;
    say!("done");
    // Also where the files are as they were: a run before that broke off may have written them and not said so.
    tell_next(&fleet, &files);
    Ok(())
}

fn refuse(conflicts: &[String]) -> anyhow::Result<()> {
    for conflict in conflicts {
        complain!("{conflict}");
    }
    let s = if conflicts.len() == 1 { "" } else { "s" };
    ensure!(conflicts.is_empty(), "{} conflict{s} with what is there; nothing was done", conflicts.len());
    Ok(())
}

/// Contradictions between the file and the present state.
fn conflicts(
    files: &Files,
    tunnel: &dyn Tunnel,
    fleet: &Fleet,
    known: &Known,
    revoke: &[String],
) -> anyhow::Result<Vec<String>> {
    let mut conflicts = Vec::new();
    for Vessel { name, imc_address, .. } in &fleet.vessels {
        for there in &known.vessels {
            let (same_name, same_address) = (there.name == *name, there.address == *imc_address);
            if same_name != same_address || !same_name && there.name.eq_ignore_ascii_case(name) {
                conflicts.push(format!(
                    "{name} is 0x{imc_address:04X} in the file, and app.db knows {} as 0x{:04X}: mend the file, or forget that \
                     name (`lutra-server vessel remove {}`; recordings stay)",
                    there.name, there.address, there.name
                ));
            }
        }
    }
    for name in vpn::left(tunnel, fleet)? {
        // What is revoked may be damaged.
        if revoke.contains(&name) {
            continue;
        }
        let Some(address) = vpn::held(tunnel, &name) else { continue };
        let taken = fleet.vessels.iter().find(|vessel| vessel.vpn_address == address);
        let by = taken.map(|vessel| vessel.name.as_str());
        let by = by.or_else(|| (fleet.vpn.server_address == address).then_some("the server"));
        if let Some(by) = by {
            conflicts.push(format!(
                "{address} is given to {by}, and {name}, which is no longer in the file, still has it: --revoke {name}, or \
                 take another address"
            ));
        }
    }
    for name in revoke {
        if fleet.vessel(name).is_some() {
            conflicts.push(format!("--revoke {name}: it is in the file; take it out of the file first"));
        } else if !access::has_key(files, name) && known.vessels.iter().all(|vessel| vessel.name != *name) {
            conflicts.push(format!("--revoke {name}: there is no such vessel"));
        }
    }
    Ok(conflicts)
}

/// Reports vessels that are known and no longer in the file.
fn tell_left(tunnel: &dyn Tunnel, fleet: &Fleet, known: &Known, revoke: &[String]) -> anyhow::Result<()> {
    let mut keys = tunnel.names()?;
    keys.retain(|name| vpn::held(tunnel, name).is_some());
    let mut names: Vec<&str> = known.vessels.iter().map(|vessel| vessel.name.as_str()).collect();
    names.extend(
        keys.iter().map(String::as_str).filter(|name| known.vessels.iter().all(|one| one.name != *name)),
    );
    for name in names {
        if fleet.vessel(name).is_some() || revoke.iter().any(|revoked| revoked == name) {
            continue;
        }
        let link =
            known.vessels.iter().any(|vessel| vessel.name == name && known.open.contains(&vessel.address));
        let has = match (link, keys.iter().any(|key| key == name)) {
            (true, true) => "keeps its link token and its place in the VPN",
            (true, false) => "keeps its link token",
            (false, true) => "keeps its place in the VPN",
            (false, false) => {
                complain!("note: {name} is not in the file, and has no access");
                continue;
            }
        };
        complain!("note: {name} is not in the file and {has}: --revoke {name} takes them");
    }
    Ok(())
}

/// A vessel's key: a new one, or its present one at another address.
#[derive(Debug)]
struct KeyStep {
    name: String,
    address: Ipv4Addr,
    new: bool,
}

/// What is to be done.
#[derive(Debug)]
struct Plan {
    names: Vec<(String, u16)>,
    tokens: Vec<(String, u16)>,
    server_key: bool,
    keys: Vec<KeyStep>,
    /// Whether files of the VPN differ.
    vpn: bool,
    /// What a VPN of the other kind left.
    left: Leftover,
    /// What an earlier version left.
    remains: Vec<PathBuf>,
    /// Whether the copy of the fleet file does.
    copy: bool,
    /// Vessels' files that are damaged or lost, which a person must mend.
    damaged: Vec<String>,
}

impl Plan {
    fn make(
        files: &Files,
        tunnel: &dyn Tunnel,
        fleet: &Fleet,
        text: &str,
        known: &Known,
    ) -> anyhow::Result<Self> {
        let address = |vessel: &Vessel| (vessel.name.clone(), vessel.imc_address);
        let unnamed = |vessel: &&Vessel| known.vessels.iter().all(|there| there.name != vessel.name);
        let mut keys = Vec::new();
        for vessel in &fleet.vessels {
            let present = tunnel.address(&vessel.name)?;
            if present != Some(vessel.vpn_address) {
                keys.push(KeyStep {
                    name: vessel.name.clone(),
                    address: vessel.vpn_address,
                    new: present.is_none(),
                });
            }
        }
        let server_key = !tunnel.has_shore()?;
        let vpn = server_key || !keys.is_empty() || vpn::differs(tunnel, fleet)?;
        let damaged = if vpn { Vec::new() } else { vpn::damaged(tunnel, fleet)? };
        Ok(Self {
            names: fleet.vessels.iter().filter(unnamed).map(address).collect(),
            tokens: fleet
                .vessels
                .iter()
                .filter(|vessel| !known.good.contains(&vessel.name))
                .map(address)
                .collect(),
            server_key,
            keys,
            vpn,
            left: Leftover::look(files, fleet.vpn.kind)?,
            remains: vpn::remains(tunnel, files),
            damaged,
            copy: files::read(&files.applied())?.as_deref() != Some(text),
        })
    }

    const fn is_empty(&self) -> bool {
        self.names.is_empty()
            && self.tokens.is_empty()
            && !self.server_key
            && self.keys.is_empty()
            && !self.vpn
            && self.left.is_empty()
            && self.remains.is_empty()
            && !self.copy
    }

    fn tell(&self, files: &Files, tunnel: &dyn Tunnel) {
        for (name, address) in &self.names {
            say!("will name vessel 0x{address:04X} {name}");
        }
        for (name, _) in &self.tokens {
            say!("will make a link token for {name}");
        }
        if self.server_key {
            say!("will make the server's VPN key: every boat needs a bundle made after that");
        }
        for KeyStep { name, address, new } in &self.keys {
            let what = if *new { "make a VPN key" } else { "move the VPN key" };
            say!("will {what} for {name} at {address}; the boat needs a bundle");
        }
        if self.vpn {
            say!("will write the files of the VPN in {}", tunnel.folder().display());
        }
        self.left.tell();
        for path in &self.remains {
            say!("will remove {}, which an earlier version left", path.display());
        }
        if self.copy {
            say!("will keep the file as {}", files.applied().display());
        }
    }

    /// Does it.
    fn carry_out(self, data: &Path, files: &Files, fleet: &Fleet, text: &str) -> anyhow::Result<()> {
        let now = clock::now();
        let server = self.server_key.then_some("the server");
        let named = server.into_iter().chain(self.keys.iter().map(|step| step.name.as_str()));
        let lines = named.map(|name| state::line("fleet.vpn", name)).chain(self.left.lines());
        let lines: Vec<_> = lines.map(|line| (now, line)).collect();
        if !lines.is_empty() {
            with(data, async |db| within_transaction(db, Record(lines)).await)?;
        }
        let tunnel = vpn::of(fleet.vpn.kind, files);
        if self.server_key {
            tunnel.make_shore(now)?;
        }
        for KeyStep { name, address, new } in &self.keys {
            tunnel.give(name, *address, *new, now)?;
        }
        let change = Change { names: self.names, tokens: self.tokens, files: files.clone(), now };
        with(data, async |db| within_transaction(db, change).await)?;
        let written = write_vpn(files, fleet)?;
        self.left.end(files)?;
        files::remove_all(&self.remains)?;
        files::write(&files.applied(), text.as_bytes())?;
        written.whole()
    }
}

/// The change of app.db and of the stored tokens: all of it or nothing.
#[derive(Debug)]
struct Change {
    names: Vec<(String, u16)>,
    tokens: Vec<(String, u16)>,
    files: Files,
    now: UtcTime,
}

impl Request for Change {
    type Answer = ();

    async fn run(self, db: &mut Connection) -> Result<(), Fault> {
        let now = self.now;
        let mut lines = vec![state::line("fleet.apply", "")];
        for (name, address) in self.names {
            lines.push(state::line("vessel.add", &name));
            vessels::Add { address, name, now }.run(db).await?;
        }
        for (name, vessel) in self.tokens {
            let made =
                tokens::MakeLink { label: format!("fleet: {name}"), vessel, days: None, now }.run(db).await?;
            self.files.keep_token(&name, &made.secret).map_err(|error| state::refused(&error))?;
            lines.push(state::line("token.make", &format!("fleet: {name}")));
            // A token that is not in the stored file, after a killed run or a lost file: nothing else would end it.
            let at = UtcTime::from_micros(now.micros() + GRACE_DAYS * DAY_US);
            let label = Some(format!("fleet: {name}"));
            if (links::End { vessel, but: Some(made.id), label, at: Some(at) }).run(db).await? > 0 {
                lines.push(state::line("token.expire", &format!("fleet: {name}")));
            }
        }
        Record(lines.into_iter().map(|line| (now, line)).collect()).run(db).await
    }
}
