//! Teleoperation: an operator steers until done.

use super::behaviour::{Behaviour, Context, Left};
use crate::command::{Command, Operator};
use crate::event::Event;
use units::Now;

/// Let an operator steer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Teleoperation {
    /// The operator who steers.
    pub operator: Operator,
}

#[derive(Debug, Clone)]
pub(crate) struct Machine(Teleoperation);

impl Machine {
    pub(super) fn new(teleoperation: Teleoperation) -> Self {
        Self(teleoperation)
    }
}

impl Behaviour for Machine {
    fn start(&mut self, cx: &mut Context<'_>) {
        cx.command(Command::Teleoperate(self.0.operator));
    }

    /// Any system may end an open teleoperation; only its operator may end a reserved one.
    fn event(&mut self, cx: &mut Context<'_>, event: &Event) {
        if let Event::TeleoperationDone { from } = event
            && self.0.operator.admits(*from)
        {
            cx.done();
        }
    }

    fn left(&self, _: Now) -> Option<Left> {
        None
    }
}
