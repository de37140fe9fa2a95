//! Logs in LSF: packets back to back, without header, index or separators.
//!
//! A log is a folder `<base>/<YYYYMMDD>/<HHMMSS>[_<label>]/` in UTC that holds `Data.lsf` or `Data.lsf.gz`,
//! the definitions it was written by (`IMC.xml.gz`), the configuration and the console's text. Neptus MRA
//! opens a folder with the first two. Packets are in order of arrival; their times step back a little,
//! and a log may begin with older, remembered messages.

mod definitions;
mod gunzip;
mod index;
mod reader;
mod writer;

pub use definitions::definitions_xml;
pub use index::Index;
pub use reader::{LogItem, LogReader};
pub use writer::{LogOptions, LogWriter, folder_name};
