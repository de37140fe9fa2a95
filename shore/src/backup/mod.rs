//! A backup of everything, and its way back.
//!
//! A backup is a folder with the files of a data folder and `manifest`, which names each with its length and digest.
//! [`make`] writes it, also while a server runs, and [`restore`] makes a data folder of it: all or nothing, and only
//! what is as it was copied.

mod make;
mod manifest;
mod restore;

pub use make::make;
pub use restore::restore;
