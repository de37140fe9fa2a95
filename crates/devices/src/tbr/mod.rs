//! The lines of the Thelma Biotel hydrophone, byte for byte.
//!
//! Layout: as the DUNE task `Sensors.ThelmaHydrophone` reads it, and github.com/core-marine-dev/tb-live. Lines begin
//! with `$`, end in a carriage return alone and have no checksum. The data field of a coding without data is empty.
//! The running number counts both kinds of line and wraps at 16 bits.
//!
//! [`Framer`] finds lines in a stream, [`parse`] reads one, and the readings' `encode` write them.

mod framer;
mod parse;

pub use framer::{Framer, LONGEST};
pub use parse::{Ack, DamagedLine, Heard, Line, parse};

use crate::reading::{TagReading, WaterReading};

/// A receiver's clock that shows less (s) was never set and counts from power-up: this is September 2001, and no receiver
/// is on for thirty years.
pub const SET_AFTER_S: u32 = 1_000_000_000;

/// The coding of a tag's transmission.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[expect(missing_docs, reason = "the names are the manufacturer's and all there is to say")]
pub enum TagProtocol {
    R256,
    R04K,
    S64K,
    R64K,
    R01M,
    S256,
    HS256,
    DS256,
    OPi,
    OPs,
}

impl TagProtocol {
    /// All of them.
    pub const ALL: [Self; 10] = [
        Self::R256,
        Self::R04K,
        Self::S64K,
        Self::R64K,
        Self::R01M,
        Self::S256,
        Self::HS256,
        Self::DS256,
        Self::OPi,
        Self::OPs,
    ];

    /// The coding of a name in whatever case; `None` for one that is not known here, whose name is kept as text.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|known| known.name().eq_ignore_ascii_case(name))
    }

    /// The name the receiver writes.
    pub const fn name(self) -> &'static str {
        match self {
            Self::R256 => "R256",
            Self::R04K => "R04K",
            Self::S64K => "S64K",
            Self::R64K => "R64K",
            Self::R01M => "R01M",
            Self::S256 => "S256",
            Self::HS256 => "HS256",
            Self::DS256 => "DS256",
            Self::OPi => "OPi",
            Self::OPs => "OPs",
        }
    }

    /// The largest value of the data field; `None` where only an id is sent.
    pub const fn data_max(self) -> Option<u16> {
        match self {
            Self::R256 | Self::R04K | Self::R64K | Self::R01M | Self::OPi => None,
            Self::S64K => Some(u16::MAX),
            Self::S256 | Self::HS256 | Self::DS256 => Some(255),
            Self::OPs => Some(4095),
        }
    }
}

impl TagReading {
    /// The line that a receiver writes of it, from `$` to before the carriage return.
    pub fn line(&self) -> String {
        let Self {
            serial,
            clock_s,
            millis,
            protocol,
            tag_id,
            data,
            snr_db,
            frequency_khz,
            counter,
            raw: _,
            lines_lost: _,
        } = self;
        let data = data.map_or_else(String::new, |data| data.to_string());
        format!(
            "${serial:06},{clock_s:010},{millis:03},{protocol},{tag_id},{data},{snr_db},{frequency_khz},{counter}"
        )
    }

    /// The whole line, with the carriage return that ends it.
    pub fn encode(&self) -> Vec<u8> {
        format!("{}\r", self.line()).into_bytes()
    }
}

impl WaterReading {
    /// The whole line, from `$` to the carriage return.
    pub fn encode(&self) -> Vec<u8> {
        let Self {
            serial, clock_s, temperature_c, noise_average, noise_peak, frequency_khz, counter, ..
        } = self;
        let temperature = temperature_count(*temperature_c);
        format!(
            "${serial:06},{clock_s:010},TBR Sensor,{temperature},{noise_average},{noise_peak},{frequency_khz},{counter}\r"
        )
        .into_bytes()
    }
}

/// A temperature (°C) as the receiver sends it: whole tenths of a degree, within three digits.
pub fn rounded_temperature_c(temperature_c: f64) -> f64 {
    (f64::from(temperature_count(temperature_c)) - 50.0) / 10.0
}

/// Tenths of a degree above -5 °C, as the receiver counts.
fn temperature_count(temperature_c: f64) -> u16 {
    (temperature_c * 10.0 + 50.0).round().clamp(0.0, 999.0) as u16
}

#[cfg(test)]
mod tests;
