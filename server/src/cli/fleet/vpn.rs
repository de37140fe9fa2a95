//! Writes the files of the VPN where they differ, and prints the steps for root.

use super::files::{self, Files};
use super::state;
use crate::cli::say::say;
use provision::{Fleet, nftables, wireguard};

/// Prints the manual steps that apply the files of the VPN.
pub(super) fn tell_next(files: &Files) {
    let (wireguard, firewall) = (files.wireguard(), files.firewall());
    say!("the VPN goes by the new files once root has them:");
    say!("  sudo install -m 600 {} {} /etc/wireguard/", wireguard.display(), firewall.display());
    say!("  sudo systemctl enable wg-quick@lutra && sudo systemctl restart wg-quick@lutra");
}

/// Writes the files of the VPN where they differ. Returns whether any did.
pub(super) fn write_vpn(files: &Files, fleet: &Fleet) -> anyhow::Result<bool> {
    let Some(key) = files.server_key()? else { return Ok(false) };
    let peers = state::peers(files, fleet)?;
    let mut changed = false;
    for (path, text) in [
        (files.wireguard(), wireguard::ashore(fleet, &key, &peers)),
        (files.firewall(), nftables(fleet, &peers)),
    ] {
        if files::read(&path)?.as_deref() != Some(&text) {
            files::write(&path, text.as_bytes())?;
            changed = true;
        }
    }
    Ok(changed)
}
