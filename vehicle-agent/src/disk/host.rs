//! The computer's own state, from /proc and the file system.

use onboard::HostReading;
use std::fs;
use std::path::Path;
use std::time::Instant;

/// Ticks of /proc's times a second; fixed on Linux.
const TICKS_PER_S: f64 = 100.0;

/// Reads the state from time to time.
#[derive(Debug)]
pub(crate) struct Host {
    last: Option<(Instant, f64)>,
}

impl Host {
    pub(crate) fn new() -> Self {
        Self { last: None }
    }

    /// The state now; the load is that of this program since the last call.
    pub(crate) fn read(&mut self, logs: &Path) -> HostReading {
        let (now, used_s) = (Instant::now(), cpu_seconds().unwrap_or(0.0));
        let before = self.last.replace((now, used_s));
        let cpu_percent = before.map_or(0.0, |(then, before_s)| {
            100.0 * (used_s - before_s) / now.duration_since(then).as_secs_f64().max(1e-3)
        });
        let (free_mib, free_percent) = disk(logs).unwrap_or((0.0, 100.0));
        HostReading {
            cpu_percent,
            disk_free_mib: free_mib,
            disk_free_percent: free_percent,
            memory_mib: memory_mib().unwrap_or(0.0),
            temperature_c: temperature_c(),
        }
    }
}

fn cpu_seconds() -> Option<f64> {
    let stat = fs::read_to_string("/proc/self/stat").ok()?;
    // The name in parentheses may hold blanks; user and system time are the 12th and 13th after it.
    let mut fields = stat.rsplit_once(')')?.1.split_whitespace().skip(11);
    let (user, system): (f64, f64) = (fields.next()?.parse().ok()?, fields.next()?.parse().ok()?);
    Some((user + system) / TICKS_PER_S)
}

fn memory_mib() -> Option<f64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    line.split_whitespace().next()?.parse::<f64>().ok().map(|kib| kib / 1024.0)
}

fn disk(path: &Path) -> Option<(f64, f64)> {
    let state = rustix::fs::statvfs(path).ok()?;
    let (free, all) = (state.f_bavail as f64, state.f_blocks as f64);
    Some((free * state.f_frsize as f64 / 1_048_576.0, 100.0 * free / all.max(1.0)))
}

fn temperature_c() -> Option<f64> {
    let text = fs::read_to_string("/sys/class/thermal/thermal_zone0/temp").ok()?;
    text.trim().parse::<f64>().ok().map(|milli| milli / 1000.0)
}
