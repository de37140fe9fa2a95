//! The web server: who may come in, what is where, and how answers look.

pub(crate) mod alarms;
#[cfg(test)]
mod alarms_tests;
#[cfg(test)]
mod ashore_aboard_tests;
mod assets;
#[cfg(test)]
mod browser_tests;
mod charts;
#[cfg(test)]
mod charts_tests;
#[cfg(test)]
mod commands_tests;
mod connections;
mod control;
#[cfg(test)]
mod control_tests;
mod csrf;
mod download;
mod error;
mod export;
#[cfg(test)]
mod export_tests;
mod extract;
#[cfg(test)]
mod grounding_tests;
pub(crate) mod guard;
mod headers;
mod health;
mod history;
#[cfg(test)]
mod history_tests;
#[cfg(test)]
mod hostile_tests;
#[cfg(test)]
mod import_tests;
mod imports;
mod listen;
mod live;
#[cfg(test)]
mod live_tests;
mod logbook;
#[cfg(test)]
mod logbook_tests;
mod measure;
mod missions;
#[cfg(test)]
mod missions_tests;
mod openapi;
pub(crate) mod outgoing;
mod people;
mod plans;
#[cfg(test)]
mod plans_tests;
mod remote;
#[cfg(test)]
mod reports_tests;
mod route;
mod routes;
pub(crate) mod serve;
#[cfg(test)]
mod serve_tests;
mod slow_bodies;
#[cfg(test)]
mod stop_tests;
mod teleop;
#[cfg(test)]
mod teleop_tests;
#[cfg(test)]
pub(crate) mod testing;
#[cfg(test)]
mod tests;
mod transports;
#[cfg(test)]
mod transports_tests;

pub(crate) use assets::path as asset_path;
pub(crate) use remote::Remote;

pub(crate) use error::ApiError;
pub(crate) use guard::{OfVessel, SESSION_COOKIE, Who, cookie, cookie_name, plain_cookie};
pub(crate) use plans::seen_plan;
pub(crate) use route::{Kind, Need, Route};
