//! The brain of a vessel: one deterministic state machine between sensors, peers, motors and the log.
//!
//! [`Brain`] takes [`Input`]s with their moment and gives [`Output`]s; it has no clock, no threads, no
//! randomness and no input or output of its own. A simulated hour runs in seconds and gives the same bytes
//! twice. [`record`] turns inputs and outputs into bytes for that.
//!
//! Inside, in the order in which a fix becomes thrust: [`Navigation`] (compass to estimate), the pilot (path
//! and operator to thruster commands), [`Authority`] (whose commands reach the motors, and for how long).
//! [`LeaseGate`] says whom it obeys. Above them the mission: plan database, plan engine and maneuvers, supervisors.
//! Around them the bus: entity states, discovery, contacts, parameters, the log book.
//!
//! It translates between IMC and the cores `control`, `mission`, `guard`, `planner` and `charts`. It knows readings (`devices`) but no port,
//! file or socket, and nothing of the shore.

mod arbiter;
mod authority;
mod brain;
mod bus;
mod chart_change;
mod clock;
mod conditions;
mod discovery;
mod entity;
mod epoch;
mod gate;
mod grounding;
mod health;
mod hydrophone;
mod input;
mod intake;
mod lease;
mod log;
mod navigation;
mod node;
mod operator;
mod output;
pub mod parameters;
mod path_wire;
mod peer;
mod pilot;
mod plans;
mod poses;
mod power;
mod preflight;
mod reception;
pub mod record;
mod routing;
mod sensors;
mod settings;
mod sight;
mod states;
mod stray;
mod supervise;
mod under_way;
mod vitals;
mod warnings;

pub use authority::{Authority, COMMAND_LIFE, Owner, Refusal};
pub use brain::Brain;
pub use charts::depth_index::ChartTrust;
pub use entity::{Entity, Labels};
pub use grounding::{Chart, ChartFile, GroundingAction, GroundingSettings};
pub use input::{DeviceState, HostReading, Input, Reachable};
pub use lease::{Lease, LeaseGate, Mandate, NotObeyed, is_order};
pub use navigation::{Arrival, Estimate, Navigation, NavigationHealth, NavigationSettings, Rejection};
pub use output::{Keep, Level, Output};
pub use peer::{Peer, SERVERS};
pub use plans::{LONGEST_NAME as LONGEST_PLAN_NAME, LONGEST_PLAN, checked as checked_plan};
pub use poses::LeverArm;
pub use routing::{FoundRoute, RouteAnswer, RouteRequest, RouteSettings, Routes};
pub use settings::{
    AfterRestart, HydrophoneSettings, MissionSettings, NodeSettings, PowerChannel, RestartSettings, Settings,
    TransportSettings, WatchSettings,
};
pub use states::Condition;
pub use vitals::Vitals;
