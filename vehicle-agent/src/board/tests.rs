//! The board with pins in memory and the test's clock.

use super::pins::{Open, Pins};
use super::*;
use drivers::State;
use mission::Mode;
use onboard::Vitals;
use std::collections::BTreeMap;
use units::MonoTime;

/// Levels of the pins, and whether there are any.
#[derive(Default)]
struct Chip {
    levels: BTreeMap<u8, bool>,
    set: Vec<(u8, bool)>,
    absent: bool,
}

#[derive(Clone, Default)]
struct InMemory(Arc<Mutex<Chip>>);

impl InMemory {
    fn chip(&self) -> MutexGuard<'_, Chip> {
        self.0.lock().unwrap()
    }

    fn open(&self) -> Open {
        let chip = self.clone();
        Box::new(move || {
            anyhow::ensure!(!chip.chip().absent, "no pins here");
            Ok(Box::new(chip.clone()))
        })
    }

    /// How often the heartbeat rose.
    fn pulses(&self) -> usize {
        self.chip().set.iter().filter(|set| **set == (Pin::Heartbeat.bcm(), true)).count()
    }
}

impl Pins for InMemory {
    fn set(&mut self, number: u8, high: bool) -> anyhow::Result<()> {
        let mut chip = self.chip();
        anyhow::ensure!(!chip.absent, "the pins are gone");
        chip.levels.insert(number, high);
        chip.set.push((number, high));
        Ok(())
    }

    fn is_high(&mut self, number: u8) -> anyhow::Result<bool> {
        let chip = self.chip();
        anyhow::ensure!(!chip.absent, "the pins are gone");
        Ok(chip.levels.get(&number).copied().unwrap_or_default())
    }
}

fn at(ms: u64) -> MonoTime {
    MonoTime::from_micros(ms * 1000)
}

fn shown(steps: u64, mode: Mode) -> Shown {
    Shown { vitals: Vitals { steps, mode, ..Vitals::default() }, critical_failed: false }
}

/// Calls a post each 50 ms; returns its states.
fn pass(post: &mut dyn Post, from_ms: u64, to_ms: u64, shown: impl Fn(u64) -> Shown) -> Vec<State> {
    let mut states = Vec::new();
    for ms in (from_ms..to_ms).step_by(50) {
        for report in post.turn(at(ms), &shown(ms)) {
            if let Report::State(state) = report {
                states.push(state);
            }
        }
    }
    states
}

fn watchdog(chip: &InMemory) -> WatchdogPost {
    WatchdogPost::new(chip.open(), WatchdogConfig::default())
}

#[test]
fn a_brain_that_hangs_gets_no_pulse_though_the_board_s_thread_runs_on() {
    let chip = InMemory::default();
    let mut post = watchdog(&chip);
    let states = pass(&mut post, 0, 5000, |ms| shown(ms / 100 + 1, Mode::Service));
    assert_eq!(states, [State::Working], "alive at the first look");
    assert!(chip.chip().levels[&Pin::Enable.bcm()]);
    assert_eq!(chip.pulses(), 3);
    let states = pass(&mut post, 5000, 60_000, |_| shown(50, Mode::Service));
    assert!(matches!(&states[..], [State::Failing(why)] if why.contains("does not move on")), "{states:?}");
    assert!(chip.pulses() <= 4, "one for what moved before it hung: {}", chip.pulses());
    post.end(false);
    assert!(chip.chip().levels[&Pin::Enable.bcm()], "after a fault the watchdog stays on");
}

#[test]
fn a_clean_end_turns_the_watchdog_off_before_anything_else() {
    let chip = InMemory::default();
    let mut post = watchdog(&chip);
    pass(&mut post, 0, 2100, |ms| shown(ms + 1, Mode::Service));
    let before = chip.chip().set.len();
    post.end(true);
    let set = chip.chip().set.split_off(before);
    assert_eq!(set, [(Pin::Enable.bcm(), false), (Pin::Heartbeat.bcm(), false)]);
}

#[test]
fn absent_pins_are_an_error_and_are_looked_for_again() {
    let chip = InMemory::default();
    chip.chip().absent = true;
    let mut post = watchdog(&chip);
    let live = |ms| shown(ms + 1, Mode::Service);
    let states = pass(&mut post, 0, 9000, live);
    assert_eq!(states, [State::Failing("no pins here".to_owned())], "tried once");
    chip.chip().absent = false;
    assert_eq!(pass(&mut post, 9000, 12_000, live), [State::Working]);
    chip.chip().absent = true;
    let lost = pass(&mut post, 12_000, 13_000, live);
    assert_eq!(lost.first(), Some(&State::Failing("the pins are gone".to_owned())));
    assert_eq!(post.due(), None);
}

