//! Electronic sea charts: read, checked and asked for depths.
//!
//! - [`iso8211`] is the container of S-57 files, [`s57`] the charts in them, read and written.
//! - [`demo`] makes a fictitious archipelago, [`tile`] pictures for maps.
//!
//! Positions of files are in degrees, as the files have them; distances are metres and angles radians.
//! Depths are metres below the chart's sounding datum, negative where it dries.
#![cfg_attr(test, expect(clippy::float_cmp, reason = "tests compare with values that are exact"))]

pub mod coverage;
mod crc32;
pub mod demo;
pub mod depth_index;
pub mod geojson;
mod grid;
pub mod iso8211;
pub mod s57;
pub mod utm;
pub mod xyz;
