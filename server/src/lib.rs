//! The shore server: telemetry, history and control of a fleet from a browser.
//!
//! A thin asynchronous shell. What a packet means is decided in the cores below (`hub`, `store`, `link`); here
//! are sockets, pages, people and configuration. `main.rs` only starts it, so that tests can start it too.

mod backup;
mod charts;
pub mod cli;
pub mod clock;
pub mod config;
mod doctor;
mod doors;
mod folder;
mod http;
mod log;
mod owners;
mod pages;
mod people;
mod plans;
mod private;
mod relay;
mod shore;
mod sinks;
mod tls;

pub use http::serve::{Serving, serve, serve_by};
