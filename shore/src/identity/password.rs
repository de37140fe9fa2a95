//! Passwords: argon2id with the parameters that OWASP recommends (19 MiB, two passes), which are the crate's own.

use api::{Said, say};
use argon2::password_hash::phc::PasswordHash;
use argon2::{Algorithm, Argon2, Block, Params, PasswordHasher as _, Version};
use std::sync::LazyLock;
use subtle::ConstantTimeEq as _;

/// Longest password in bytes; longer ones are refused before any work is done.
pub const MAX_BYTES: usize = 1024;

/// Compared with when there is no such person, so that response times do not reveal which names exist.
static NOBODY: LazyLock<String> = LazyLock::new(|| hash(&super::secret::one_time_password()));

/// The password's hash. Takes tens of milliseconds on purpose.
///
/// # Panics
/// Never: the parameters are argon2's own.
pub fn hash(password: &str) -> String {
    let hashed = Argon2::default().hash_password(password.as_bytes());
    hashed.expect("invariant: the parameters are argon2's own and the length is checked").to_string()
}

/// The memory for comparing passwords, kept between uses: allocating and freeing 19 MiB for each of many logins would
/// fragment the heap by several times that.
#[derive(Debug, Default)]
pub struct Memory(Vec<Block>);

/// Whether `password` matches the hash `kept`; as slow for `None`, which never matches.
pub fn is_right(memory: &mut Memory, password: &str, kept: Option<&str>) -> bool {
    if password.len() > MAX_BYTES {
        return false;
    }
    let Ok(parsed) = PasswordHash::new(kept.unwrap_or(&NOBODY)) else { return false };
    let (Some(salt), Some(hash)) = (&parsed.salt, &parsed.hash) else { return false };
    let algorithm = Algorithm::try_from(parsed.algorithm.as_str());
    let version = parsed.version.map_or(Ok(Version::default()), Version::try_from);
    let (Ok(algorithm), Ok(version), Ok(params)) = (algorithm, version, Params::try_from(&parsed)) else {
        return false;
    };
    let blocks = params.block_count();
    if memory.0.len() < blocks {
        memory.0.resize(blocks, Block::default());
    }
    let mut computed = vec![0; hash.as_bytes().len()];
    let done = Argon2::new(algorithm, version, params).hash_password_into_with_memory(
        password.as_bytes(),
        salt,
        &mut computed,
        &mut memory.0[..blocks],
    );
    let same: bool = computed.ct_eq(hash.as_bytes()).into();
    done.is_ok() && same && kept.is_some()
}

/// Why `password` will not do for `name`, in words for the person.
///
/// # Errors
/// Too short, too long, or guessed at once.
pub fn check_new(name: &str, password: &str, least: usize) -> Result<(), Said> {
    if password.chars().count() < least {
        return Err(say("The password needs at least {least} characters.").with("least", least).into());
    }
    if password.len() > MAX_BYTES {
        return Err(say("The password may have at most {most} bytes.").with("most", MAX_BYTES).into());
    }
    let lower = password.to_lowercase();
    let mut distinct: Vec<char> = lower.chars().collect();
    distinct.sort_unstable();
    distinct.dedup();
    if distinct.len() < 5 || lower.contains(&name.to_lowercase()) || lower.contains("password") {
        return Err(say("This password would be guessed at once: use several words, not your name.").into());
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_right_password_is_right() {
        let mut memory = Memory::default();
        let kept = hash("nine otters swim");
        assert!(kept.starts_with("$argon2id$"));
        assert!(is_right(&mut memory, "nine otters swim", Some(&kept)));
        assert!(!is_right(&mut memory, "nine otters swam", Some(&kept)));
        assert!(!is_right(&mut memory, "nine otters swim", None));
        assert!(!is_right(&mut memory, "nine otters swim", Some("rubbish")));
        assert!(!is_right(&mut memory, &"x".repeat(2000), Some(&kept)));
    }

    #[test]
    fn weak_passwords_are_refused_with_the_remedy() {
        assert!(check_new("nils", "short", 10).unwrap_err().contains("at least 10"));
        assert!(check_new("nils", "aaaaaaaaaaaaa", 10).is_err());
        assert!(check_new("nils", "I am Nils Olav", 10).is_err());
        assert!(check_new("nils", &"abcdefgh".repeat(200), 10).unwrap_err().contains("at most"));
        assert!(check_new("nils", "Trondheimsfjorden 63", 10).is_ok());
    }
}
