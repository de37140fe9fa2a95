//! Backup of all data, and restore.
//!
//! A backup is a folder with the files of a data folder and `manifest`, which names each with its length and digest.
//! [`make`] writes it, also while a server runs and into the folder of an earlier one, which `keeping` leaves intact until
//! the new one is complete; [`Held`] checks the contents of one; [`restore`] makes a data folder of it: all or nothing, and
//! only of undamaged files.

mod forms;
mod held;
mod keeping;
mod make;
mod manifest;
mod restore;

pub use held::{Held, asides};
pub use keeping::{Aside, BackedUp};
pub use make::make;
pub use restore::restore;

#[cfg(test)]
mod tests;
