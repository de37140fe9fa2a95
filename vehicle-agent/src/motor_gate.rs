//! The motor gate: the last stage between the control loop and the motors, with its own watchdog.
//!
//! A command is valid for [`COMMAND_LIFE`]. When the loop does not refresh it in time, for any reason, a dedicated thread
//! stops the motors. After [`MotorGate::end`] only a stop reaches them: it is called first when the program ends, by a
//! signal, an error or a panic.

use control::MotorPair;
use onboard::COMMAND_LIFE;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

/// Sends a command to the motors; it must not wait.
type Device = Box<dyn FnMut(MotorPair) + Send>;

/// The command in force, and since when.
struct Held {
    device: Device,
    motors: MotorPair,
    given: Instant,
    lapses: u64,
    closed: bool,
}

/// The gate that all commands pass.
pub(crate) struct MotorGate {
    held: Mutex<Held>,
    changed: Condvar,
    ended: AtomicBool,
}

impl std::fmt::Debug for MotorGate {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("MotorGate").field("ended", &self.ended).finish_non_exhaustive()
    }
}

impl Held {
    /// Stops the motors if their command is too old at `now`; returns whether it was.
    fn lapse(&mut self, now: Instant) -> bool {
        let lapsed =
            self.motors != MotorPair::STOPPED && now.saturating_duration_since(self.given) >= COMMAND_LIFE;
        if lapsed {
            self.lapses += 1;
            self.put(now, MotorPair::STOPPED);
        }
        lapsed
    }

    fn put(&mut self, now: Instant, motors: MotorPair) {
        (self.motors, self.given) = (motors, now);
        (self.device)(motors);
    }
}

impl MotorGate {
    /// A gate before a device whose motors are stopped, and its watchdog.
    pub(crate) fn start(device: impl FnMut(MotorPair) + Send + 'static) -> anyhow::Result<Arc<Self>> {
        let held = Held {
            device: Box::new(device),
            motors: MotorPair::STOPPED,
            given: Instant::now(),
            lapses: 0,
            closed: false,
        };
        let gate =
            Arc::new(Self { held: Mutex::new(held), changed: Condvar::new(), ended: AtomicBool::new(false) });
        let watched = Arc::clone(&gate);
        std::thread::Builder::new().name("motor-watchdog".to_owned()).spawn(move || watched.watch())?;
        Ok(gate)
    }

    /// Passes a command on and refreshes it; after the end, a stop.
    pub(crate) fn command(&self, motors: MotorPair) {
        let mut held = self.lock();
        let motors = if self.ended.load(Ordering::SeqCst) { MotorPair::STOPPED } else { motors };
        held.put(Instant::now(), motors);
        drop(held);
        self.changed.notify_all();
    }

    /// Stops the motors for good.
    ///
    /// It may be called from a panic inside the device: then the watchdog, which is woken, stops them.
    pub(crate) fn end(&self) {
        self.ended.store(true, Ordering::SeqCst);
        if let Ok(mut held) = self.held.try_lock() {
            held.put(Instant::now(), MotorPair::STOPPED);
        }
        self.changed.notify_all();
    }

    /// Whether only stops are passed on.
    #[cfg(test)]
    pub(crate) fn has_ended(&self) -> bool {
        self.ended.load(Ordering::SeqCst) && self.lock().motors == MotorPair::STOPPED
    }

    /// How often the loop was late.
    pub(crate) fn lapses(&self) -> u64 {
        self.lock().lapses
    }

    /// Ends the watchdog; the motors are stopped.
    pub(crate) fn close(&self) {
        self.end();
        self.lock().closed = true;
        self.changed.notify_all();
    }

    fn lock(&self) -> MutexGuard<'_, Held> {
        self.held.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn watch(&self) {
        let mut held = self.lock();
        while !held.closed {
            let now = Instant::now();
            held.lapse(now);
            if self.ended.load(Ordering::SeqCst) && held.motors != MotorPair::STOPPED {
                held.put(now, MotorPair::STOPPED);
            }
            // An `end` that found the lock held is noticed after this time at the latest.
            let left = COMMAND_LIFE.saturating_sub(now.saturating_duration_since(held.given));
            let wait = if left.is_zero() { COMMAND_LIFE } else { left };
            held = self.changed.wait_timeout(held, wait).unwrap_or_else(PoisonError::into_inner).0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::mpsc::{Receiver, channel};
    use std::time::Duration;

    const AHEAD: MotorPair = MotorPair { port: 0.5, starboard: 0.5 };
    const DEADLINE: Duration = Duration::from_secs(20);

    fn gate() -> (Arc<MotorGate>, Receiver<MotorPair>) {
        let (sent, got) = channel();
        (MotorGate::start(move |motors| sent.send(motors).unwrap()).unwrap(), got)
    }

    #[test]
    fn motors_stop_when_the_loop_hangs_and_run_again_when_it_is_back() {
        let (gate, got) = gate();
        gate.command(AHEAD);
        assert_eq!(got.recv().unwrap(), AHEAD);
        // The loop does nothing more: the watchdog stops the motors.
        assert_eq!(got.recv_timeout(DEADLINE).unwrap(), MotorPair::STOPPED);
        assert_eq!(gate.lapses(), 1);
        gate.command(AHEAD);
        assert_eq!(got.recv().unwrap(), AHEAD);
        gate.close();
        assert_eq!(got.recv().unwrap(), MotorPair::STOPPED);
    }

    #[test]
    fn a_command_lasts_half_a_second_and_a_stop_for_ever() {
        let given = Instant::now();
        let mut held = Held { device: Box::new(|_| {}), motors: AHEAD, given, lapses: 0, closed: false };
        assert!(!held.lapse(given + Duration::from_millis(499)));
        assert!(held.lapse(given + Duration::from_millis(500)));
        assert_eq!(held.motors, MotorPair::STOPPED);
        assert!(!held.lapse(given + Duration::from_mins(1)));
    }

    #[test]
    fn after_the_end_nothing_moves() {
        let (gate, got) = gate();
        gate.command(AHEAD);
        gate.end();
        gate.command(AHEAD);
        let seen: Vec<_> = (0..3).map(|_| got.recv().unwrap()).collect();
        assert_eq!(seen, [AHEAD, MotorPair::STOPPED, MotorPair::STOPPED]);
    }

    #[test]
    fn a_panic_in_the_device_itself_still_ends_in_a_stop() {
        let (sent, got) = channel();
        let gate = MotorGate::start(move |motors| {
            assert!(motors == MotorPair::STOPPED, "the device breaks");
            sent.send(motors).unwrap();
        })
        .unwrap();
        let broken = Arc::clone(&gate);
        assert!(std::thread::spawn(move || broken.command(AHEAD)).join().is_err());
        gate.end();
        assert_eq!(got.recv_timeout(DEADLINE).unwrap(), MotorPair::STOPPED);
    }
}
