//! Users of the boat's system, which may not be the running system: read from its own passwd file.

use std::fs;
use std::path::Path;

/// The user that runs the agent.
pub(super) const AGENT: &str = "lutra-agent";

/// Numbers of a user and its group.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Account {
    pub(super) user: u32,
    pub(super) group: u32,
}

/// The superuser.
pub(super) const ROOT: Account = Account { user: 0, group: 0 };

/// The user of this name in the passwd file below `root`.
pub(super) fn named(root: &Path, name: &str) -> Option<Account> {
    let list = fs::read_to_string(root.join("etc/passwd")).ok()?;
    list.lines().find_map(|line| {
        let mut parts = line.split(':');
        (parts.next()? == name).then_some(())?;
        let (user, group) = (parts.nth(1)?.parse().ok()?, parts.next()?.parse().ok()?);
        Some(Account { user, group })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_account_is_found_in_the_boats_own_list() {
        let root = tempfile::tempdir().unwrap();
        assert_eq!(named(root.path(), AGENT), None);
        fs::create_dir(root.path().join("etc")).unwrap();
        let list = "root:x:0:0:root:/root:/bin/sh\nlutra-agent:x:998:997:Lutra:/var/lib/lutra-agent:/usr/sbin/nologin\n";
        fs::write(root.path().join("etc/passwd"), list).unwrap();
        assert_eq!(named(root.path(), AGENT), Some(Account { user: 998, group: 997 }));
        assert_eq!(named(root.path(), "lutra"), None);
    }
}
