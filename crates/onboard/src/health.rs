//! The computer: its processor, memory, disk and temperature.

use crate::bus::Bus;
use crate::entity::Entity;
use crate::input::HostReading;
use crate::settings::WatchSettings;
use crate::states::{Condition, States};
use imc::messages::{CpuUsage, StorageUsage, Temperature};
use std::time::Duration;
use units::MonoTime;

/// Readings of the processor's load that are averaged.
const CPU_SAMPLES: usize = 10;
/// The computer's state is unknown after this silence.
const HOST_SILENCE: Duration = Duration::from_secs(30);
/// With this much room a disk is not short of it, however large it is (MiB): a vessel records about 56 MB an hour, so this lasts
/// for a week.
const PLENTY_MIB: f64 = 10_240.0;

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
        if let Some(percent) = reading.computer_cpu_percent.filter(|value| value.is_finite()) {
            bus.send(Entity::Host, &CpuUsage { value: percent.clamp(0.0, 100.0) as u8 });
        }
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
            faults.push(format!("this program takes {mean:.0} % of a processor"));
        }
        let is_short =
            |percent: f64| reading.disk_free_percent < percent && reading.disk_free_mib < PLENTY_MIB;
        if is_short(settings.disk_free_percent) {
            faults
                .push(format!("disk: {:.0} MiB left; the log stops when it is full", reading.disk_free_mib));
        }
        if reading.memory_mib > settings.memory_mib {
            faults.push(format!("this program's memory at {:.0} MiB", reading.memory_mib));
        }
        if let Some(free) = reading.memory_free_percent.filter(|free| *free < settings.memory_free_percent) {
            faults.push(format!("memory of the computer: {free:.0} % free"));
        }
        if faults.is_empty() {
            states.set(bus, Entity::Host, Condition::Normal, words(&reading, mean));
        } else {
            let condition =
                if is_short(settings.disk_error_percent) { Condition::Error } else { Condition::Fault };
            states.set(bus, Entity::Host, condition, faults.join("; "));
        }
    }
}

/// The computer in words, this program with its mean load (%) first; what is not known is left out.
fn words(reading: &HostReading, mean: f64) -> String {
    let mut words =
        format!("program: processor {mean:.0} %, memory {:.0} MiB; computer:", reading.memory_mib);
    let parts = [
        reading.computer_cpu_percent.map(|percent| format!(" processors {percent:.0} %,")),
        reading.memory_free_percent.map(|free| format!(" memory {free:.0} % free,")),
        Some(format!(" disk {:.0} % free", reading.disk_free_percent)),
        reading.temperature_c.map(|celsius| format!(", {celsius:.0} °C")),
    ];
    words.extend(parts.into_iter().flatten());
    words
}
