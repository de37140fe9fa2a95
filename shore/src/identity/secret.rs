//! Random secrets, their text form and their hash.

use sha2::{Digest as _, Sha256};
use subtle::ConstantTimeEq as _;

/// Letters and digits that are not mistaken for one another when read aloud.
const READABLE: &[u8; 32] = b"abcdefghijkmnpqrstuvwxyz23456789";

/// 256 random bits, as given to a browser or a script. Not shown in logs.
#[derive(Clone)]
pub struct Secret([u8; 32]);

impl Secret {
    /// A new secret from the system's random generator.
    ///
    /// # Panics
    /// The kernel gives no random bytes.
    pub fn random() -> Self {
        let mut bytes = [0; 32];
        getrandom::fill(&mut bytes).expect("invariant: the kernel has randomness");
        Self(bytes)
    }

    /// Reads what [`Secret::text`] wrote; `None` for anything else.
    pub fn parse(text: &str) -> Option<Self> {
        let digits = text.as_bytes();
        if digits.len() != 64 {
            return None;
        }
        let mut bytes = [0; 32];
        for (byte, pair) in bytes.iter_mut().zip(digits.chunks_exact(2)) {
            *byte = nibble(pair[0])? << 4 | nibble(pair[1])?;
        }
        Some(Self(bytes))
    }

    /// 64 hexadecimal digits.
    pub fn text(&self) -> String {
        hex::encode(self.0)
    }

    /// The hash that is stored.
    pub fn hash(&self) -> [u8; 32] {
        Sha256::digest(self.0).into()
    }

    /// Another secret that is derived from this one and does not reveal it.
    pub fn derived(&self, purpose: &str) -> String {
        hex::encode(Sha256::new().chain_update(purpose).chain_update(self.0).finalize())
    }
}

impl std::fmt::Debug for Secret {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Secret(…)")
    }
}

/// Whether two texts are the same, in a time that depends on their lengths only.
pub fn same(one: &str, other: &str) -> bool {
    one.as_bytes().ct_eq(other.as_bytes()).into()
}

/// A password to be read from a screen and typed once: 80 random bits in groups of four.
pub fn one_time_password() -> String {
    let random = Secret::random();
    let letters = random.0[..16].iter().map(|byte| char::from(READABLE[usize::from(byte % 32)]));
    let letters: Vec<char> = letters.collect();
    letters.chunks(4).map(String::from_iter).collect::<Vec<_>>().join("-")
}

fn nibble(digit: u8) -> Option<u8> {
    match digit {
        b'0'..=b'9' => Some(digit - b'0'),
        b'a'..=b'f' => Some(digit - b'a' + 10),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_secret_survives_writing_and_reading() {
        let secret = Secret::random();
        let read = Secret::parse(&secret.text()).unwrap();
        assert_eq!(read.hash(), secret.hash());
        assert!(Secret::parse("zz").is_none());
        assert!(Secret::parse(&"G".repeat(64)).is_none());
        assert_eq!(format!("{secret:?}"), "Secret(…)");
    }

    #[test]
    fn secrets_differ_and_so_do_their_purposes() {
        let secret = Secret::random();
        assert_ne!(secret.text(), Secret::random().text());
        assert_ne!(secret.derived("csrf"), secret.derived("other"));
        assert!(same(&secret.derived("csrf"), &secret.derived("csrf")));
    }

    #[test]
    fn one_time_passwords_are_readable() {
        let password = one_time_password();
        assert_eq!(password.len(), 19);
        assert_ne!(password, one_time_password());
    }
}
