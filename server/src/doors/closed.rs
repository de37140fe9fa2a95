//! A shore with all doors closed: nobody comes in, so the fleet is empty and never changes.

use crate::shore::{Changes, Fleet, FleetQuestion};
use tokio::sync::{mpsc, watch};

/// Questions that may wait for their answer; askers wait when there are more.
const WAITING: usize = 64;

/// The handle of an empty fleet, and the task that answers for it until the last handle is gone.
pub(crate) fn closed() -> (Fleet, impl Future<Output = ()>) {
    let (questions, mut asked) = mpsc::channel(WAITING);
    let (changed, revision) = watch::channel(1);
    let answering = async move {
        while let Some(question) = asked.recv().await {
            match question {
                FleetQuestion::Systems { answer, .. } => drop(answer.send(Vec::new())),
                FleetQuestion::Changes { answer, .. } => {
                    drop(answer.send(Changes { revision: *changed.borrow(), ..Changes::default() }));
                }
            }
        }
    };
    (Fleet::new(questions, revision), answering)
}
