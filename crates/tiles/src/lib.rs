//! The chart as a picture: vector tiles of the Web Mercator grid, and what is near a place.
//!
//! A [`Sheet`] is made once from the features of a chart set and holds them as they are drawn: everywhere only
//! those of the best source, by the same order as the depth index has (finer band, larger scale, newer issue).
//! What a finer source covers (M_COVR, CATCOV 1) is cut out of all coarser ones exactly; soundings from elsewhere
//! (supplements) hide nothing and are hidden by nothing. This holds at every zoom: small zooms get the same
//! places with fewer vertices.
//!
//! [`Sheet::tile`] gives a Mapbox vector tile (version 2.1; extent 4096, buffer 64). Geometry is clipped to the
//! buffer and simplified by at most half a pixel. Soundings are thinned by a grid of the zoom in which the
//! shallowest wins. From [`ALL_DANGERS`] on no danger is left out, however small.
//!
//! Tiles are for looking; how deep it is answers [`crate::depth_index`] alone.

mod clip;
mod cut;
mod draw;
mod layer;
mod mvt;
mod near;
mod sheet;
#[cfg(test)]
mod tests;
mod world;

pub use draw::{ALL_DANGERS, MOST_ZOOM, NoTile};
pub use near::Near;
pub use sheet::{About, Sheet, SheetSource};
