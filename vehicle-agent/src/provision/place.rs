//! Paths of a bundle's files: those of the Debian package, below the boat's root.

use super::account::{AGENT, Account, ROOT, named};
use anyhow::{Context as _, bail, ensure};
use provision::{Bundle, INTERFACE, Part};
use std::fs;
use std::io::ErrorKind;
use std::path::{Component, Path, PathBuf};

/// The packaged configuration, which a boat's overlay requires.
pub(super) const BASE: &str = "etc/lutra/agent.ini";
/// The boat's overlay.
pub(super) const OVERLAY: &str = "etc/lutra/vessel.ini";
/// Record of the bundle that this computer was provisioned with.
pub(super) const RECORD: &str = "etc/lutra/provisioned.json";
/// The systemd drop-in that makes the service use the overlay.
pub(super) const SERVICE: &str = "etc/systemd/system/lutra-agent.service.d/vessel.conf";
/// The sea chart.
pub(super) const CHART: &str = "var/lib/lutra-agent/chart/chart.lutra-index";

/// A file and its path.
pub(super) struct Destination {
    pub(super) path: PathBuf,
    pub(super) bytes: Vec<u8>,
    pub(super) mode: u32,
    /// Owner of the file; `None` keeps the user who runs this.
    pub(super) owner: Option<Account>,
    /// Permissions of a folder that must be made.
    pub(super) folder_mode: u32,
    /// Owner of that folder.
    pub(super) folder_owner: Option<Account>,
}

impl std::fmt::Debug for Destination {
    /// Without the bytes, which may be secret.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Destination")
            .field("path", &self.path)
            .field("mode", &self.mode)
            .finish_non_exhaustive()
    }
}

/// All files that a bundle puts on the boat, the record of it last.
pub(super) fn destinations(bundle: &Bundle, root: &Path) -> anyhow::Result<Vec<Destination>> {
    let owners = Owners::of(root)?;
    let mut all = Vec::new();
    for part in Part::ALL {
        let Some(bytes) = bundle.file(part) else { continue };
        let (place, mode, owner, folder_mode) = match part {
            Part::Overlay => (OVERLAY.to_owned(), 0o640, owners.shared, 0o755),
            Part::Token => (format!("etc/lutra/{}", part.name()), 0o640, owners.shared, 0o755),
            Part::Authority => (format!("etc/lutra/{}", part.name()), 0o644, owners.root, 0o755),
            Part::Vpn => (format!("etc/wireguard/{INTERFACE}.conf"), 0o600, owners.root, 0o700),
            Part::OpenVpn => (format!("etc/openvpn/client/{INTERFACE}.conf"), 0o600, owners.root, 0o755),
            Part::Chart => {
                // The shore may have sent a newer one.
                if root.join(CHART).exists() {
                    continue;
                }
                (CHART.to_owned(), 0o640, owners.agent, 0o750)
            }
        };
        let folder_owner = if part == Part::Chart { owners.agent } else { owners.root };
        all.push(Destination {
            path: within(root, &place)?,
            bytes: bytes.to_vec(),
            mode,
            owner,
            folder_mode,
            folder_owner,
        });
    }
    let record = serde_json::to_vec_pretty(&bundle.manifest).context("the manifest")?;
    for (place, bytes) in [(SERVICE, service(bundle)), (RECORD, record)] {
        let path = within(root, place)?;
        all.push(Destination {
            path,
            bytes,
            mode: 0o644,
            owner: owners.root,
            folder_mode: 0o755,
            folder_owner: owners.root,
        });
    }
    Ok(all)
}

/// Owners of the files.
struct Owners {
    root: Option<Account>,
    /// Owned by root, and readable for the agent.
    shared: Option<Account>,
    agent: Option<Account>,
}

impl Owners {
    fn of(root: &Path) -> anyhow::Result<Self> {
        if !rustix::process::geteuid().is_root() {
            ensure!(root != Path::new("/"), "only root may do this: run it with sudo");
            return Ok(Self { root: None, shared: None, agent: None });
        }
        let agent = named(root, AGENT).with_context(|| {
            format!(
                "{} has no user {AGENT}: install the package lutra-agent first",
                root.join("etc/passwd").display()
            )
        })?;
        Ok(Self {
            root: Some(ROOT),
            shared: Some(Account { user: 0, group: agent.group }),
            agent: Some(agent),
        })
    }
}

/// Makes the service use the overlay; the packaged file is not changed.
fn service(bundle: &Bundle) -> Vec<u8> {
    let manifest = &bundle.manifest;
    let (name, profile) = (&manifest.vessel, &manifest.profile);
    format!(
        "# By `lutra-agent provision`: this computer is {name}.\n[Service]\nExecStart=\n\
         ExecStart=/usr/bin/lutra-agent run /{OVERLAY} --profile {profile} --data /var/lib/lutra-agent\n"
    )
    .into_bytes()
}

/// A path below `root`; refused if a folder on it is a symbolic link, which could lead out of it.
pub(super) fn within(root: &Path, place: &str) -> anyhow::Result<PathBuf> {
    let mut path = root.to_owned();
    for part in Path::new(place).components() {
        let Component::Normal(part) = part else { bail!("{place} is not a place below {}", root.display()) };
        path.push(part);
        match fs::symlink_metadata(&path) {
            Ok(about) if about.is_symlink() => {
                bail!("{} is a symbolic link: put a folder or file in its place", path.display());
            }
            Ok(_) => {}
            Err(error) if error.kind() == ErrorKind::NotFound => {}
            Err(error) => return Err(error).with_context(|| path.display().to_string()),
        }
    }
    Ok(path)
}
