//! Queues of readings from the devices' threads to the control loop.
//!
//! Each device has its own bounded queue: a babbling device displaces only its own oldest readings, which is counted. Of a
//! device's states only the last is kept.

use super::Device;
use devices::Reading;
use onboard::{Condition, DeviceState, Input};
use std::collections::{BTreeMap, VecDeque};
use std::sync::{Mutex, MutexGuard, PoisonError};
use units::{MonoTime, Now};

/// Most queued readings of one device: for the busiest, about a minute of a loop that hangs.
const MOST_READINGS: usize = 4096;

/// Most queued warnings of one device; beyond that the oldest are only in the log.
const MOST_WARNINGS: usize = 32;

/// Wakes the loop.
type Bell = Box<dyn Fn() + Send + Sync>;

/// All queues to the loop.
pub(super) struct DeviceQueues {
    waiting: Mutex<BTreeMap<Device, DeviceQueue>>,
    bell: Bell,
}

/// The queue of one device.
#[derive(Debug, Default)]
struct DeviceQueue {
    readings: VecDeque<(Now, Reading)>,
    states: VecDeque<DeviceState>,
    warnings: VecDeque<String>,
    dropped: u64,
}

impl std::fmt::Debug for DeviceQueues {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("DeviceQueues").field("waiting", &self.waiting).finish_non_exhaustive()
    }
}

impl DeviceQueues {
    /// An empty one; `bell` wakes the loop and must not wait.
    pub(super) fn new(bell: impl Fn() + Send + Sync + 'static) -> Self {
        Self { waiting: Mutex::default(), bell: Box::new(bell) }
    }

    /// A device has read something.
    pub(super) fn reading(&self, device: Device, at: Now, reading: Reading) {
        let mut waiting = self.lock();
        let tray = waiting.entry(device).or_default();
        if tray.readings.len() >= MOST_READINGS {
            tray.readings.pop_front();
            tray.dropped += 1;
        }
        tray.readings.push_back((at, reading));
        drop(waiting);
        (self.bell)();
    }

    /// The state of a device has changed.
    pub(super) fn state(&self, device: Device, condition: Condition, text: &str) {
        let of = |entity| DeviceState { entity, condition, text: text.to_owned() };
        let states = device.entities().iter().copied().map(of).collect();
        self.lock().entry(device).or_default().states = states;
        (self.bell)();
    }

    /// A warning of a device's driver.
    pub(super) fn warning(&self, device: Device, text: String) {
        let mut waiting = self.lock();
        let warnings = &mut waiting.entry(device).or_default().warnings;
        if warnings.len() >= MOST_WARNINGS {
            warnings.pop_front();
        }
        warnings.push_back(text);
        drop(waiting);
        (self.bell)();
    }

    /// The next state, else the next warning, else the oldest reading that was taken up to `until`.
    pub(super) fn take(&self, until: MonoTime) -> Option<Input> {
        let mut waiting = self.lock();
        if let Some(state) = waiting.values_mut().find_map(|tray| tray.states.pop_front()) {
            return Some(Input::Device(state));
        }
        let warned =
            |(device, tray): (&Device, &mut DeviceQueue)| Some((device.book(), tray.warnings.pop_front()?));
        if let Some((part, text)) = waiting.iter_mut().find_map(warned) {
            return Some(Input::Warning(part, text));
        }
        let first =
            |tray: &DeviceQueue| tray.readings.front().map(|(at, _)| at.mono).filter(|at| *at <= until);
        let (device, _) = waiting
            .iter()
            .filter_map(|(device, tray)| Some((*device, first(tray)?)))
            .min_by_key(|(_, at)| *at)?;
        let (at, reading) = waiting.get_mut(&device)?.readings.pop_front()?;
        Some(Input::Reading(at.mono, reading))
    }

    /// When the oldest reading was taken.
    pub(super) fn first(&self) -> Option<MonoTime> {
        self.lock().values().filter_map(|tray| tray.readings.front()).map(|(at, _)| at.mono).min()
    }

