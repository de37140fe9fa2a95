//! The web server: who may come in, what is where, and how answers look.

mod headers;
mod health;
mod listen;
mod measure;
mod routes;
pub(crate) mod serve;
