//! The keys of a remote operator: `Name=integer` pairs separated by semicolons, as IMC's RemoteActions carries
//! them.

use std::time::Duration;

/// Names and kinds as sent to a console on request (RemoteActionsRequest).
pub const REMOTE_ACTIONS: &str = "Exit=Button;Port Motor=Axis;Starboard Motor=Axis;Accelerate=Button;\
    Decelerate=Button;Heading=Axis;Throttle=Axis;Left=Button;Right=Button;Stop=Button;Ranges=Range127";

/// Longest life that a message can ask for (ms): any silence is longer.
const LONGEST_LIFE_MS: i32 = 10_000;

/// Full deflection of an axis.
const AXIS_RANGE: f64 = 127.0;

/// The state of an operator's keys in one message. Axes are -1 to 1; what a message leaves out is released.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[expect(clippy::struct_excessive_bools, reason = "one for each button of the console")]
pub struct RemoteActions {
    /// Ends manual control.
    pub exit: bool,
    /// Stops both motors and forgets the held throttle.
    pub stop: bool,
    /// Raises the held throttle.
    pub accelerate: bool,
    /// Lowers the held throttle.
    pub decelerate: bool,
    /// Turns the held heading to port by a step (autopilot).
    pub left: bool,
    /// Turns the held heading to starboard by a step (autopilot).
    pub right: bool,
    /// Port motor, ahead positive; used directly when either motor's axis is deflected.
    pub port_motor: f64,
    /// Starboard motor.
    pub starboard_motor: f64,
    /// Turn, starboard positive.
    pub heading: f64,
    /// Throttle; holds as long as no other is given. Absent = the held one.
    pub throttle: Option<f64>,
    /// How long the message is good for, from the time it was sent, "Life" in ms: then the motors stop if none came
    /// since, even if the connection timeout is longer. Lutra's shore sends it with every message; it is not a key, so
    /// it is not announced to consoles.
    pub life: Option<Duration>,
}

impl RemoteActions {
    /// Reads a message. Pairs with unknown names, or values that are not integers, have no effect and are
    /// returned, so that the console that sent them can be informed. Of equal names the last counts.
    pub fn parse(text: &str) -> (Self, Vec<&str>) {
        let mut actions = Self::default();
        let pairs = text.split(';').map(str::trim).filter(|pair| !pair.is_empty());
        let ignored = pairs.filter(|pair| actions.set(pair).is_none()).collect();
        (actions, ignored)
    }

    /// Whether nothing is asked for that moves the vessel.
    pub fn is_neutral(&self) -> bool {
        let axes = [self.port_motor, self.starboard_motor, self.heading, self.throttle.unwrap_or_default()];
        let pressed = self.accelerate || self.decelerate || self.left || self.right;
        axes.into_iter().all(|axis| axis == 0.0) && !pressed
    }

    fn set(&mut self, pair: &str) -> Option<()> {
        let (name, value) = pair.split_once('=')?;
        let value: i32 = value.trim().parse().ok()?;
        let pressed = value != 0;
        let axis = (f64::from(value) / AXIS_RANGE).clamp(-1.0, 1.0);
        match name.trim() {
            "Exit" => self.exit = pressed,
            "Stop" => self.stop = pressed,
            "Accelerate" => self.accelerate = pressed,
            "Decelerate" => self.decelerate = pressed,
            "Left" => self.left = pressed,
            "Right" => self.right = pressed,
            "Port Motor" => self.port_motor = axis,
            "Starboard Motor" => self.starboard_motor = axis,
            "Heading" => self.heading = axis,
            "Throttle" => self.throttle = Some(axis),
            "Life" => {
                let life_ms = value.clamp(0, LONGEST_LIFE_MS).unsigned_abs();
                self.life = Some(Duration::from_millis(life_ms.into()));
            }
            _ => return None,
        }
        Some(())
    }

    /// The same with every axis a number within ±1.
    pub(super) fn sane(self) -> Self {
        let axis = |value: f64| if value.is_nan() { 0.0 } else { value.clamp(-1.0, 1.0) };
        Self {
            port_motor: axis(self.port_motor),
            starboard_motor: axis(self.starboard_motor),
            heading: axis(self.heading),
            throttle: self.throttle.map(axis),
            ..self
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn reads_keys_and_names_what_it_ignores() {
        let (actions, ignored) = RemoteActions::parse(
            "Heading=-127; Accelerate=1;Port Motor=64;Thrust=90;Throttle=0.5;Stop=0;rubbish;Starboard Motor=999;",
        );
        assert!((actions.heading + 1.0).abs() < 1e-12 && (actions.port_motor - 64.0 / 127.0).abs() < 1e-12);
        assert!((actions.starboard_motor - 1.0).abs() < 1e-12);
        assert!(actions.accelerate && !actions.stop && actions.throttle.is_none());
        assert_eq!(ignored, ["Thrust=90", "Throttle=0.5", "rubbish"]);
    }

    #[test]
    fn a_life_is_read() {
        let life = |text| RemoteActions::parse(text).0.life.map(|life| life.as_millis());
        assert_eq!(life("Port Motor=5;Life=450"), Some(450));
        assert_eq!((life("Life=-1"), life("Life=2000000000"), life("Stop=1")), (Some(0), Some(10_000), None));
    }

    #[test]
    fn every_name_that_is_told_is_understood() {
        for pair in REMOTE_ACTIONS.split(';').filter(|pair| !pair.starts_with("Ranges")) {
            let name = pair.split('=').next().unwrap();
            let message = format!("{name}=1");
            let (actions, ignored) = RemoteActions::parse(&message);
            assert!(ignored.is_empty() && actions != RemoteActions::default(), "{name}");
        }
    }

    proptest! {
        #[test]
        fn any_text_gives_axes_within_range(text in "[ A-Za-z=;0-9-]{0,200}") {
            let (actions, _) = RemoteActions::parse(&text);
            prop_assert_eq!(actions, actions.sane());
        }
    }
}
