//! `lutra-server fleet`: a fleet from one file: vessels, link tokens, keys and files of the VPN, and a bundle for each boat.
//!
//! `files` has the fleet's files in the data folder, `state` reads their state and that of app.db, `apply` makes both match the
//! fleet file, `vpn` has its keys and files, by WireGuard or OpenVPN, `bundle` makes the file that is carried aboard, `access`
//! renews and revokes a vessel's credentials, `lock` keeps commands apart that write, `look` reads the fleet file and compares it
//! with the server's and the agent's configuration.

mod access;
mod apply;
mod bundle;
mod files;
mod lock;
mod look;
mod state;
mod vpn;

use super::Common;
use clap::{ArgGroup, Args, Subcommand};
use std::path::PathBuf;

#[derive(Debug, Subcommand)]
pub(super) enum FleetCommand {
    /// Read a fleet file and report everything that is wrong with it, with line and remedy. Changes nothing.
    Check {
        /// The fleet file; deploy/fleet.example.toml explains every key.
        file: PathBuf,
    },
    /// Make vessels, link tokens, and keys and files of the VPN as a fleet file says. First prints what it will do.
    ///
    /// A second run changes nothing. A vessel that is no longer in the file is reported and keeps its access, unless
    /// --revoke names it.
    Apply(ApplyArguments),
    /// Write one sealed file with everything that a boat needs, for `lutra-agent provision`, and print its passphrase, this once.
    Bundle(BundleArguments),
    /// Make a new link token or VPN key for a vessel. The boat needs a new bundle.
    Rotate(RotateArguments),
    /// Take a vessel's access: its link tokens and its place in the VPN. Its name and recordings stay.
    ///
    /// Link tokens end first, then keys of the VPN, each by itself. Where a part cannot be done the command says what is left, and
    /// fails; it can be run again.
    Revoke {
        /// The vessel.
        name: String,
        #[command(flatten)]
        place: Place,
    },
}

/// Where the files of the VPN go.
#[derive(Debug, Args)]
pub(super) struct Place {
    /// Folder for the files of the VPN [default: that of the last `fleet apply`, at first DATA/vpn].
    #[arg(long, value_name = "DIR")]
    vpn_dir: Option<PathBuf>,
}

#[derive(Debug, Args)]
pub(super) struct ApplyArguments {
    /// The fleet file.
    file: PathBuf,
    /// Only print what would be done.
    #[arg(long)]
    dry_run: bool,
    /// Take the access of this vessel, which is no longer in the file; may be repeated.
    #[arg(long, value_name = "NAME")]
    revoke: Vec<String>,
    /// Make another key of the server for the VPN where its own is lost and boats have theirs. Every boat is off the VPN until it
    /// has a new bundle: bring the key back from the backup where there is one.
    #[arg(long)]
    new_server_key: bool,
    #[command(flatten)]
    place: Place,
}

#[derive(Debug, Args)]
pub(super) struct BundleArguments {
    /// The vessel, as the fleet file that was applied last calls it.
    name: String,
    /// The file to write [default: NAME.bundle].
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Take the passphrase from this file instead of making one; 12 characters or more.
    #[arg(long, value_name = "FILE")]
    passphrase_file: Option<PathBuf>,
    /// The authority that signed the server's certificate, where it is not the one of `tls init`.
    #[arg(long, value_name = "FILE")]
    authority: Option<PathBuf>,
    /// Leave the sea chart out; it comes by the link, later.
    #[arg(long)]
    no_chart: bool,
    #[command(flatten)]
    place: Place,
}

#[derive(Debug, Args)]
#[command(group = ArgGroup::new("what").required(true).multiple(true))]
pub(super) struct RotateArguments {
    /// The vessel.
    name: String,
    /// A new link token. The old one stays good for --grace-days, so that the boat is reached until it has the new one.
    #[arg(long, group = "what")]
    token: bool,
    /// A new VPN key. The old one opens nothing any more: the boat is off the VPN until it is provisioned again.
    #[arg(long, group = "what")]
    vpn: bool,
    /// Days for which the old token stays good; 0 ends it at once.
    #[arg(long, default_value_t = 14, value_parser = clap::value_parser!(u32).range(0..=365))]
    grace_days: u32,
    #[command(flatten)]
    place: Place,
}

/// Runs the subcommand.
pub(super) fn fleet(common: &Common, command: FleetCommand) -> anyhow::Result<()> {
    match command {
        FleetCommand::Check { file } => look::check(common, &file),
        FleetCommand::Apply(arguments) => apply::apply(common, &arguments),
        FleetCommand::Bundle(arguments) => bundle::bundle(common, &arguments),
        FleetCommand::Rotate(arguments) => access::rotate(common, &arguments),
        FleetCommand::Revoke { name, place } => access::revoke(common, &name, &place),
    }
}
