//! What a program has to do when the brain has spoken, in this order.

use crate::disk::recording::{input_record, output_record};
use crate::vehicle::BrainEvent;
use onboard::Output;
use units::Now;

/// One thing to do.
#[derive(Debug)]
pub(crate) enum Due {
    /// A record of what passed is to be kept: its kind and its bytes.
    Record(u8, Vec<u8>),
    /// The brain wanted this at a moment.
    Output(Now, Output),
}

/// Notes what passes between the brain and the program; records of it only where they are kept.
pub(crate) fn noting(due: &mut Vec<Due>, records: bool) -> impl FnMut(Now, BrainEvent<'_>) {
    move |now, event| {
        if records {
            let (kind, bytes) = match &event {
                BrainEvent::Input(input) => input_record(now, input),
                BrainEvent::Output(output) => output_record(output),
            };
            due.push(Due::Record(kind, bytes));
        }
        if let BrainEvent::Output(output) = event {
            due.push(Due::Output(now, output));
        }
    }
}
