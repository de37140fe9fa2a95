//! The computer's board: its watchdog, the signal light and GNSS time, served by their own thread.
//!
//! The control loop calls the [`Board`] in each cycle. The watchdog gets pulses only while the brain's own cycle count
//! changes, so if brain or loop hang, the pulses stop although this thread continues, and the board restarts the computer.
//! Missing pins set their entity to error, and are looked for again; the program continues.

mod pins;
mod post;
#[cfg(test)]
mod tests;
mod time;

use crate::clock::Clock;
use crate::device::Device;
use crate::io::Report;
use anyhow::Context as _;
use config::schema::device::board;
use config::schema::watch;
use config::{Config, Param, Section};
use drivers::light::{MOST_LAMPS, Pattern, Patterns};
use drivers::watchdog::{Pin, WatchdogConfig};
use onboard::Brain;
use pins::Wanted;
use post::{LightPost, Post, Shown, WatchdogPost};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use time::{ChronyPost, PulsePost};

/// The brain's count and the board's warning are checked at least this often.
const LOOK: Duration = Duration::from_millis(100);
/// How long the end waits for the pins to be set.
const END: Duration = Duration::from_secs(1);

/// A post, and the sink of its reports.
type Manned = (Box<dyn Post>, Box<dyn Fn(Report) + Send>);

/// State shared by the loop and the thread.
#[derive(Default)]
struct Held {
    shown: Shown,
    /// The program ends: cleanly or not.
    ending: Option<bool>,
    over: bool,
}

#[derive(Default)]
struct Shared {
    held: Mutex<Held>,
    changed: Condvar,
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, Held> {
        self.held.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Watchdog, signal light and GNSS time.
pub(crate) struct Board {
    shared: Arc<Shared>,
    /// Labels of the entities whose errors the light shows until the next start.
    critical: Vec<String>,
    manned: bool,
}

impl std::fmt::Debug for Board {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Board").field("critical", &self.critical).finish_non_exhaustive()
    }
}

impl Board {
    /// Serves the configured devices; `sink` gets the reports of a device.
    ///
    /// # Errors
    /// When a value of the configuration is not valid; never because the pins are missing.
    pub(crate) fn start<S: Fn(Report) + Send + 'static>(
        config: &Config,
        clock: Clock,
        sink: impl Fn(Device) -> S,
    ) -> anyhow::Result<Self> {
        let mut posts: Vec<Manned> = Vec::new();
        for section in config.running(&board::WATCHDOG).take(1) {
            posts.push((Box::new(watchdog_of(section)), Box::new(sink(Device::Watchdog))));
        }
        let mut critical = Vec::new();
        for section in config.running(&board::LIGHTS).take(1) {
            critical = section.get(&board::CRITICAL);
            let light = light_of(section).with_context(|| format!("[{}]", section.name()))?;
            posts.push((Box::new(light), Box::new(sink(Device::Light))));
        }
        for section in config.running(&watch::clock::CLOCK).take(1) {
            let (pulse, chrony) =
                (section.get(&watch::clock::PULSE_DEVICE), section.get(&watch::clock::CHRONY_SOCKET));
            if !pulse.is_empty() {
                posts.push((Box::new(PulsePost::new(&pulse, clock.clone())), Box::new(sink(Device::Pulse))));
            }
            if !chrony.is_empty() {
                posts.push((Box::new(ChronyPost::new(&chrony)), Box::new(sink(Device::Pulse))));
            }
        }
        Self::man(posts, critical, clock)
    }

    fn man(posts: Vec<Manned>, critical: Vec<String>, clock: Clock) -> anyhow::Result<Self> {
        let shared = Arc::new(Shared::default());
        let manned = !posts.is_empty();
        if manned {
            let shared = Arc::clone(&shared);
            let name = "board".to_owned();
            std::thread::Builder::new().name(name).spawn(move || attend(&shared, posts, &clock))?;
        }
        Ok(Self { shared, critical, manned })
    }

    /// Passes the brain's present state.
    pub(crate) fn attend(&self, brain: &Brain) {
        let critical_failed = self.critical.iter().any(|label| brain.in_error(label));
        self.shared.lock().shown = Shown { vitals: brain.vitals(), critical_failed };
    }

    /// Ends the devices: after a clean end of the program the watchdog is switched off first, after a panic it is left on.
    pub(crate) fn end(&self, clean: bool) {
        if !self.manned {
            return;
        }
        self.shared.lock().ending = Some(clean);
        self.shared.changed.notify_all();
        let held = self.shared.lock();
        let waited = self.shared.changed.wait_timeout_while(held, END, |held| !held.over);
        if !waited.unwrap_or_else(PoisonError::into_inner).0.over {
            tracing::error!("the board's pins do not answer: its watchdog may restart the computer");
        }
    }
}

/// The thread's function.
fn attend(shared: &Shared, mut posts: Vec<Manned>, clock: &Clock) {
    let mut held = shared.lock();
    while held.ending.is_none() {
        let shown = held.shown;
        drop(held);
        let now = clock.now().mono;
        for (post, sink) in &mut posts {
            post.turn(now, &shown).into_iter().for_each(sink);
        }
        let due = posts.iter().filter_map(|(post, _)| post.due()).min();
        let wait = due.map_or(LOOK, |due| due.since(now).min(LOOK));
        held = shared.lock();
        if held.ending.is_none() {
            held = shared.changed.wait_timeout(held, wait).unwrap_or_else(PoisonError::into_inner).0;
        }
    }
    let clean = held.ending == Some(true);
    drop(held);
    for (post, _) in &mut posts {
        post.end(clean);
    }
    shared.lock().over = true;
    shared.changed.notify_all();
}

fn watchdog_of(section: &Section) -> WatchdogPost {
    let config = WatchdogConfig {
        // The schema keeps the frequency above zero.
        period: Duration::from_secs_f64(1.0 / section.get(&board::FREQUENCY)),
        pulse: Duration::from_secs_f64(section.get(&board::PULSE)),
    };
    let outputs = [Pin::Force, Pin::Heartbeat, Pin::Enable].map(Pin::bcm).to_vec();
    let wanted = Wanted { outputs, inputs: vec![Pin::Expiry.bcm()] };
    WatchdogPost::new(pins::of_kernel(section.get(&board::CHIP), wanted), config)
}

fn light_of(section: &Section) -> anyhow::Result<LightPost> {
    // The schema keeps them within the computer's pins.
    let lamps: Vec<u8> = section.get(&board::PINS).into_iter().map(|pin| pin as u8).collect();
    anyhow::ensure!(
        (1..=MOST_LAMPS).contains(&lamps.len()),
        "Identifiers: a light has 1 to {MOST_LAMPS} lamps, not {}",
        lamps.len()
    );
    let pattern = |param: &Param<Vec<i64>>| {
        Pattern::new(&section.get(param), lamps.len()).with_context(|| param.spec.name.to_owned())
    };
    let patterns = Patterns {
        normal: pattern(&board::PATTERN_NORMAL)?,
        fuel_low: pattern(&board::PATTERN_FUEL_LOW)?,
        starting: pattern(&board::PATTERN_STARTING)?,
        executing: pattern(&board::PATTERN_EXECUTING)?,
        error: pattern(&board::PATTERN_ERROR)?,
        fatal: pattern(&board::PATTERN_FATAL)?,
        shutdown: pattern(&board::PATTERN_SHUTDOWN)?,
    };
    let wanted = Wanted { outputs: lamps.clone(), inputs: Vec::new() };
    Ok(LightPost::new(pins::of_kernel(section.get(&board::CHIP), wanted), lamps, patterns))
}
