//! The register of studies: projects, people, animals, tags, receivers and their deployments on vessels.
//!
//! What an entry may say is `research`'s; `rows` keeps entries in app.db, all of a change or nothing of it; `import` tells what a
//! file would change; `service` decides who may what; `file` is for the command line. What an entry said before stays in app.db.

mod file;
mod import;
mod rows;
mod service;
#[cfg(test)]
mod tests;

pub use file::TakeFile;
pub use rows::{All, Row, study};
pub use service::{Called, FILE_BYTES, Register};
