//! Steering by hand: the WebSocket `/api/v1/vessels/{vessel}/teleop`.
//!
//! The browser samples a person's input 20 times a second and sends each sample at once; the server answers 20 times a
//! second with its state and with a stamp of its clock, which the next sample brings back: by it a sample's age is
//! known without the browser's clock.

use crate::Wording;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// What a browser sends.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub enum TeleopMessage {
    /// The vessel is to be steered by hand: what it does ends. Needs control from this window.
    Begin {
        /// Distinguishes the windows of a person.
        window: String,
    },
    /// The person's present input.
    Sample(TeleopSample),
    /// Stop at once; the sticks pass neutral before the vessel moves again.
    Stop {
        /// What happened.
        why: TeleopStop,
    },
    /// Steering by hand ends.
    End {},
}

/// Why a browser stops on its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(test, derive(ts_rs::TS))]
pub enum TeleopStop {
    /// The window was hidden.
    Hidden,
    /// The window or its keys lost the focus.
    Unfocused,
    /// The gamepad that steered is gone.
    GamepadGone,
    /// Two input devices were held at once, or another gamepad came.
    TwoDevices,
    /// No key was pressed or let go, and no finger moved, for too long.
    Unmoved,
    /// The person stopped it.
    Person,
}

/// A person's input.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct TeleopSample {
    /// Greater than that of the sample before.
    #[cfg_attr(test, ts(type = "number"))]
    pub seq: u64,
    /// When it was made, by a clock of the browser that does not step, ms.
    pub made_ms: f64,
    /// Another number than before when the input device has shown life: a gamepad's own timestamp.
    pub change: f64,
    /// The stamp that came last; null before the first.
    #[cfg_attr(test, ts(type = "number | null"))]
    pub stamp_us: Option<u64>,
    /// How long ago it came, ms.
    pub stamp_held_ms: f64,
    /// Whether the dead-man is held.
    pub held: bool,
    /// Ahead, −1 to 1.
    pub thrust: f64,
    /// To starboard, −1 to 1.
    pub turn: f64,
}

/// How far steering by hand is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "lowercase")]
#[cfg_attr(test, derive(ts_rs::TS))]
pub enum TeleopPhase {
    /// It was not begun.
    Idle,
    /// The vessel was asked and has not confirmed that it is steered by hand.
    Starting,
    /// The motors stand still until the dead-man was released and the sticks were in neutral.
    Locked,
    /// The dead-man may be held, with the sticks in neutral.
    Ready,
    /// The sticks steer.
    Steering,
}

/// What the server answers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct TeleopStatus {
    /// The server's steady clock, µs, to be brought back by the next sample.
    #[cfg_attr(test, ts(type = "number"))]
    pub stamp_us: u64,
    /// How far it is.
    pub phase: TeleopPhase,
    /// Why it stopped, did not begin or ended, in words; it stays until the sticks steer again.
    pub why: String,
    /// Of what pages make `why` in their reader's language; absent where it is empty or the vessel's own words.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(test, ts(optional))]
    pub why_says: Option<Wording>,
    /// The remedy, in words; empty where the only one is to start over.
    pub remedy: String,
    /// The same of `remedy`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(test, ts(optional))]
    pub remedy_says: Option<Wording>,
    /// From the browser to the vessel and back, ms; null while unknown.
    pub round_trip_ms: Option<f64>,
    /// Whether the vessel's own link is counted in: it is known for the vessel link alone.
    pub with_vessel: bool,
    /// Whether the round trip is longer than is good.
    pub slow: bool,
    /// Most thrust and turn at present, of 1.
    pub cap: f64,
}
