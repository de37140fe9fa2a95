//! WireGuard's keys: Curve25519, written in base64.

use base64ct::{Base64, Encoding as _};
use x25519_dalek::{PublicKey, StaticSecret};

/// A private key. Does not show itself.
#[derive(Clone)]
pub struct VpnKey(StaticSecret);

impl VpnKey {
    /// The key made of 32 random bytes.
    pub fn from_random(mut bytes: [u8; 32]) -> Self {
        // As WireGuard writes keys (clamped); it means the same.
        bytes[0] &= 0xF8;
        bytes[31] = bytes[31] & 0x7F | 0x40;
        Self(StaticSecret::from(bytes))
    }

    /// Reads what [`Self::private`] wrote; `None` for anything else.
    pub fn parse(text: &str) -> Option<Self> {
        let mut bytes = [0; 32];
        (Base64::decode(text.trim(), &mut bytes).ok()?.len() == 32).then_some(())?;
        Some(Self(StaticSecret::from(bytes)))
    }

    /// As WireGuard reads it. A secret.
    pub fn private(&self) -> String {
        Base64::encode_string(self.0.as_bytes())
    }

    /// The half that others know it by.
    pub fn public(&self) -> String {
        Base64::encode_string(PublicKey::from(&self.0).as_bytes())
    }
}

impl std::fmt::Debug for VpnKey {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("VpnKey(…)")
    }
}
