//! `lutra-agent motors test`: determines by trial which motor is on which side and in which direction it turns.
//!
//! Each motor of the card turns gently ahead for two seconds, after a person has confirmed that no one is near. The
//! person's observations become lines of the configuration. No agent may steer meanwhile: its data folder is locked, and so
//! is the port, against agents with other folders. The program commands twenty times a second; when it ends in any way, the
//! driver or the card stops the motors within a second.

use crate::clock::Clock;
use crate::disk::DataLock;
use crate::hardware::{CanMotors, Orders, motors_config, motors_place};
use crate::io::{Report, Station, Wake};
use crate::say::say;
use crate::setup;
use anyhow::{Context as _, bail};
use clap::Args;
use config::schema::device::torqeedo;
use control::MotorPair;
use devices::{Pair, Reading, Side};
use drivers::State;
use drivers::motors::{MotorAssignment, Motors, MotorsConfig};
use std::io::{BufRead, Write as _};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, sync_channel};
use std::time::{Duration, Instant};

/// Throttle of the trial: the least that reliably turns a propeller in water.
const GENTLE: f64 = 0.15;
/// How long a motor turns.
const TURN: Duration = Duration::from_secs(2);
/// Commands are refreshed at this interval.
const RENEW: Duration = Duration::from_millis(50);
/// How long the card may take to answer.
const ANSWER: Duration = Duration::from_secs(8);
const CLOSE: Duration = Duration::from_secs(1);
const MOST_REPORTS: usize = 1024;

#[derive(Debug, Args)]
pub(crate) struct MotorsTestArguments {
    /// The main configuration file, in DUNE's .ini dialect.
    config: PathBuf,
    /// Profile.
    #[arg(long, default_value = "Hardware")]
    profile: String,
    /// The agent's folder for plans and logs, as of `run`: it must not be in use.
    #[arg(long, default_value = "lutra-agent-data")]
    data: PathBuf,
}

/// What a person saw of one motor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Seen {
    side: Side,
    reversed: bool,
}

/// The card, its motors by their numbers: 0 as port, 1 as starboard.
struct Card {
    clock: Clock,
    orders: Arc<Orders>,
    wake: Arc<Wake>,
    station: Station,
    reports: Receiver<Report>,
}

pub(crate) fn motors_test(arguments: &MotorsTestArguments) -> anyhow::Result<()> {
    let config = setup::load_aboard(&arguments.config, &arguments.profile, &arguments.data)?;
    let _lock = DataLock::take(&arguments.data)?;
    let section = config.running(&torqeedo::TORQEEDO).next();
    let section =
        section.context("no [Actuators.Torqeedo] runs in this profile: `Enabled` says in which it does")?;
    let (place, wire) = motors_place(section)?;
    let straight = |motor| MotorAssignment { motor, reversed: false };
    let sides = Pair::new(straight(0), straight(1));
    let motors = Motors::new(MotorsConfig { sides, ..motors_config(section)? })?;
    let clock = Clock::system();
    let (orders, wake) = (Arc::new(Orders::default()), Arc::new(Wake::new()?));
    let (sent, reports) = sync_channel(MOST_REPORTS);
    let sink = move |report| {
        sent.try_send(report).ok();
    };
    let driver = Box::new(CanMotors::new(motors, wire, Arc::clone(&orders)));
    say!("opening {place}");
    let station = Station::start("motors", driver, place, clock.clone(), Arc::clone(&wake), sink)?;
    let card = Card { clock, orders, wake, station, reports };
    card.wait_until_it_works()?;
    let mut input = std::io::stdin().lock();
    let mut seen = Vec::new();
    for motor in [0, 1] {
        seen.push(card.try_motor(motor, &mut input)?);
    }
    card.end()?;
    conclude(seen[0], seen[1])
}

impl Card {
    fn wait_until_it_works(&self) -> anyhow::Result<()> {
        let until = Instant::now() + ANSWER;
        let mut why = "it has not answered: has the card power, and is the bus' speed right?".to_owned();
        while let Ok(report) = self.reports.recv_timeout(until.saturating_duration_since(Instant::now())) {
            match report {
                Report::State(State::Working) => return Ok(()),
                Report::State(State::Failing(failing)) => why = failing,
                Report::State(State::Starting) | Report::Reading(..) | Report::Note(_) => {}
            }
        }
        bail!("the motors' card cannot be used: {why}")
    }

    fn command(&self, motors: MotorPair) {
        self.orders.put(self.clock.now().mono, motors);
        self.wake.ring();
    }

