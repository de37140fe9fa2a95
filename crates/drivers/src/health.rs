//! The state of the computer: what the texts of Linux under /proc and /sys say, and the figures of its file systems.
//!
//! The caller reads the files, about once a second, and passes their text to [`Health::read`]; what cannot be read is
//! absent with the reason, and the rest counts all the same. Formats: proc(5), sysfs-class-thermal of the Linux
//! documentation, statvfs(3).

use thiserror::Error;

const MIB: f64 = 1_048_576.0;
const KIB_IN_MIB: f64 = 1024.0;
/// Fields of the processor's line that make up its time: user, nice, system, idle, iowait, irq, softirq, steal. Guests'
/// time, which follows, is counted in the user's already.
const CPU_FIELDS: usize = 8;
/// Without the fourth field, idle, the load is unknown.
const FEWEST_CPU_FIELDS: usize = 4;
/// Plausible temperatures of a processor (°C).
const BELIEVED_C: std::ops::RangeInclusive<f64> = -60.0..=200.0;

/// Why a value is not known.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum HealthError {
    /// The processor's line is not there.
    #[error("/proc/stat has no line `cpu` with the times of the processor")]
    Cpu,
    /// A line of the memory is not there.
    #[error("/proc/meminfo lacks MemTotal or MemAvailable in kB")]
    Memory,
    /// No number, or none that a processor has.
    #[error("the thermal zone gives no temperature in thousandths of a degree between -60 and 200 °C")]
    Temperature,
    /// A file system without blocks.
    #[error("the file system reports no blocks, or more free ones than it has")]
    Disk,
}

/// Times of all processors together since the start (in ticks of the system).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct CpuTimes {
    idle: u64,
    total: u64,
}

impl CpuTimes {
    /// Reads /proc/stat.
    ///
    /// # Errors
    /// When the line of all processors is not there.
    pub fn parse(stat: &str) -> Result<Self, HealthError> {
        let mut fields = stat.lines().next().unwrap_or_default().split_ascii_whitespace();
        if fields.next() != Some("cpu") {
            return Err(HealthError::Cpu);
        }
        let times: Result<Vec<u64>, _> = fields.take(CPU_FIELDS).map(str::parse).collect();
        let times = times.ok().filter(|times| times.len() >= FEWEST_CPU_FIELDS).ok_or(HealthError::Cpu)?;
        // Waiting for a disk is idle time of the processor.
        let idle = times[3].saturating_add(times.get(4).copied().unwrap_or(0));
        let total = times.iter().fold(0, |sum: u64, time| sum.saturating_add(*time));
        Ok(Self { idle, total })
    }

    /// The load since `before` (%, 100 with all processors busy); `None` where no time has passed.
    pub fn load_percent(self, before: Self) -> Option<f64> {
        let total = self.total.checked_sub(before.total).filter(|total| *total > 0)?;
        // The kernel's count of waiting may go back a little.
        let idle = self.idle.saturating_sub(before.idle).min(total);
        Some(100.0 * (total - idle) as f64 / total as f64)
    }
}

/// Memory of the computer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Memory {
    /// All (MiB).
    pub total_mib: f64,
    /// Memory available to programs (MiB), reclaimable caches included.
    pub available_mib: f64,
}

impl Memory {
    /// Reads /proc/meminfo.
    ///
    /// # Errors
    /// When either value is not there.
    pub fn parse(meminfo: &str) -> Result<Self, HealthError> {
        let line = |name: &str| kib_of(meminfo, name).map(|kib| kib / KIB_IN_MIB);
        let known = line("MemTotal:").zip(line("MemAvailable:"));
        let (total_mib, available_mib) =
            known.filter(|(total, _)| *total > 0.0).ok_or(HealthError::Memory)?;
        Ok(Self { total_mib, available_mib: available_mib.min(total_mib) })
    }

    /// The share that programs can still have (%).
    pub fn free_percent(&self) -> f64 {
        100.0 * self.available_mib / self.total_mib
    }
}

/// Room of a file system.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Disk {
    /// Space available to programs without privileges (MiB).
    pub free_mib: f64,
    /// The same as a share of the whole (%).
    pub free_percent: f64,
}

impl Disk {
    /// From the figures of statvfs: bytes of a block (`f_frsize`), all blocks, and those that are available.
    ///
    /// # Errors
    /// When the file system has no blocks, or claims to have more available than it has.
    pub fn of_blocks(block_bytes: u64, blocks: u64, available: u64) -> Result<Self, HealthError> {
        if blocks == 0 || available > blocks {
            return Err(HealthError::Disk);
        }
        Ok(Self {
            free_mib: available as f64 * block_bytes as f64 / MIB,
            free_percent: 100.0 * available as f64 / blocks as f64,
        })
    }
}

