//! A fleet's file, the sealed bundle that brings a vessel's part of it aboard, and the files of its VPN.
//!
//! It is the common ground of `lutra-server fleet` and `lutra-agent provision`, and pure: texts, bytes, time and random numbers
//! come in, texts and bytes go out. Files, databases and the network belong to the two programs. It knows no IMC, no link and
//! none of the agent's parameters but the few that [`overlay`] writes.
//!
//! [`Fleet`] is the contents of a fleet file, read strictly, with every [`Problem`] at once. [`overlay`] makes a vessel's
//! agent settings from it. [`VpnKey`] and [`wireguard`], or [`openvpn`], with [`nftables`] are
//! the VPN. [`Bundle`] holds the files for a
//! vessel; [`Bundle::seal`] and [`Bundle::open`] encrypt and decrypt it. [`authority_validity`] says how long a
//! certificate lasts.
//!
//! Invariants: no secret appears in `Debug` or in an error. A bundle names the purpose of its files, never their paths, and
//! holds only plain bytes, so that no bundle can write elsewhere or grow while it is unpacked.

mod bundle;
mod certificate;
mod fleet;
mod overlay;
mod vpn;

pub use bundle::{
    Bundle, BundleError, FORMAT, Item, MAX_BUNDLE_BYTES, Manifest, Part, Port, Randomness, passphrase_in,
    passphrase_is_good, sealed_bytes,
};
pub use certificate::{Validity, authority_validity};
pub use fleet::{
    Device, Door, Doors, Fleet, Limits, MAX_FILE_BYTES, MAX_VESSELS, Network, Problem, Profile, Protocol,
    Server, Setting, Vessel, Vpn, VpnKind, Way,
};
pub use overlay::{BASE_FILE, overlay};
pub use vpn::{INTERFACE, Peer, VpnKey, nftables, openvpn, wireguard};
