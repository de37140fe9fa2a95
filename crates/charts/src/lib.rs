//! Electronic sea charts: read, checked and asked for depths.
//!
//! It knows the chart's formats and the Earth; it knows neither vessels nor plans, and nothing of disks, pictures or
//! HTTP: files come as bytes.
//!
//! - [`s57::Cell`] is a chart: a base cell with its updates, read from the container [`iso8211`]; [`s57::write`] makes
//!   such files, [`demo`] a fictitious archipelago of them. [`xyz`] and [`utm`] read soundings.
//! - [`coverage::Coverage`] says which chart is in force where.
//! - [`depth_index::DepthIndex`] answers how deep it is, with the object that decides and the margin.
//!
//! Positions of files are in degrees, as the files have them; distances are metres and angles radians.
//! Depths are metres below the chart's sounding datum, negative where it dries.
#![cfg_attr(test, expect(clippy::float_cmp, reason = "tests compare with values that are exact"))]

pub mod coverage;
pub mod demo;
pub mod depth_index;
mod grid;
pub mod iso8211;
pub mod s57;
pub mod utm;
pub mod xyz;
