use super::*;
use proptest::prelude::*;
use units::UtcTime;

/// One way between browser and server (ms).
const WAY_MS: u64 = 20;

fn ms(ms: u64) -> MonoTime {
    MonoTime::from_micros(ms * 1_000)
}

/// The same time with a wall clock that is never set.
fn now(now_ms: u64) -> Now {
    Now { mono: ms(now_ms), utc: UtcTime::from_micros(1_700_000_000_000_000 + 1_000 * now_ms as i64) }
}

/// A browser whose samples take [`WAY_MS`] unless stated otherwise.
struct Hands {
    teleop: Teleop,
    seq: u64,
    now_ms: u64,
}

impl Hands {
    fn new() -> Self {
        Self { teleop: Teleop::new(), seq: 0, now_ms: 1_000 }
    }

    fn make(&mut self, held: bool, thrust: f64, turn: f64) -> Sample {
        self.now_ms += 50;
        self.seq += 1;
        Sample {
            seq: self.seq,
            made_ms: self.now_ms as f64,
            change: self.seq as f64,
            echo: Some(ms(self.now_ms - WAY_MS - 10)),
            echo_held: Duration::from_millis(10),
            held,
            thrust,
            turn,
        }
    }

    fn give(&mut self, sample: &Sample) -> Option<Sticks> {
        self.teleop.tick(now(self.now_ms));
        self.teleop.sample(ms(self.now_ms + WAY_MS), sample)
    }

    fn say(&mut self, held: bool, thrust: f64, turn: f64) -> Option<Sticks> {
        let sample = self.make(held, thrust, turn);
        self.give(&sample)
    }

    /// Through neutral, then ahead.
    fn steering() -> Self {
        let mut hands = Self::new();
        hands.resume();
        hands
    }

    fn resume(&mut self) {
        assert!(self.say(false, 0.0, 0.0).is_none());
        assert!(self.say(true, 0.0, 0.0).is_some_and(|sticks| sticks.port == 0.0 && sticks.starboard == 0.0));
        assert!(self.say(true, 1.0, 0.0).is_some_and(|sticks| sticks.port >= 1.0));
    }

    /// It stopped, and neither held sticks nor a dead-man that is still held move anything.
    fn is_locked(&mut self, why: Why) {
        assert_eq!((self.teleop.state(), self.teleop.why()), (State::Locked, why));
        assert_eq!(self.teleop.tick(now(self.now_ms + WAY_MS)), Some(Sticks::STOP));
        assert!(self.say(true, 1.0, 0.0).is_none(), "the sticks did not pass neutral");
        assert!(self.say(true, 0.0, 0.0).is_none(), "the dead-man was not released");
        assert!(self.say(false, 0.5, 0.0).is_none());
        assert!(self.say(true, 0.0, 0.0).is_none(), "not both at once");
        self.resume();
    }
}

#[test]
fn neutral_comes_first() {
    let mut hands = Hands::new();
    assert!(hands.say(true, 1.0, 0.0).is_none());
    assert!(hands.say(false, 0.0, 0.0).is_none());
    assert_eq!(hands.teleop.state(), State::Ready);
    assert!(hands.say(true, 0.6, 0.0).is_none(), "the stick was moved before the dead-man was held");
    hands.resume();
    let turn = hands.say(true, 0.54, 0.5).unwrap();
    assert!(turn.port > 0.9 && turn.starboard < 0.1, "{turn:?}");
    assert!(hands.say(false, 1.0, 0.0).is_none());
    hands.is_locked(Why::Released);
}

#[test]
fn a_sample_that_took_too_long_interrupts() {
    let mut hands = Hands::steering();
    let late = hands.make(true, 1.0, 0.0);
    assert!(hands.teleop.sample(ms(hands.now_ms + MOST_AGE.as_millis() as u64 + 1), &late).is_none());
    hands.now_ms += 231;
    hands.is_locked(Why::Late);
    let silent = Sample { echo: None, ..hands.make(true, 1.0, 0.0) };
    assert!(hands.give(&silent).is_none());
    hands.is_locked(Why::Late);
}

