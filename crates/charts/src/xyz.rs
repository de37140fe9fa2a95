//! Soundings as text: one `x y z` a line, as Kartverket and survey software write them.
//!
//! x is easting and y northing in UTM, z the depth in metres, positive down. Blanks, tabs, commas or
//! semicolons separate; empty lines and lines that begin with `#` are passed over.

use crate::s57::{GeoPoint, Sounding};
use crate::utm::{Utm, UtmError, UtmPoint};

/// Depths beyond this are not depths on Earth (m).
const DEEPEST_M: f64 = 12_000.0;
/// Heights beyond this are not drying heights (m).
const HIGHEST_M: f64 = 100.0;

/// Which way z counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Vertical {
    /// z is a depth, positive down.
    #[default]
    DepthDown,
    /// z is a height, positive up.
    HeightUp,
}

/// A line that is not a sounding.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("line {line} at byte {offset}: {problem}")]
pub struct XyzError {
    /// Line, counted from 1.
    pub line: usize,
    /// Byte at which it starts.
    pub offset: usize,
    /// What is wrong.
    pub problem: XyzProblem,
}

/// What is wrong with a line.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum XyzProblem {
    /// Not three numbers.
    #[error("it holds no three numbers x y z; give plain text with one sounding a line")]
    Numbers,
    /// Not in the zone.
    #[error(transparent)]
    Place(#[from] UtmError),
    /// No depth of the sea.
    #[error("z = {0} m is not a depth of the sea; check the order x y z and which way z counts")]
    Depth(f64),
}

/// Reads all soundings.
///
/// # Errors
/// At the first line that is not valid: a survey with a wrong line is not half read.
pub fn read(bytes: &[u8], utm: Utm, vertical: Vertical) -> Result<Vec<Sounding>, XyzError> {
    let mut soundings = Vec::new();
    let mut offset = 0;
    for (at, line) in bytes.split(|byte| *byte == b'\n').enumerate() {
        let fail = |problem| XyzError { line: at + 1, offset, problem };
        let text = line.trim_ascii();
        if !text.is_empty() && text[0] != b'#' {
            let text = std::str::from_utf8(text).map_err(|_| fail(XyzProblem::Numbers))?;
            soundings.push(sounding(text, utm, vertical).map_err(fail)?);
        }
        offset += line.len() + 1;
    }
    Ok(soundings)
}

fn sounding(text: &str, utm: Utm, vertical: Vertical) -> Result<Sounding, XyzProblem> {
    let separates = |c: char| c.is_ascii_whitespace() || matches!(c, ',' | ';');
    let mut numbers = text.split(separates).filter(|part| !part.is_empty()).map(str::parse::<f64>);
    let mut next = || numbers.next().and_then(Result::ok).filter(|one| one.is_finite());
    let (Some(easting_m), Some(northing_m), Some(z)) = (next(), next(), next()) else {
        return Err(XyzProblem::Numbers);
    };
    let depth_m = if vertical == Vertical::DepthDown { z } else { -z };
    if !(-HIGHEST_M..=DEEPEST_M).contains(&depth_m) {
        return Err(XyzProblem::Depth(z));
    }
    let place = utm.to_place(UtmPoint { easting_m, northing_m })?;
    Ok(Sounding { at: GeoPoint { lon_deg: place.lon_deg(), lat_deg: place.lat_deg() }, depth_m })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_soundings_of_zone_33_at_munkholmen() {
        let utm = Utm::from_epsg(25833).unwrap();
        let text = b"# survey\r\n269927.5527 7044215.8950 12.4\r\n\r\n269927.5527;7044215.8950;-0.3";
        let soundings = read(text, utm, Vertical::DepthDown).unwrap();
        assert_eq!(soundings.len(), 2);
        assert!((soundings[0].at.lon_deg - 10.3834).abs() < 4e-9);
        assert!((soundings[0].at.lat_deg - 63.4517).abs() < 2e-9);
        assert_eq!((soundings[0].depth_m, soundings[1].depth_m), (12.4, -0.3));
        assert_eq!(read(text, utm, Vertical::HeightUp).unwrap()[1].depth_m, 0.3);
    }

    #[test]
    fn names_the_line_that_is_none() {
        let utm = Utm::from_epsg(25833).unwrap();
        let fails = |text: &[u8]| read(text, utm, Vertical::DepthDown).unwrap_err().to_string();
        assert!(fails(b"269927 7044215 1\n269927 x 3").starts_with("line 2 at byte 17: it holds no three"));
        assert!(fails(b"7044215 269927 3").contains("check the order"));
        assert!(fails(b"269927 7044215 7044215").contains("not a depth"));
        assert!(fails(b"269927 7044215 nan").contains("no three numbers"));
    }
}