    /// Readings dropped since the last call, by device.
    pub(super) fn take_dropped(&self) -> Vec<(Device, u64)> {
        let mut waiting = self.lock();
        let dropped = waiting.iter_mut().map(|(device, tray)| (*device, std::mem::take(&mut tray.dropped)));
        dropped.filter(|(_, count)| *count > 0).collect()
    }

    fn lock(&self) -> MutexGuard<'_, BTreeMap<Device, DeviceQueue>> {
        self.waiting.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use devices::BatteryReading;
    use units::UtcTime;

    fn at(us: u64) -> Now {
        Now { mono: MonoTime::from_micros(us), utc: UtcTime::default() }
    }

    fn battery(number: u8) -> Reading {
        Reading::Battery(BatteryReading { number, ..BatteryReading::default() })
    }

    fn numbers(queues: &DeviceQueues, until: u64) -> Vec<u8> {
        let taken = std::iter::from_fn(|| queues.take(MonoTime::from_micros(until)));
        let number = |input| match input {
            Input::Reading(_, Reading::Battery(reading)) => reading.number,
            other => panic!("{other:?}"),
        };
        taken.map(number).collect()
    }

    #[test]
    fn readings_of_all_devices_come_in_the_order_of_their_times_and_not_before() {
        let queues = DeviceQueues::new(|| {});
        for (device, us, number) in [
            (Device::Motors, 30, 3),
            (Device::Compass, 10, 1),
            (Device::Compass, 40, 4),
            (Device::Hydrophone, 20, 2),
        ] {
            queues.reading(device, at(us), battery(number));
        }
        assert_eq!(numbers(&queues, 30), [1, 2, 3]);
        assert_eq!(queues.first(), Some(MonoTime::from_micros(40)));
        assert_eq!((numbers(&queues, 40), queues.first()), (vec![4], None));
    }

    #[test]
    fn a_reading_keeps_the_moment_at_which_it_was_taken() {
        let queues = DeviceQueues::new(|| {});
        queues.reading(Device::Compass, at(10), battery(1));
        // The loop comes much later.
        let taken = queues.take(MonoTime::from_micros(5_000_000));
        assert_eq!(taken, Some(Input::Reading(MonoTime::from_micros(10), battery(1))));
    }

    #[test]
    fn of_a_device_s_states_the_last_counts_and_goes_to_each_of_its_parts() {
        let queues = DeviceQueues::new(|| {});
        queues.state(Device::Motors, Condition::Boot, "");
        queues.state(Device::Motors, Condition::Error, "silent");
        for entity in [onboard::Entity::MotorPort, onboard::Entity::MotorStarboard] {
            let state = DeviceState { entity, condition: Condition::Error, text: "silent".to_owned() };
            assert_eq!(queues.take(MonoTime::default()), Some(Input::Device(state)));
        }
        assert_eq!(queues.take(MonoTime::default()), None);
    }

    #[test]
    fn warnings_come_before_readings_and_the_newest_of_too_many() {
        let queues = DeviceQueues::new(|| {});
        queues.reading(Device::Hydrophone, at(0), battery(1));
        for number in 0..=MOST_WARNINGS {
            queues.warning(Device::Motors, number.to_string());
        }
        let taken: Vec<Input> = std::iter::from_fn(|| queues.take(MonoTime::default())).collect();
        assert_eq!(taken.len(), MOST_WARNINGS + 1);
        assert_eq!(taken[0], Input::Warning(onboard::Entity::Daemon, "1".to_owned()));
        assert!(matches!(taken[MOST_WARNINGS], Input::Reading(..)));
    }

    #[test]
    fn a_babbling_device_loses_its_own_oldest_readings_and_they_are_counted() {
        let queues = DeviceQueues::new(|| {});
        queues.reading(Device::Compass, at(0), battery(9));
        for us in 0..=MOST_READINGS as u64 {
            queues.reading(Device::Motors, at(us + 1), battery(u8::from(us == 0)));
        }
        assert_eq!(queues.take_dropped(), [(Device::Motors, 1)]);
        assert_eq!(queues.take_dropped(), []);
        let all = numbers(&queues, u64::MAX);
        assert_eq!((all.len(), all[0], all[1]), (1 + MOST_READINGS, 9, 0));
    }
}