#[test]
fn silence_interrupts_within_the_age() {
    let mut hands = Hands::steering();
    let made = hands.now_ms;
    assert_eq!(hands.teleop.tick(now(made + 180)), None);
    assert_eq!(hands.teleop.tick(now(made + 181)), Some(Sticks::STOP));
    hands.now_ms += 300;
    hands.is_locked(Why::Silent);
}

#[test]
fn a_frozen_gamepad_is_stale_though_messages_flow() {
    let mut hands = Hands::steering();
    let change = hands.seq as f64;
    let mut moved = 0;
    while hands.teleop.state() == State::Steering {
        let frozen = Sample { change, ..hands.make(true, 1.0, 0.0) };
        moved += u64::from(hands.give(&frozen).is_some());
    }
    assert!((2..=4).contains(&moved), "{moved}");
    hands.is_locked(Why::Frozen);
    // A person who does not hold the dead-man may leave the device alone.
    for _ in 0..20 {
        let resting = Sample { change, ..hands.make(false, 0.0, 0.0) };
        hands.give(&resting);
    }
    assert_eq!(hands.teleop.state(), State::Ready);
}

#[test]
fn a_clock_that_jumps_and_nonsense_interrupt() {
    for jump_ms in [3_600_000.0, -3_600_000.0] {
        let mut hands = Hands::steering();
        let mut jumped = hands.make(true, 1.0, 0.0);
        jumped.made_ms += jump_ms;
        assert!(hands.give(&jumped).is_none());
        assert_eq!(hands.teleop.why(), Why::Clock);
        assert!(hands.say(true, 1.0, 0.0).is_none());
    }
    let bad: [fn(&mut Sample); 4] = [
        |sample| sample.thrust = f64::NAN,
        |sample| sample.turn = 1.1,
        |sample| sample.seq = 1,
        |sample| sample.made_ms = f64::INFINITY,
    ];
    for spoil in bad {
        let mut hands = Hands::steering();
        let mut sample = hands.make(true, 1.0, 0.0);
        spoil(&mut sample);
        assert!(hands.give(&sample).is_none());
        hands.is_locked(Why::Invalid);
    }
}

#[test]
fn a_window_a_lease_or_a_vessel_that_is_gone_and_hands_that_do_not_move_interrupt() {
    for why in [Why::Hidden, Why::Unmoved, Why::Lease, Why::Vessel] {
        let mut hands = Hands::steering();
        hands.teleop.interrupt(why);
        hands.is_locked(why);
    }
}

#[test]
fn a_clock_of_the_server_that_is_set_interrupts() {
    for set_us in [3_600_000_000, -3_600_000_000] {
        let mut hands = Hands::steering();
        let at = now(hands.now_ms + WAY_MS);
        let set = Now { utc: UtcTime::from_micros(at.utc.micros() + set_us), ..at };
        assert_eq!(hands.teleop.tick(set), Some(Sticks::STOP));
        assert_eq!((hands.teleop.state(), hands.teleop.why()), (State::Locked, Why::ServerClock));
        assert!(hands.say(true, 1.0, 0.0).is_none());
    }
}

#[test]
fn why_it_stopped_is_told_until_it_goes_on_and_what_hinders_now_too() {
    let mut hands = Hands::steering();
    hands.teleop.interrupt(Why::Hidden);
    assert_eq!((hands.teleop.why(), hands.teleop.hinders()), (Why::Hidden, None));
    hands.now_ms += 1_000;
    hands.teleop.interrupt(Why::Vessel);
    assert_eq!((hands.teleop.why(), hands.teleop.hinders()), (Why::Hidden, Some(Why::Vessel)));
    hands.say(false, 0.0, 0.0);
    assert_eq!((hands.teleop.why(), hands.teleop.hinders()), (Why::Hidden, None));
    hands.teleop.begin();
    assert_eq!((hands.teleop.state(), hands.teleop.why()), (State::Locked, Why::Begun));
}

#[test]
fn a_long_round_trip_limits_and_then_refuses() {
    let mut hands = Hands::steering();
    assert!(hands.teleop.may_begin());
    hands.teleop.vessel_trip(Duration::from_millis(480));
    let capped = hands.say(true, 1.0, 0.3).unwrap();
    assert!(capped.port <= CAPPED && capped.starboard < CAPPED, "{capped:?}");
    assert_eq!(capped.life, Duration::from_millis(700 - 40 - 50 - 240));
    hands.teleop.vessel_trip(Duration::from_secs(1));
    assert!(!hands.teleop.may_begin());
    assert!(hands.say(true, 1.0, 0.0).is_none());
    hands.teleop.vessel_trip(Duration::ZERO);
    hands.is_locked(Why::RoundTrip);
}

