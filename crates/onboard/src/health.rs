//! The computer and its clock.
//!
//! The brain's deadlines run on a steady time and do not care when the clock is set; what is recorded does,
//! so a step is told, and so is a clock that differs from the satellites'.

use crate::bus::Bus;
use crate::entity::Entity;
use crate::input::HostReading;
use crate::output::Level;
use crate::settings::WatchSettings;
use crate::states::{Condition, States};
use devices::GnssReading;
use imc::messages::{CpuUsage, StorageUsage, Temperature};
use std::time::Duration;
use units::{MonoTime, UtcTime};

/// A step of the clock that is worth telling (µs).
const STEP_US: i64 = 500_000;
/// Readings of the processor's load that are averaged.
const CPU_SAMPLES: usize = 10;
/// The computer's state is unknown after this silence.
const HOST_SILENCE: Duration = Duration::from_secs(30);

/// The clock.
#[derive(Debug, Clone, Default)]
pub(crate) struct Clock {
    last: Option<(MonoTime, UtcTime)>,
    /// The computer's clock minus that of the satellites (s), smoothed.
    offset_s: Option<f64>,
    steps: u64,
}

impl Clock {
    /// Compares both times; answers a step of the clock (µs).
    pub(crate) fn check(&mut self, bus: &mut Bus) -> Option<i64> {
        let (mono, utc) = (bus.mono(), bus.utc());
        let last = self.last.replace((mono, utc));
        let (mono_before, utc_before) = last?;
        // A gap of days fits 63 bits of microseconds.
        let step = (utc - utc_before) - mono.since(mono_before).as_micros() as i64;
        if step.abs() < STEP_US {
            return None;
        }
        self.steps += 1;
        self.offset_s = None;
        let text = format!("the clock was set by {:+.1} s; only records notice", step as f64 / 1e6);
        bus.entry(Entity::Clock, Level::Warning, text);
        Some(step)
    }

    /// Compares the clock with that of the satellites, whose epochs arrive a little after they were.
    pub(crate) fn compare(&mut self, bus: &Bus, reading: &GnssReading) {
        if let Some(epoch) = reading.utc.filter(|_| reading.fix.is_some()) {
            let offset_s = (bus.utc() - epoch) as f64 / 1e6;
            let before = self.offset_s.unwrap_or(offset_s);
            self.offset_s = Some(before + 0.2 * (offset_s - before));
        }
    }

    /// The time of the satellites (s), as far as they told it; else that of the computer.
    pub(crate) fn satellite_seconds(&self, bus: &Bus) -> f64 {
        bus.seconds() - self.offset_s.unwrap_or_default()
    }

    pub(crate) fn watch(&self, bus: &mut Bus, states: &mut States, settings: &WatchSettings) {
        match self.offset_s {
            None => states.set(bus, Entity::Clock, Condition::Normal, "not compared with satellites"),
            Some(offset_s) if offset_s.abs() > settings.clock_offset_s => {
                let text =
                    format!("{offset_s:+.1} s off the satellites; records carry wrong times until it is set");
                states.set(bus, Entity::Clock, Condition::Fault, text);
            }
            Some(offset_s) => {
                states.set(
                    bus,
                    Entity::Clock,
                    Condition::Normal,
                    format!("{offset_s:+.1} s to the satellites"),
                );
            }
        }
    }
}

/// The computer.
#[derive(Debug, Clone, Default)]
pub(crate) struct Host {
    cpu: Vec<f64>,
    last: Option<(MonoTime, HostReading)>,
}

impl Host {
    pub(crate) fn read(&mut self, bus: &mut Bus, reading: &HostReading) {
        let sane =
            [reading.cpu_percent, reading.disk_free_mib, reading.disk_free_percent, reading.memory_mib]
                .iter()
                .all(|value| value.is_finite());
        if !sane {
            return;
        }
        self.cpu.push(reading.cpu_percent);
        if self.cpu.len() > CPU_SAMPLES {
            self.cpu.remove(0);
        }
        self.last = Some((bus.mono(), *reading));
        bus.send(Entity::Daemon, &CpuUsage { value: reading.cpu_percent.clamp(0.0, 255.0) as u8 });
        let used = 100.0 - reading.disk_free_percent.clamp(0.0, 100.0);
        let available = reading.disk_free_mib.clamp(0.0, f64::from(u32::MAX)) as u32;
        bus.send(Entity::Daemon, &StorageUsage { available, value: used as u8 });
        if let Some(celsius) = reading.temperature_c.filter(|value| value.is_finite()) {
            bus.send(Entity::Host, &Temperature { value: celsius as f32 });
        }
    }

    pub(crate) fn watch(&self, bus: &mut Bus, states: &mut States, settings: &WatchSettings) {
        let Some((at, reading)) = self.last else {
            return states.set(bus, Entity::Host, Condition::Normal, "not reported");
        };
        let mean = self.cpu.iter().sum::<f64>() / self.cpu.len().max(1) as f64;
        let mut faults = Vec::new();
        if bus.mono().since(at) > HOST_SILENCE {
            faults.push("the computer's state is not reported".to_owned());
        }
        if self.cpu.len() == CPU_SAMPLES && mean >= settings.cpu_percent {
            faults.push(format!("processor at {mean:.0} %"));
        }
        if reading.disk_free_percent < settings.disk_free_percent {
            faults.push(format!("disk: {:.0} MiB left; without room the log stops", reading.disk_free_mib));
        }
        if reading.memory_mib > settings.memory_mib {
            faults.push(format!("memory at {:.0} MiB", reading.memory_mib));
        }
        let full = reading.disk_free_percent < settings.disk_error_percent;
        if faults.is_empty() {
            let text = format!("processor {mean:.0} %, memory {:.0} MiB", reading.memory_mib);
            states.set(bus, Entity::Host, Condition::Normal, text);
        } else {
            let condition = if full { Condition::Error } else { Condition::Fault };
            states.set(bus, Entity::Host, condition, faults.join("; "));
        }
    }
}
