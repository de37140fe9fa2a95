//! The sea chart as a picture: vector tiles of the Web Mercator grid, and what is near a place.
//!
//! It knows the charts and what Mapbox's tile format is (version 2.1; extent 4096, buffer 64); it knows nothing of
//! files, HTTP or colours. Tiles are for looking: how deep it is answers [`charts::depth_index`] alone.
//!
//! - [`Sheet`] knows the charts of a set ([`SheetChart`]) and reads each when a tile touches it ([`SheetReader`]): so much
//!   of them is kept in memory as its maker says. Drawn is
//!   everywhere only the chart in force there, by [`charts::coverage`]. What a better chart covers is cut out
//!   of all others exactly; soundings from elsewhere (supplements) hide nothing and are hidden by nothing. This holds at
//!   every zoom: small zooms get the same places with fewer vertices, of overviews that are kept for each chart.
//! - Where a chart cannot be read nothing is drawn, as where there is no data, and [`Sheet::unreadable`] names it.
//! - [`Sheet::tile`] gives one tile. Geometry is clipped to the buffer and simplified by at most half a pixel. Soundings
//!   are thinned by a grid of the zoom in which the shallowest wins. From [`ALL_DANGERS`] on no danger is left out,
//!   however small.
//! - [`Sheet::near`] gives what is [`Near`] a place, and [`About`] what is known of it.

mod about;
mod cache;
mod clip;
mod cut;
mod draw;
mod layer;
mod mvt;
mod near;
mod overview;
mod piece;
mod shape;
mod sheet;
#[cfg(test)]
mod tests;
mod world;

pub use about::About;
pub use draw::{ALL_DANGERS, MOST_ZOOM, NoTile};
pub use near::Near;
pub use sheet::{Changed, Sheet, SheetChart, SheetReader, Unread};
