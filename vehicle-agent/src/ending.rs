//! How the program ends: by a signal or a panic; in either case the motors are stopped first.

use crate::motor_gate::MotorGate;
use anyhow::Context as _;
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use std::io;
use std::panic::PanicHookInfo;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Prefix of the names of the threads between vessel and shore.
pub(crate) const UPLINK_THREADS: &str = "uplink";
/// The thread that plans routes.
pub(crate) const ROUTING_THREAD: &str = "routing";

/// The program ended by a panic.
#[derive(Debug)]
pub(crate) struct Fault;

impl std::fmt::Display for Fault {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(
            "a fault of the program itself: the motors were stopped; please report what it said above",
        )
    }
}

impl std::error::Error for Fault {}

/// Whether the program is to end.
#[derive(Debug, Clone, Default)]
pub(crate) struct Ending {
    asked: Arc<AtomicBool>,
    fault: Arc<AtomicBool>,
}

impl Ending {
    /// Ends at SIGTERM, SIGINT (Ctrl-C) and SIGHUP. The last is sent when a terminal is closed: its operator is gone, so
    /// the vessel stops. The configuration is read again only by a restart.
    pub(crate) fn at_signals() -> anyhow::Result<Self> {
        let ending = Self::default();
        for signal in [SIGTERM, SIGINT, SIGHUP] {
            signal_hook::flag::register(signal, Arc::clone(&ending.asked)).context("signals")?;
        }
        Ok(ending)
    }

    /// Ends also when standard input is closed, which happens in any case when the program at its other end ends.
    pub(crate) fn at_end_of_input(&self) -> anyhow::Result<()> {
        let asked = Arc::clone(&self.asked);
        let read = move || {
            // An input that cannot be read is treated as closed.
            io::copy(&mut io::stdin().lock(), &mut io::sink()).ok();
            asked.store(true, Ordering::Relaxed);
        };
        std::thread::Builder::new().name("input".to_owned()).spawn(read).context("cannot start a thread")?;
        Ok(())
    }

    /// Ends at a panic of any thread, first stopping the motors. Exceptions are the uplink's threads and the one that plans
    /// routes, which command no motor and continue.
    pub(crate) fn at_panics(&self, gate: &Arc<MotorGate>) {
        let (gate, ending) = (Arc::clone(gate), self.clone());
        std::panic::set_hook(Box::new(move |panic| {
            let thread = std::thread::current();
            let thread = thread.name().unwrap_or("?");
            if thread.starts_with(UPLINK_THREADS) || thread == ROUTING_THREAD {
                tracing::error!(thread, "the vessel goes on: {panic}");
                return;
            }
            gate.end();
            ending.panicked(thread, panic);
        }));
    }

    fn panicked(&self, thread: &str, panic: &PanicHookInfo<'_>) {
        self.fault.store(true, Ordering::SeqCst);
        // Not by the default hook, which may block on the reader of standard error.
        tracing::error!(thread, "motors stopped: {panic}");
    }

    /// Whether to end.
    pub(crate) fn is_near(&self) -> bool {
        self.asked.load(Ordering::Relaxed) || self.has_fault()
    }

    /// Whether a panic is the reason.
    pub(crate) fn has_fault(&self) -> bool {
        self.fault.load(Ordering::SeqCst)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use control::MotorPair;
    use std::sync::mpsc::channel;

    #[test]
    fn a_panic_anywhere_stops_the_motors_before_anything_else() {
        let (sent, got) = channel();
        let gate = MotorGate::start(move |motors| sent.send(motors).unwrap()).unwrap();
        let ending = Ending::default();
        let usual = std::panic::take_hook();
        ending.at_panics(&gate);
        let ahead = MotorPair { port: 0.5, starboard: 0.5 };
        gate.command(ahead);
        // A panic of the uplink does not end the program.
        let uplink = std::thread::Builder::new().name(UPLINK_THREADS.to_owned());
        assert!(uplink.spawn(|| panic!("a letter was lost")).unwrap().join().is_err());
        assert!(!ending.is_near() && !ending.has_fault());
        let broken = std::thread::spawn(|| panic!("a wheel came off")).join();
        std::panic::set_hook(usual);
        assert!(broken.is_err() && ending.is_near() && ending.has_fault());
        assert_eq!((got.recv().unwrap(), got.recv().unwrap()), (ahead, MotorPair::STOPPED));
        gate.command(ahead);
        assert_eq!(got.recv().unwrap(), MotorPair::STOPPED);
    }
}
