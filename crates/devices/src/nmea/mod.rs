//! NMEA 0183 (IEC 61162-1) as GNSS compasses speak it: the sentences written, read, and gathered into epochs.
//!
//! [`Sentence`] writes what a Hemisphere V104s sends, byte for byte. [`Framer`] finds sentences in a stream, [`read`]
//! makes a [`Report`] of one, and [`Epochs`] gathers the reports of one moment. Values that a receiver does not have are
//! empty fields: they are `None` here, never zero. Angles are radians, headings and courses clockwise from north in
//! [0, 2π), speeds m/s, heights m.

mod damage;
mod encode;
mod epoch;
mod fields;
mod framer;
mod report;

pub use damage::DamagedSentence;
pub use encode::{EarthModel, Sentence, Talker};
pub use epoch::{Epoch, Epochs};
pub use fields::TimeOfDay;
pub use framer::{Framer, LONGEST};
pub use report::{Attitude, DateTime, Errors, Kind, Minimum, Position, Precision, Report, read};

#[cfg(test)]
mod tests;