/// The temperature (°C) in the text of a thermal zone's `temp`.
///
/// # Errors
/// When the text is not a number, or not one that a processor can have.
pub fn temperature_c(temp: &str) -> Result<f64, HealthError> {
    let milli: i32 = temp.trim().parse().map_err(|_| HealthError::Temperature)?;
    Some(f64::from(milli) / 1e3)
        .filter(|celsius| BELIEVED_C.contains(celsius))
        .ok_or(HealthError::Temperature)
}

/// The time that a program has used the processor (in ticks of the system), in the text of its /proc/self/stat.
pub fn program_ticks(stat: &str) -> Option<u64> {
    // The name in parentheses may hold blanks and parentheses; user and system time are the 12th and 13th after it.
    let mut fields = stat.rsplit_once(')')?.1.split_ascii_whitespace().skip(11);
    let (user, system): (u64, u64) = (fields.next()?.parse().ok()?, fields.next()?.parse().ok()?);
    user.checked_add(system)
}

/// The memory that a program has (MiB), in the text of its /proc/self/status.
pub fn program_memory_mib(status: &str) -> Option<f64> {
    kib_of(status, "VmRSS:").map(|kib| kib / KIB_IN_MIB)
}

/// The number of kB in the line that begins with `name`.
fn kib_of(text: &str, name: &str) -> Option<f64> {
    let line = text.lines().find_map(|line| line.strip_prefix(name))?;
    let (number, unit) = line.trim().split_once(' ')?;
    // 64 bits of KiB are more memory than there is; the loss of the last bits is of no account.
    (unit.trim() == "kB").then(|| number.parse::<u64>().ok().map(|kib| kib as f64))?
}

/// The files' contents as text; `None` where a file is missing.
#[derive(Debug, Clone, Copy, Default)]
pub struct Sources<'a> {
    /// /proc/stat.
    pub stat: Option<&'a str>,
    /// /proc/meminfo.
    pub meminfo: Option<&'a str>,
    /// /sys/class/thermal/thermal_zone0/temp.
    pub temp: Option<&'a str>,
    /// Bytes of a block, blocks, and available blocks of the file system of the logs.
    pub blocks: Option<(u64, u64, u64)>,
}

/// The state of the computer; what is not known is `None`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct HealthReading {
    /// Load of all processors since the last reading (%).
    pub cpu_percent: Option<f64>,
    /// Its memory.
    pub memory: Option<Memory>,
    /// Room for the logs.
    pub disk: Option<Disk>,
    /// Temperature of the processor (°C).
    pub temperature_c: Option<f64>,
    /// Why values are not known that have a source.
    pub problems: Vec<HealthError>,
}

/// Reads the state of the computer again and again; it keeps the last times of the processors.
#[derive(Debug, Clone, Default)]
pub struct Health {
    before: Option<CpuTimes>,
}

impl Health {
    /// The state by these sources. The load is that since the last call, and not known at the first.
    pub fn read(&mut self, sources: &Sources<'_>) -> HealthReading {
        let mut problems = Vec::new();
        let times = known(sources.stat.map(CpuTimes::parse), &mut problems);
        let before = std::mem::replace(&mut self.before, times);
        let blocks = sources.blocks.map(|(bytes, blocks, free)| Disk::of_blocks(bytes, blocks, free));
        HealthReading {
            cpu_percent: times.zip(before).and_then(|(times, before)| times.load_percent(before)),
            memory: known(sources.meminfo.map(Memory::parse), &mut problems),
            disk: known(blocks, &mut problems),
            temperature_c: known(sources.temp.map(temperature_c), &mut problems),
            problems,
        }
    }
}

