//! What browsers and scripts send to the server and get from it.
//!
//! One definition serves three readers: `serde` for the wire, `utoipa` for the OpenAPI document and, in tests,
//! `ts-rs` for `web/src/api/types.gen.ts`, which is committed and compared.
//!
//! Times are microseconds since 1970 UTC, as whole numbers that JavaScript holds exactly until the year 2255.
//! Angles are radians and lengths metres as in IMC, unless a name says otherwise; values carry their unit.

mod history;
mod live;
mod people;

pub use history::{ExportQuery, Recorded, TrackPoint, TrackQuery};
pub use live::{Field, Fix, LiveFrame, LiveRequest, Liveness, Subscription, System, Update};
pub use people::{AuditEntry, Me, NewToken, Permission, Person, Role, Session, Token, TokenMade, Vessel};

#[cfg(test)]
mod typescript;