    /// Turns one motor and asks what was seen.
    fn try_motor(&self, motor: u8, input: &mut impl BufRead) -> anyhow::Result<Option<Seen>> {
        let question = format!(
            "Motor {motor} will turn gently ahead for {} s. Are all people, lines and hands clear of BOTH propellers? Type `clear`:",
            TURN.as_secs()
        );
        if ask(input, &question, &["clear"])?.is_none() {
            bail!("ended: nothing was turned without `clear`");
        }
        let rpm = self.turn(motor);
        match rpm {
            Some(rpm) => say!("the card reports {rpm:.0} rpm of the propeller"),
            None => say!(
                "the card reported no speed: see its power channels (`Power Channel H_MOT{motor} - State`)"
            ),
        }
        let side = match ask(
            input,
            "Which propeller turned? Type `port`, `starboard` or `none`:",
            &["port", "starboard", "none"],
        )? {
            Some("port") => Side::Port,
            Some("starboard") => Side::Starboard,
            _ => return Ok(None),
        };
        let pushed =
            ask(input, "Was water pushed astern, as for sailing ahead? Type `yes` or `no`:", &["yes", "no"])?;
        Ok(Some(Seen { side, reversed: pushed == Some("no") }))
    }

    /// Turns one motor; returns the highest reported speed (rpm).
    fn turn(&self, motor: u8) -> Option<f64> {
        while self.reports.try_recv().is_ok() {}
        let (command, side) = match motor {
            0 => (MotorPair { port: GENTLE, starboard: 0.0 }, Side::Port),
            _ => (MotorPair { port: 0.0, starboard: GENTLE }, Side::Starboard),
        };
        let (until, mut fastest) = (Instant::now() + TURN, None::<f64>);
        while Instant::now() < until {
            self.command(command);
            if let Ok(Report::Reading(_, Reading::Motor(of, reading))) = self.reports.recv_timeout(RENEW)
                && of == side
            {
                let before = fastest.unwrap_or(0.0);
                fastest = Some(if reading.propeller_rpm.abs() > before.abs() {
                    reading.propeller_rpm
                } else {
                    before
                });
            }
        }
        self.command(MotorPair::STOPPED);
        fastest
    }

    fn end(self) -> anyhow::Result<()> {
        self.command(MotorPair::STOPPED);
        self.station.end();
        if !self.station.is_over_within(CLOSE) {
            bail!("the port does not take the stop; the card stops the motors within a second");
        }
        Ok(())
    }
}

/// Asks until the answer is one of these; `None` at the end of the input.
fn ask(
    input: &mut impl BufRead,
    question: &str,
    answers: &[&'static str],
) -> anyhow::Result<Option<&'static str>> {
    loop {
        say!("{question}");
        std::io::stdout().flush().ok();
        let mut line = String::new();
        if input.read_line(&mut line).context("reading the answer")? == 0 {
            return Ok(None);
        }
        let given = line.trim().to_lowercase();
        if let Some(answer) = answers.iter().find(|answer| **answer == given) {
            return Ok(Some(answer));
        }
        say!("`{given}` is not one of: {}", answers.join(", "));
    }
}

/// Prints what to configure.
fn conclude(motor_0: Option<Seen>, motor_1: Option<Seen>) -> anyhow::Result<()> {
    let (Some(zero), Some(one)) = (motor_0, motor_1) else {
        bail!(
            "a motor did not turn: look at its power channel (`Power Channel H_MOT0 - State = 1`), its cable and its kill switch"
        );
    };
    if zero.side == one.side {
        bail!("both motors were seen on the same side: repeat the test");
    }
    let (port_motor, port, starboard) = if zero.side == Side::Port { (0, zero, one) } else { (1, one, zero) };
    say!("Write into the configuration of this vessel:\n[Actuators.Torqeedo]");
    say!("Port Motor - Number = {port_motor}");
    say!("Port Motor - Reversed = {}", port.reversed);
    say!("Starboard Motor - Reversed = {}", starboard.reversed);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_answer_is_asked_for_until_it_is_one() {
        let mut input = &b"what?\n Yes \nno\n"[..];
        let answers = ["yes", "no"];
        assert_eq!(ask(&mut input, "?", &answers).unwrap(), Some("yes"));
        assert_eq!(ask(&mut input, "?", &answers).unwrap(), Some("no"));
        assert_eq!(ask(&mut input, "?", &answers).unwrap(), None);
    }

    #[test]
    fn motors_on_one_side_or_that_did_not_turn_give_no_configuration() {
        let port = Some(Seen { side: Side::Port, reversed: false });
        assert!(conclude(port, port).is_err() && conclude(port, None).is_err());
        assert!(conclude(Some(Seen { side: Side::Starboard, reversed: true }), port).is_ok());
    }
}
