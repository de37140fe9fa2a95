//! Quantities, angles, time and places that all of Lutra shares.
//!
//! Everything is SI and radians; degrees exist only at wires, files and screens. Headings and courses turn
//! clockwise from north. The types are small, `Copy` and free of input and output.
//!
//! It knows nothing else of Lutra. Main types: `LatLon` and `LocalFrame` (places), `MonoTime`, `UtcTime` and `Now` (time),
//! `Speed`.

mod angle;
mod geodesy;
mod place;
mod speed;
mod time;
mod turn;

pub use angle::{wrap_pi, wrap_two_pi};
pub use geodesy::{Ecef, Geodetic, WGS84_ECCENTRICITY_SQUARED, WGS84_FLATTENING, WGS84_SEMI_MAJOR_M};
pub use place::{LatLon, LocalFrame, LocalPoint, PlaceError};
pub use speed::Speed;
pub use time::{Civil, MonoTime, NoTime, Now, UtcTime};
pub use turn::Turn;
