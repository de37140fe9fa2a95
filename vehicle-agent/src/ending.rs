//! Why and how the program ends: by a signal or by a fault of its own, the motors first in either case.

use crate::motor_gate::MotorGate;
use anyhow::Context as _;
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use std::io;
use std::panic::PanicHookInfo;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// What the names of the threads between vessel and shore begin with.
pub(crate) const UPLINK_THREADS: &str = "uplink";
/// The thread that looks for routes.
pub(crate) const ROUTING_THREAD: &str = "routing";

/// The program broke off by a fault of its own.
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

/// Whether the end has come.
#[derive(Debug, Clone, Default)]
pub(crate) struct Ending {
    asked: Arc<AtomicBool>,
    fault: Arc<AtomicBool>,
}

impl Ending {
    /// Ends at SIGTERM, SIGINT (Ctrl-C) and SIGHUP. The last is what a closed terminal sends: whoever looked
    /// after the vessel there is gone, so that it stops. A configuration is read again only by starting again.
    pub(crate) fn at_signals() -> anyhow::Result<Self> {
        let ending = Self::default();
        for signal in [SIGTERM, SIGINT, SIGHUP] {
            signal_hook::flag::register(signal, Arc::clone(&ending.asked)).context("signals")?;
        }
        Ok(ending)
    }

    /// Ends also when standard input does. Whoever holds its other end need not say anything for that: it is closed
    /// however that program ends.
    pub(crate) fn at_end_of_input(&self) -> anyhow::Result<()> {
        let asked = Arc::clone(&self.asked);
        let read = move || {
            // An input that cannot be read says as little as one that has ended.
            io::copy(&mut io::stdin().lock(), &mut io::sink()).ok();
            asked.store(true, Ordering::Relaxed);
        };
        std::thread::Builder::new().name("input".to_owned()).spawn(read).context("cannot start a thread")?;
        Ok(())
    }

    /// Ends at a panic of any thread but those of the way to the shore and the one that looks for routes, which command no
    /// motor and go on: its first deed is to stop the motors.
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
        // Not by the usual hook, which waits for whoever reads standard error.
        tracing::error!(thread, "motors stopped: {panic}");
    }

    /// Whether to end.
    pub(crate) fn is_near(&self) -> bool {
        self.asked.load(Ordering::Relaxed) || self.has_fault()
    }

    /// Whether a fault is the reason.
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
        // The way to the shore is not the vessel.
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
