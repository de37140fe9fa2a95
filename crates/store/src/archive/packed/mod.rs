//! Compressed files of days to which nothing is added.
//!
//! `Data.lsf.zst` is the log as independent zstd frames with a seek table at its end (the *zstd seekable format*, version
//! 0.1.0, in `contrib/seekable_format` of zstd), so `zstd -dc Data.lsf.zst > ELSEWHERE/Data.lsf` makes the plain log of it.
//! `Arrivals.zst` holds the records of arrival the same way; the contents of its frames are columns ([`columns`]) and not
//! the records themselves. A skippable frame at the start, the [`table::Head`], has length and SHA-256 of the plain file.
//!
//! Places in the archive always count bytes of the plain file, in either form. Such a file is made once, read back
//! against the plain one, and never changed; what still comes for its day goes to a further part ([`super::DayKey`]).

mod columns;
mod file;
mod table;
mod walk;
mod writer;

pub use file::Packed;
pub(crate) use file::PackedReader;
pub(crate) use table::{Coding, FRAME_BYTES};
pub(crate) use writer::{Packer, Turn};
