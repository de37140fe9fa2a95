//! Helpers for the tests of several crates. Only ever a dev-dependency.
//!
//! Recordings and golden vectors that Lutra may read but not ship live in a folder `shared` beside the
//! checkout. A test that needs one asks [`shared`] for it and returns early, with the reason printed, where
//! the folder is absent.
//!
//! It may read files and start programs, and decides nothing: [`shared`] gives recordings, [`browser`] runs Chromium,
//! [`manual`] gives the commands that documents name, [`ServiceManager`] replaces systemd, [`Need`] and [`absent`] say what a test
//! lacks.

pub mod browser;
pub mod manual;
mod needs;
mod numbers;
pub mod sea;
mod service_manager;

pub use needs::{Need, absent, is_emulated, so_many};
pub use numbers::Numbers;
pub use service_manager::ServiceManager;

use std::path::{Path, PathBuf};

/// The root of this checkout.
pub fn repository() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
}

/// The path of `name` in the folder `shared` beside the checkout, or `None`, having said why, where that folder is
/// absent.
///
/// # Panics
/// When the folder is there but lacks `name`: that is a broken set-up, not a reason to skip.
pub fn shared(name: &str) -> Option<PathBuf> {
    let folder = repository().join("../shared");
    if !folder.is_dir() {
        absent(Need::Shared, &format!("{} is absent, so {name} cannot be read", folder.display()));
        return None;
    }
    let path = folder.join(name);
    assert!(path.exists(), "{} exists but holds no {name}", folder.display());
    Some(path)
}
