//! `lutra-agent provision`: makes this computer a vessel's, from the sealed bundle that `lutra-server fleet bundle` wrote.
//!
//! `verify` checks that the bundle is for this computer, complete, and valid now; `place` has the path and owner of each
//! file; `stage` writes the files under other names and renames them when all are on the disk; `missing` checks what else
//! the boat lacks. Paths are defined here and never in the bundle.

mod account;
mod missing;
mod place;
mod stage;
mod verify;

#[cfg(test)]
mod tests;

use crate::doctor::print;
use crate::say::{complain, say};
use anyhow::{Context as _, bail, ensure};
use clap::Args;
use place::Destination;
use provision::{Bundle, BundleError, Part, passphrase_in, sealed_bytes};
use std::fs::{self, File};
use std::io::{self, IsTerminal as _, Read as _};
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};
use units::UtcTime;

/// Enough bytes to determine the length of a bundle.
const HEAD_BYTES: u64 = 64;
/// The longest passphrase that is read.
const PASSPHRASE_BYTES: u64 = 1 << 20;

#[derive(Debug, Args)]
pub(crate) struct ProvisionArguments {
    /// The bundle.
    file: PathBuf,
    /// Root of the boat's file system; for a card that is prepared on another computer.
    #[arg(long, value_name = "DIR", default_value = "/")]
    root: PathBuf,
    /// Only verify, and print what would be written and what is missing.
    #[arg(long)]
    check: bool,
    /// Take a bundle of another vessel, or an older one than this computer has.
    #[arg(long)]
    replace: bool,
    /// Read the passphrase from this file instead of asking for it.
    #[arg(long, value_name = "FILE")]
    passphrase_file: Option<PathBuf>,
}

/// What else the boat lacks is reported, but is no error: it is often added later.
pub(crate) fn provision(arguments: &ProvisionArguments) -> anyhow::Result<()> {
    let ProvisionArguments { file, root, check, replace, passphrase_file } = arguments;
    let sealed = read(file)?;
    let passphrase = passphrase(passphrase_file.as_deref())?;
    let bundle = Bundle::open(sealed, &passphrase).with_context(|| file.display().to_string())?;
    verify::in_time(&bundle, now())?;
    verify::computer(&bundle, root, *replace)?;
    verify::configuration(&bundle, root)?;
    let wanted = place::destinations(&bundle, root)?;
    let due = stage::due(wanted)?;
    let manifest = &bundle.manifest;
    for Destination { path, .. } in &due {
        say!("{} {}", if *check { "would write" } else { "will write" }, path.display());
    }
    if due.is_empty() {
        say!("nothing to do: this computer is {} already", manifest.vessel);
    } else if !check {
        stage::put(&due)?;
        say!("this computer is {} (0x{:04X})", manifest.vessel, manifest.imc_address);
    }
    print(&missing::look(&bundle, root), false);
    if !check && !due.is_empty() {
        tell_next(&bundle, root);
    }
    Ok(())
}

fn tell_next(bundle: &Bundle, root: &Path) {
    let (wireguard, openvpn) = ("wg-quick@lutra", "openvpn-client@lutra");
    let (unit, other, others_file) = match bundle.file(Part::OpenVpn) {
        Some(_) => (openvpn, wireguard, "etc/wireguard/lutra.conf"),
        None => (wireguard, openvpn, "etc/openvpn/client/lutra.conf"),
    };
    say!("next, aboard:");
    if root.join(others_file).exists() {
        say!("  sudo systemctl disable --now {other} && sudo rm /{others_file}    # the VPN before this one");
    }
    say!("  sudo systemctl daemon-reload && sudo systemctl enable {unit} && sudo systemctl restart {unit}");
    say!("  sudo -u lutra-agent lutra-agent doctor /etc/lutra/vessel.ini --data /var/lib/lutra-agent");
    say!(
        "  sudo systemctl enable lutra-agent && sudo systemctl restart lutra-agent    # the motors may turn"
    );
}

/// Reads a bundle. A file that is not a bundle, or not complete, is refused from its first bytes and its length.
fn read(path: &Path) -> anyhow::Result<Vec<u8>> {
    let name = || path.display().to_string();
    let about = fs::metadata(path).with_context(name)?;
    ensure!(about.is_file(), "{} is not a file", path.display());
    let mut file = File::open(path).with_context(name)?;
    let mut bytes = Vec::new();
    file.by_ref().take(HEAD_BYTES).read_to_end(&mut bytes).with_context(name)?;
    let whole = sealed_bytes(&bytes).with_context(name)?;
    let have = about.len();
    if have < whole {
        return Err(BundleError::CutShort { have, whole }).with_context(name);
    }
    file.take(whole.saturating_sub(HEAD_BYTES).saturating_add(1))
        .read_to_end(&mut bytes)
        .with_context(name)?;
    Ok(bytes)
}

fn now() -> UtcTime {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    UtcTime::from_micros(i64::try_from(since.as_micros()).unwrap_or(i64::MAX))
}

/// Reads the passphrase from a file, a pipe or the terminal.
fn passphrase(file: Option<&Path>) -> anyhow::Result<String> {
    let mut text = String::new();
    match file {
        Some(path) => {
            let file = File::open(path).with_context(|| path.display().to_string())?;
            file.take(PASSPHRASE_BYTES)
                .read_to_string(&mut text)
                .with_context(|| path.display().to_string())?;
        }
        None if io::stdin().is_terminal() => text = asked()?,
        None => {
            io::stdin()
                .take(PASSPHRASE_BYTES)
                .read_to_string(&mut text)
                .context("cannot read the passphrase")?;
        }
    }
    let text = passphrase_in(&text).context("give the passphrase in one line")?.to_owned();
    if text.is_empty() {
        bail!(
            "no passphrase was given: `lutra-server fleet bundle` said it; type it, or give --passphrase-file"
        );
    }
    Ok(text)
}

/// Asks without showing what is typed.
fn asked() -> anyhow::Result<String> {
    use rustix::termios::{LocalModes, OptionalActions, tcgetattr, tcsetattr};
    complain!("passphrase of the bundle:");
    let terminal = io::stdin();
    let shown = tcgetattr(&terminal).context("the terminal")?;
    let mut hidden = shown.clone();
    // Ctrl-C is read as a character, so that it does not leave the terminal without echo.
    hidden.local_modes.remove(LocalModes::ECHO | LocalModes::ISIG);
    tcsetattr(&terminal, OptionalActions::Now, &hidden).context("the terminal")?;
    let mut text = String::new();
    let read = terminal.read_line(&mut text);
    tcsetattr(&terminal, OptionalActions::Now, &shown).context("the terminal")?;
    read.context("cannot read the passphrase")?;
    ensure!(!text.contains('\u{3}'), "stopped; nothing was changed");
    Ok(text)
}