#[test]
fn the_board_s_warning_comes_from_its_pin() {
    let chip = InMemory::default();
    let mut post = watchdog(&chip);
    let live = |ms| shown(ms + 1, Mode::Service);
    pass(&mut post, 0, 1000, live);
    chip.chip().levels.insert(Pin::Expiry.bcm(), true);
    let states = pass(&mut post, 1000, 1200, live);
    assert!(matches!(&states[..], [State::Failing(why)] if why.contains("cut the computer's power")));
}

const LAMP: u8 = 26;

fn light(chip: &InMemory) -> LightPost {
    let pattern = |numbers: &[i64]| Pattern::new(numbers, 1).unwrap();
    let other = pattern(&[1, 100, 0, 100]);
    let patterns = Patterns {
        normal: pattern(&[1, 2000, 0, 2000]),
        fuel_low: other.clone(),
        starting: other.clone(),
        executing: pattern(&[1, 500, 0, 500]),
        error: other.clone(),
        fatal: pattern(&[1, 50, 0, 950]),
        shutdown: other,
    };
    LightPost::new(chip.open(), vec![LAMP], patterns)
}

#[test]
fn the_light_shows_what_the_vessel_does() {
    let chip = InMemory::default();
    let mut post = light(&chip);
    assert_eq!(pass(&mut post, 0, 2500, |_| shown(1, Mode::Service)), [State::Working]);
    let blinks = |chip: &InMemory| std::mem::take(&mut chip.chip().set).len();
    // On and off.
    assert_eq!(blinks(&chip), 2);
    pass(&mut post, 2500, 4000, |_| shown(1, Mode::Maneuver));
    // A pattern that has begun is completed.
    assert_eq!(blinks(&chip), 0);
    pass(&mut post, 4000, 8000, |_| shown(1, Mode::Maneuver));
    assert_eq!(blinks(&chip), 8);
    post.end(true);
    assert!(!chip.chip().levels[&LAMP]);
}

#[test]
fn a_critical_failure_stays_shown_although_the_pins_were_gone() {
    let chip = InMemory::default();
    let mut post = light(&chip);
    pass(&mut post, 0, 100, |_| Shown { critical_failed: true, ..shown(1, Mode::Service) });
    chip.chip().absent = true;
    let lost = pass(&mut post, 100, 3000, |_| shown(1, Mode::Service));
    assert!(matches!(lost[0], State::Failing(_)));
    chip.chip().absent = false;
    pass(&mut post, 3000, 20_000, |_| shown(1, Mode::Service));
    chip.chip().set.clear();
    pass(&mut post, 20_000, 24_000, |_| shown(1, Mode::Service));
    assert_eq!(chip.chip().set.len(), 8, "a blink each second: {:?}", chip.chip().set);
}

#[test]
fn the_thread_ends_with_the_watchdog_off() {
    let chip = InMemory::default();
    let clock = Clock::of(|| Duration::from_secs(1), units::UtcTime::default);
    let post: Manned = (Box::new(watchdog(&chip)), Box::new(|_| {}));
    let board = Board::man(vec![post], Vec::new(), clock).unwrap();
    board.end(true);
    assert!(board.shared.lock().over);
    assert!(!chip.chip().levels.get(&Pin::Enable.bcm()).copied().unwrap_or_default());
}

#[test]
fn the_shipped_configuration_has_both_and_lives_without_their_pins() {
    let files = config::InMemory::new().with("otter.ini", crate::OTTER_INI);
    let config = Config::load(&files, "otter.ini".as_ref(), &["Hardware"]);
    let section = config.running(&board::WATCHDOG).next().unwrap();
    assert_eq!(section.get(&board::CHIP), "/dev/gpiochip0");
    // Whether this computer has such pins or not: it starts, and ends.
    let light = config.running(&board::LIGHTS).next().unwrap();
    assert!(light_of(light).is_ok());
    let none = "/does/not/exist".to_owned();
    let wanted = Wanted { outputs: vec![LAMP], inputs: Vec::new() };
    let error = pins::of_kernel(none, wanted)().err().unwrap();
    assert!(format!("{error:#}").contains("/does/not/exist cannot be taken"), "{error:#}");
}
