//! Work that gives way: it takes the processor for long, and live values, commands and alarms go before it.

use crate::error::{Error, Result};
use rustix::process::{getpriority_process, setpriority_process};
use std::io;
use std::thread;
use tokio::sync::oneshot;

/// How far the work stands back in the system's queue for the processors ("nice", 0 to 19): where they are all taken, it gets
/// about a tenth of what others get.
const NICE: i32 = 10;

/// Does `work` on a thread of its own, so that its low priority ends with it.
///
/// # Errors
/// The system has no thread to spare, or `work` panicked.
pub(crate) async fn at_leisure<R: Send + 'static>(work: impl FnOnce() -> R + Send + 'static) -> Result<R> {
    let (done, result) = oneshot::channel();
    start(move || {
        // The client may have gone.
        done.send(work()).ok();
    })
    .map_err(|error| Error::internal(&error))?;
    result.await.map_err(|error| Error::internal(&error))
}

/// Begins `work`, whose result is not waited for.
///
/// # Errors
/// The system has no thread to spare.
pub(crate) fn start(work: impl FnOnce() + Send + 'static) -> io::Result<()> {
    let give_way = || {
        // Without an id the priority is that of this thread alone, on Linux. Refused, the work is done all the same.
        let given_way = getpriority_process(None).and_then(|now| setpriority_process(None, now.max(NICE)));
        if let Err(error) = given_way {
            tracing::debug!(%error, "work that should give way has the priority of all");
        }
        work();
    };
    thread::Builder::new().name("at leisure".to_owned()).spawn(give_way).map(drop)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn only_the_work_itself_gives_way() {
        let before = getpriority_process(None).unwrap();
        let meanwhile = at_leisure(|| getpriority_process(None).unwrap()).await.unwrap();
        assert_eq!(meanwhile, before.max(NICE));
        assert_eq!(getpriority_process(None).unwrap(), before);
        let others = tokio::task::spawn_blocking(|| getpriority_process(None).unwrap()).await.unwrap();
        assert_eq!(others, before);
    }

    #[tokio::test]
    async fn work_that_panics_is_an_error() {
        let panicked: Result<()> = at_leisure(|| panic!("by intention")).await;
        assert!(panicked.is_err());
    }
}
