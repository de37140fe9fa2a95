//! Limit of open files of this process: each connection is one, and the store needs some to record at all.

use crate::config::Config;
use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};

/// Archive, history and people, pages that are read from them, standard streams, and some to spare.
const OWN: usize = 1_024;

/// Files that this configuration may need open at once.
fn needed(config: &Config) -> u64 {
    let Config { http, transports, .. } = config;
    let sockets = http.max_connections
        + transports.imcproxy.max_peers
        + transports.udp.max_peers
        + transports.tcp.connect.len();
    (sockets + OWN) as u64
}

/// Raises the process's limit of open files to what it needs, as far as the system permits.
///
/// # Errors
/// The limit is too low; the error says what to do.
pub(super) fn raise(config: &Config) -> Result<String, String> {
    let needed = needed(config);
    let Rlimit { current, maximum } = getrlimit(Resource::Nofile);
    let may = |limit: Option<u64>| limit.is_none_or(|limit| limit >= needed);
    if !may(current) {
        let more = maximum.map_or(needed, |maximum| maximum.min(needed));
        setrlimit(Resource::Nofile, Rlimit { current: Some(more), maximum }).ok();
    }
    let current = getrlimit(Resource::Nofile).current;
    match current {
        Some(current) if current < needed => Err(format!(
            "only {current} files may be open and {needed} may be needed, or nothing can be recorded: raise the limit \
             (`ulimit -n`, LimitNOFILE of systemd) or lower http.max_connections"
        )),
        _ => Ok(format!("{needed} may be needed and may be open")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_connections_need_more_files() {
        let mut config = Config::default();
        let before = needed(&config);
        config.http.max_connections += 1_000;
        assert_eq!(needed(&config), before + 1_000);
    }

    #[test]
    fn a_limit_that_is_too_low_is_told_with_the_remedy() {
        let mut config = Config::default();
        config.http.max_connections = usize::MAX >> 16;
        if getrlimit(Resource::Nofile).maximum.is_some() {
            let text = raise(&config).unwrap_err();
            assert!(text.contains("LimitNOFILE") && text.contains("http.max_connections"), "{text}");
        }
    }
}
