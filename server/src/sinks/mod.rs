//! Other stores that follow the archive, beside the history. Each remembers how far it got, so that one that is
//! away, slow or new gets everything once it is there, and none of them holds up recording.

pub(crate) mod influx;
