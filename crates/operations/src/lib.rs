//! Operating a fleet: who commands which vessel, the outcome of each order, manual steering, and alarms.
//!
//! Pure machines by one clock: time comes in as [`units::Now`], decisions come out. They know the hub's live state and IMC,
//! and nothing of sockets, accounts or pages.
//!
//! - [`Operations`] owns the hub and the machines beside it; the shore holds exactly one.
//! - [`Leases`] says who commands which vessel, [`Commands`] the outcome of each order.
//! - [`alarms::Alarms`] says what is wrong, and who has acknowledged it.
//! - [`Teleop`] turns stick positions into thrust, and stops the motors when they are no longer fresh.

pub mod alarms;
mod commands;
mod leases;
mod operations;
mod teleop;

pub use commands::{
    Answer, Command, CommandEvent, Commands, EntityReport, GOTO_PLAN, Order, OrderedBy, ParameterReport,
    PlanAboard, PlanReport, PlansAboard, Question, Receipt, Reports, Stage, Step, TELEOPERATION_PLAN,
    is_same_value,
};
pub use leases::{
    ANSWER_WITHIN, Change, Held, Holder, LASTS, Lease, LeaseEvent, LeaseRefused, LeaseRequest, Leases,
    NotYours, REASON_CHARS, Waiting,
};
pub use operations::{NotOrdered, Operations};
pub use teleop::{
    BUDGET, CAP_OVER, CAPPED, LIFE, MOST_AGE, NEUTRAL, REFUSE_OVER, Sample, State as TeleopState, Sticks,
    Teleop, WARN_OVER, Why,
};