#[test]
fn what_is_sent_is_what_consoles_send() {
    let sticks = Sticks { port: 1.0, starboard: -0.5, life: Duration::from_millis(450), stop: false };
    assert_eq!(sticks.actions(), "Port Motor=127;Starboard Motor=-64;Life=450");
    assert_eq!(Sticks::STOP.actions(), "Port Motor=0;Starboard Motor=0;Stop=1");
}

/// The events of 50 ms: the sample's delay beyond the usual, whether one comes, the input, the device.
#[derive(Debug, Clone)]
struct Moment {
    comes: bool,
    late_ms: u64,
    held: bool,
    thrust: f64,
    alive: bool,
    jump_ms: f64,
}

fn moment() -> impl Strategy<Value = Moment> {
    let late_ms = prop_oneof![4 => 0_u64..40, 1 => 0_u64..2_000];
    let thrust = prop_oneof![Just(0.0), -1.0..1.0_f64];
    let jump_ms = prop_oneof![30 => Just(0.0), 1 => -1e5..1e5_f64];
    let flag = |percent| prop::bool::weighted(percent);
    (flag(0.9), late_ms, flag(0.8), thrust, flag(0.8), jump_ms).prop_map(
        |(comes, late_ms, held, thrust, alive, jump_ms)| Moment {
            comes,
            late_ms,
            held,
            thrust,
            alive,
            jump_ms,
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]

    /// Thrust is sent only for a sample with the dead-man held, and its life ends within the budget after the last
    /// sign of life of the person's hands, whatever the network and the clocks do; and only after neutral.
    #[test]
    fn thrust_has_a_fresh_hand_behind_it(moments in prop::collection::vec(moment(), 1..200), vessel_ms in 0_u64..400) {
        let mut teleop = Teleop::new();
        teleop.vessel_trip(Duration::from_millis(vessel_ms));
        // Samples come in the order in which they were made.
        let (mut arrives, mut jumped_ms, mut change, mut alive_at) = (0, 0.0, 0.0, 0);
        let mut coming = Vec::new();
        for (n, one) in moments.iter().enumerate() {
            let made = 1_000 + 50 * n as u64;
            jumped_ms += one.jump_ms;
            if one.alive || coming.is_empty() {
                (change, alive_at) = (n as f64, made);
            }
            if !one.comes {
                continue;
            }
            arrives = arrives.max(made + WAY_MS + one.late_ms);
            let sample = Sample {
                seq: n as u64 + 1,
                made_ms: made as f64 + jumped_ms,
                change,
                echo: Some(ms(made - WAY_MS)),
                echo_held: Duration::ZERO,
                held: one.held,
                thrust: one.thrust,
                turn: 0.0,
            };
            coming.push((arrives, alive_at, sample));
        }
        let mut coming = coming.into_iter().peekable();
        let mut passed_neutral = false;
        for now_ms in (1_000..1_000 + 50 * moments.len() as u64 + 3_000).step_by(5) {
            teleop.tick(now(now_ms));
            passed_neutral &= teleop.state() == State::Steering;
            while let Some((at, alive_at, sample)) = coming.next_if(|(at, ..)| *at <= now_ms) {
                let sticks = teleop.sample(ms(at.max(now_ms)), &sample);
                let neutral = sample.thrust.abs() <= NEUTRAL;
                passed_neutral |= sample.held && neutral && teleop.state() == State::Steering;
                passed_neutral &= teleop.state() == State::Steering;
                let Some(sticks) = sticks.filter(|sticks| sticks.port != 0.0) else { continue };
                prop_assert!(sample.held && passed_neutral);
                let ends = now_ms + vessel_ms / 2 + sticks.life.as_millis() as u64;
                prop_assert!(ends <= alive_at + BUDGET.as_millis() as u64, "{} {}", ends, alive_at);
            }
        }
    }
}
