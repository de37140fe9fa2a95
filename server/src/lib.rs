//! The shore server: telemetry, history and control of a fleet from a browser.
//!
//! Adapters only: sockets, pages, the command line and configuration around the services of [`shore`]. Packets are
//! interpreted in the core crates below. `main.rs` only starts it, so that tests can start it too.
//!
//! `serve` starts a server from a `Config` and returns a `Serving`; `cli` is its command line; `http::routes` and `pages`
//! list every route, and `web` is the middleware before them. It uses every service of the shore and owns no state that
//! commands a vessel.

mod backups;
pub mod cli;
pub mod config;
mod doctor;
mod http;
mod log;
mod pages;
mod retention;
mod serve;
mod state;
mod tls;
mod transports;
mod web;

pub use serve::{Serving, serve, serve_by};
pub(crate) use state::AppState;
