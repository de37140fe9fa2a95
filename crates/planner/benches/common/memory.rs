//! What a bench takes.

/// Memory of this process now and at most, as Linux reports it.
pub(crate) fn memory() -> String {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mib = |name: &str| {
        let line = status.lines().find_map(|line| line.strip_prefix(name)).unwrap_or_default();
        line.trim().trim_end_matches(" kB").parse::<u64>().unwrap_or(0) >> 10
    };
    format!("{} MiB, at most {} MiB", mib("VmRSS:"), mib("VmHWM:"))
}
