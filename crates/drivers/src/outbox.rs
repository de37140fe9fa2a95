//! A driver's outputs for the owner of its port, in order and bounded.

use crate::{Note, Output, State};
use std::collections::VecDeque;

/// Outputs that wait at most. The owner of a port takes all after each input, and one input of a port makes far fewer.
pub(crate) const MOST_WAITING: usize = 4096;

/// Outputs that wait. When it is full the oldest reading or note makes room, as the newest say how things are; what is to be
/// sent and states go first only where nothing else is left.
#[derive(Debug, Clone, Default)]
pub(crate) struct Outbox {
    waiting: VecDeque<Output>,
    /// The state that was given last.
    state: Option<State>,
}

impl Outbox {
    pub(crate) fn push(&mut self, output: Output) {
        if self.waiting.len() >= MOST_WAITING {
            let droppable = |one: &Output| matches!(one, Output::Reading { .. } | Output::Note(_));
            let oldest = self.waiting.iter().position(droppable).unwrap_or(0);
            self.waiting.remove(oldest);
        }
        self.waiting.push_back(output);
    }

    /// Gives a state if it is another than the last.
    pub(crate) fn state(&mut self, state: State) {
        if self.state.as_ref() != Some(&state) {
            self.state = Some(state.clone());
            self.push(Output::State(state));
        }
    }

    /// The port is gone.
    pub(crate) fn port_lost(&mut self) {
        self.state(State::Failing("its port is gone: check the cable and its plug".to_owned()));
    }

    /// Whether the last state was a failure.
    pub(crate) fn is_failing(&self) -> bool {
        matches!(self.state, Some(State::Failing(_)))
    }

    pub(crate) fn note(&mut self, warning: bool, text: impl Into<String>) {
        self.push(Output::Note(Note { warning, text: text.into() }));
    }

    pub(crate) fn pop(&mut self) -> Option<Output> {
        self.waiting.pop_front()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_full_box_keeps_states_and_the_newest() {
        let mut outbox = Outbox::default();
        outbox.state(State::Working);
        outbox.state(State::Working);
        for number in 0..10_000 {
            outbox.note(false, number.to_string());
        }
        let all: Vec<Output> = std::iter::from_fn(|| outbox.pop()).collect();
        assert_eq!(all.len(), MOST_WAITING);
        assert_eq!(all[0], Output::State(State::Working));
        assert_eq!(all[all.len() - 1], Output::Note(Note { warning: false, text: "9999".to_owned() }));
    }
}
