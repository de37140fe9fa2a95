//! The computer's own state, from /proc and the file system.

use crate::say::complain;
use drivers::health::{self, Health, HealthError, HealthReading, Sources};
use onboard::HostReading;
use std::fs;
use std::path::Path;
use std::time::Instant;

/// Temperature of the processor, on a Raspberry Pi and on most computers.
const THERMAL_ZONE: &str = "/sys/class/thermal/thermal_zone0/temp";
/// Ticks of /proc's times a second; fixed on Linux.
const TICKS_PER_S: f64 = 100.0;

/// Reads the state from time to time.
#[derive(Debug)]
pub(crate) struct Host {
    computer: Health,
    last: Option<(Instant, f64)>,
    /// Problems that have been reported.
    told: Vec<HealthError>,
}

impl Host {
    pub(crate) fn new() -> Self {
        Self { computer: Health::default(), last: None, told: Vec::new() }
    }

    /// The state now; loads are those since the last call.
    pub(crate) fn read(&mut self, logs: &Path) -> HostReading {
        let (now, used_s) = (Instant::now(), cpu_seconds().unwrap_or(0.0));
        let before = self.last.replace((now, used_s));
        let cpu_percent = before.map_or(0.0, |(then, before_s)| {
            100.0 * (used_s - before_s) / now.duration_since(then).as_secs_f64().max(1e-3)
        });
        let HealthReading { cpu_percent: computer_cpu_percent, memory, disk, temperature_c, problems } =
            self.computer(logs);
        self.tell(problems);
        let health::Disk { free_mib, free_percent } =
            disk.unwrap_or(health::Disk { free_mib: 0.0, free_percent: 100.0 });
        HostReading {
            cpu_percent,
            computer_cpu_percent,
            memory_free_percent: memory.map(|memory| memory.free_percent()),
            disk_free_mib: free_mib,
            disk_free_percent: free_percent,
            memory_mib: memory_mib().unwrap_or(0.0),
            temperature_c,
        }
    }

    /// Reports each problem once.
    fn tell(&mut self, problems: Vec<HealthError>) {
        for problem in problems {
            if !self.told.contains(&problem) {
                complain!("the computer's state: {problem}");
                self.told.push(problem);
            }
        }
    }

    fn computer(&mut self, logs: &Path) -> HealthReading {
        let (stat, meminfo, temp) = (text("/proc/stat"), text("/proc/meminfo"), text(THERMAL_ZONE));
        let blocks = rustix::fs::statvfs(logs).ok();
        self.computer.read(&Sources {
            stat: stat.as_deref(),
            meminfo: meminfo.as_deref(),
            temp: temp.as_deref(),
            blocks: blocks.map(|state| (state.f_frsize, state.f_blocks, state.f_bavail)),
        })
    }
}

fn cpu_seconds() -> Option<f64> {
    health::program_ticks(&text("/proc/self/stat")?).map(|ticks| ticks as f64 / TICKS_PER_S)
}

fn memory_mib() -> Option<f64> {
    health::program_memory_mib(&text("/proc/self/status")?)
}

fn text(path: &str) -> Option<String> {
    fs::read_to_string(path).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn this_computer_is_read_beside_this_program() {
        let mut host = Host::new();
        let folder = std::env::temp_dir();
        let first = host.read(&folder);
        assert_eq!((first.cpu_percent, first.computer_cpu_percent), (0.0, None), "nothing to compare with");
        assert!(first.memory_free_percent.is_some_and(|free| (0.0..=100.0).contains(&free)), "{first:?}");
        assert!(first.memory_mib > 1.0 && first.disk_free_mib > 0.0, "{first:?}");
        if testkit::is_emulated() {
            let why =
                "the processor's time of a program, of which qemu-user tells nothing in /proc/self/stat";
            return testkit::absent(testkit::Need::Native, why);
        }
        // Work that the kernel counts: a tick is ten milliseconds.
        let (started, before) = (Instant::now(), cpu_seconds().unwrap());
        while cpu_seconds().unwrap() < before + 0.05 && started.elapsed().as_secs() < 60 {}
        let then = host.read(&folder);
        assert!(then.cpu_percent > 0.0, "{then:?}");
        assert!(then.computer_cpu_percent.is_some_and(|load| load > 0.0 && load <= 100.0), "{then:?}");
    }
}
