//! A fleet's file, the sealed bundle that brings a vessel's part of it aboard, and the files of its VPN.
//!
//! It is the common ground of `lutra-server fleet` and `lutra-agent provision`, and pure: texts, bytes, time and random numbers
//! come in, texts and bytes go out. Files, databases and the network belong to the two programs. It knows no IMC, no link and
//! none of the agent's parameters but the few that [`overlay`] writes.
//!
//! [`Fleet`] is what a fleet file says, read strictly: every [`Problem`] at once. [`overlay`] is what a vessel's agent is told of
//! it. [`VpnKey`], [`wireguard`] and [`nftables`] are the VPN. [`Bundle`] is what is carried aboard, [`Bundle::seal`] and
//! [`Bundle::open`] the way in and out of its sealed form. [`authority_validity`] says how long a certificate lasts.
//!
//! Invariants: nothing secret shows itself in `Debug` or in an error. A bundle names what its files are for, never where they go,
//! and holds nothing but plain bytes, so that no bundle can write elsewhere or grow while it is unpacked.

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
    Server, Setting, Vessel, Vpn, Way,
};
pub use overlay::{BASE_FILE, overlay};
pub use vpn::{INTERFACE, Peer, VpnKey, nftables, wireguard};
