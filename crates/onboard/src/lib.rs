//! The brain of a vessel.
mod authority;
mod bus;
mod entity;
mod input;
mod navigation;
mod node;
mod output;
mod settings;
pub use authority::*;
pub use entity::*;
pub use input::*;
pub use navigation::*;
pub use output::*;
pub use settings::*;