/// The value, or its error among the problems.
fn known<T>(outcome: Option<Result<T, HealthError>>, problems: &mut Vec<HealthError>) -> Option<T> {
    outcome?.map_err(|error| problems.push(error)).ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn near(value: f64, expected: f64) -> bool {
        (value - expected).abs() < 1e-6
    }

    #[test]
    fn the_load_is_that_between_two_readings() {
        let mut health = Health::default();
        let mut load =
            |stat: &str| health.read(&Sources { stat: Some(stat), ..Sources::default() }).cpu_percent;
        assert_eq!(load("cpu  100 0 50 800 50 0 0 0 30 0\ncpu0 1 2 3 4\n"), None, "the first");
        // 1000 ticks, of them 600 idle and 150 waiting; the guests' 70 are in the user's 200.
        let percent = load("cpu  300 0 100 1400 200 0 0 0 100 0\n").unwrap();
        assert!(near(percent, 25.0), "{percent}");
        assert_eq!(load("cpu  300 0 100 1400 200 0 0 0 100 0\n"), None, "no time has passed");
        assert!(near(load("cpu 310 0 100 1400 190 0 0 20\n").unwrap(), 100.0), "waiting went back");
    }

    #[test]
    fn memory_disk_and_temperature_are_read() {
        let meminfo =
            "MemTotal:        3884360 kB\nMemFree:          200000 kB\nMemAvailable:    2913270 kB\n";
        let memory = Memory::parse(meminfo).unwrap();
        assert!(near(memory.total_mib, 3_793.320_312_5) && near(memory.free_percent(), 75.0), "{memory:?}");
        let disk = Disk::of_blocks(4096, 1_000_000, 250_000).unwrap();
        assert!(near(disk.free_mib, 976.5625) && near(disk.free_percent, 25.0), "{disk:?}");
        assert!(near(temperature_c("48312\n").unwrap(), 48.312));
        assert!(near(temperature_c("-1500").unwrap(), -1.5));
        assert_eq!(program_ticks("77 (a b) c) S 1 77 77 0 -1 4194560 1 2 3 4 120 35 0 0 20 0"), Some(155));
        assert!(near(program_memory_mib("Name:\tx\nVmRSS:\t   20480 kB\n").unwrap(), 20.0));
    }

    #[test]
    fn what_cannot_be_read_is_absent_with_the_reason_and_the_rest_counts() {
        let sources = Sources {
            stat: Some("intr 1 2 3"),
            meminfo: Some("MemTotal: 100 kB\n"),
            temp: Some("N/A"),
            blocks: Some((4096, 100, 50)),
        };
        let reading = Health::default().read(&sources);
        assert_eq!(reading.problems, [HealthError::Cpu, HealthError::Memory, HealthError::Temperature]);
        assert!(reading.disk.is_some() && reading.cpu_percent.is_none());
        assert_eq!(
            Health::default().read(&Sources::default()),
            HealthReading::default(),
            "no source, no problem"
        );
        assert_eq!(temperature_c("900000"), Err(HealthError::Temperature));
        assert_eq!(CpuTimes::parse("cpu 1 2 3"), Err(HealthError::Cpu));
        assert_eq!(CpuTimes::parse("cpu 1 2 x 4"), Err(HealthError::Cpu));
        assert_eq!(Memory::parse("MemTotal: 9 MB\nMemAvailable: 3 kB\n"), Err(HealthError::Memory));
        assert_eq!(Disk::of_blocks(4096, 0, 0), Err(HealthError::Disk));
        assert_eq!(program_ticks("77 (a) S 1"), None);
    }

    #[test]
    fn this_computer_can_be_read() {
        let text = |path: &str| std::fs::read_to_string(path).ok();
        let (stat, meminfo) = (text("/proc/stat"), text("/proc/meminfo"));
        if stat.is_none() {
            println!("skipped: this computer has no /proc/stat");
            return;
        }
        let sources = Sources { stat: stat.as_deref(), meminfo: meminfo.as_deref(), ..Sources::default() };
        let reading = Health::default().read(&sources);
        assert_eq!(reading.problems, []);
        assert!((0.0..=100.0).contains(&reading.memory.unwrap().free_percent()));
    }

    proptest! {
        #[test]
        fn any_text_gives_a_share_or_nothing(
            texts in proptest::array::uniform2("(cpu|MemTotal:|MemAvailable:)?[ 0-9kB\n]{0,80}"),
            blocks in any::<(u64, u64, u64)>(),
        ) {
            let mut health = Health::default();
            for text in &texts {
                let sources =
                    Sources { stat: Some(text), meminfo: Some(text), temp: Some(text), blocks: Some(blocks) };
                let reading = health.read(&sources);
                let shares = [
                    reading.cpu_percent,
                    reading.memory.map(|memory| memory.free_percent()),
                    reading.disk.map(|disk| disk.free_percent),
                ];
                prop_assert!(shares.iter().flatten().all(|share| (0.0..=100.0).contains(share)), "{shares:?}");
            }
        }
    }
}
