//! What the program must do after a call of the brain, in this order.

use crate::disk::recording::{input_record, output_record};
use crate::vehicle::BrainEvent;
use onboard::Output;
use units::Now;

/// One thing to do.
#[derive(Debug)]
pub(crate) enum Due {
    /// A record is to be stored: its kind and its bytes.
    Record(u8, Vec<u8>),
    /// The brain produced this output at this time.
    Output(Now, Output),
}

/// Collects inputs and outputs of the brain; records only if `records`.
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
