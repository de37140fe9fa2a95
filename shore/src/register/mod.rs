//! The register of studies: projects, people, animals, tags, receivers and their deployments on vessels.
//!
//! The crate `research` validates entries; `rows` stores them in app.db, each change as a whole or not at all; `import`
//! determines the changes of a file; `service` has the access rules; `file` is for the command line. Earlier versions of an
//! entry stay in app.db.

mod file;
mod import;
mod rows;
mod service;
#[cfg(test)]
mod tests;

pub use file::TakeFile;
pub use rows::{All, Row, study};
pub use service::{Called, FILE_BYTES, Register};
