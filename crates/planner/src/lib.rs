//! Routes on the sea chart: the shortest way from here to there that keeps to deep water and clear of dangers.
//!
//! A way is safe if the guard calls every leg of it safe, so the planner takes its geometry from where the guard takes
//! its own: the barriers of [`charts::depth_index`], the lines that no corridor may touch. What keeps so far from all of
//! them is [`SeaRoom`], divided once into triangles; in it a search over the sides of triangles finds the shortest way
//! of any angles in about a millisecond. Every leg is then asked of the depth index, and a way that it does not confirm
//! is never given.
//!
//! It knows charts, and neither vessels, plans, files nor the clock. It does one thing at a time on the thread that
//! asks; long work asks [`Cancel`] whether its answer is still wanted and its time is not used up.
//!
//! - [`Needs`] say how deep and how far off.
//! - [`Zones`] say where ways may lead beside that.
//! - [`Objective`] says what a route is good for where it is not the shortest: time or energy in a current ([`Currents`]),
//!   deeper water, more distance.
//! - [`Router`] holds a chart and the rooms made of it, and answers a [`Request`] by a [`Route`] or by a [`Refusal`]
//!   that says what is in the way.
//! - [`classic`] is a plain A* on a grid, to compare with.
//!
//! SI units and radians; places are WGS 84.

mod alternatives;
mod boxes;
mod cancel;
pub mod classic;
mod corridor;
mod currents;
mod joining;
mod known;
mod lattice;
mod long;
mod mesh;
mod nearby;
mod needs;
mod objective;
mod obstacles;
mod outermost;
mod pace;
mod parts;
mod passable;
mod plane;
mod portals;
mod refusal;
mod region;
mod room;
mod rooms;
mod route;
mod router;
mod sailing;
mod search;
mod side;
mod tidy;
mod tile;
mod turns;
mod walls;
mod weighed;
mod weighing;
mod zones;

pub use cancel::{Cancel, Progress};
pub use currents::{CurrentGrid, CurrentGridError, Currents, Flow};
pub use needs::{Needs, NeedsError};
pub use objective::{Aim, LegCost, Objective, Power, Preferences, SpeedLimit};
pub use passable::{Passable, PassableGap};
pub use plane::{Plane, Point};
pub use refusal::{End, Refusal, Spent};
pub use room::{PlanError, SeaRoom};
pub use route::{Moved, Request, Route, RouteLeg};
pub use router::Router;
pub use search::Effort;
pub use turns::{Turn, TurnTrouble};
pub use zones::{Zone, ZoneError, Zones};
