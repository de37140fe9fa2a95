//! Routes on the sea chart: the shortest way from here to there that keeps to deep water and clear of dangers.
//!
//! A way is safe if the guard calls every leg of it safe, so the planner takes its geometry from where the guard takes
//! its own: the barriers of [`charts::depth_index`], the lines that no corridor may touch. What keeps so far from all of
//! them is [`SeaRoom`], divided once into triangles; in it a search over the sides of triangles finds the shortest way
//! of any angles in about a millisecond. Every leg is then asked of the depth index, and a way that it does not confirm
//! is never given.
//!
//! How it comes to a route:
//!
//! 1. The lines of the depth index are widened by the clearance and cut out of the region, with the borders of [`Zones`];
//!    for wide clearances the lines that cannot lie at the edge of open water are left out (`outermost`). What is left
//!    is divided into triangles (`room`), and `rooms` keeps it in memory, up to 80 MiB. It is not kept on disk: a region is ready
//!    in less than a second, and a file would have to be proved to be of this very chart.
//! 2. Where a region would hold too much chart, the water is looked at in tiles of 20 km (`tile`). Of each only the openings in
//!    its borders and the ways between them are kept (`portals`, `known`: 16 MiB). A search over them finds the corridor of
//!    tiles (`corridor`), whose water is prepared as one room (`long`). The answer says where other water could hold a shorter way,
//!    and that there is no way only where all water around an end was looked at.
//! 3. Where an [`Objective`] asks for less time or energy, or prefers water, `weighing` looks over a `lattice` of points for a
//!    cheaper way; `weighed` takes it only if it costs less than the shortest one. `Route::reckon` alone says what time and energy a
//!    route takes.
//!    Lanes and zones of ordered traffic ([`TrafficArea`]) are minded so too; where the shortest way meets none it is the answer.
//! 4. Each leg is asked of the depth index, and so are the arcs of its turns (`turns`). `alternatives` pass what the shortest
//!    route passes on its other side.
//! 5. Where there is no route, a smaller depth or clearance that gives one is looked for: first among the chart's lines
//!    (`walls`, `joining`), then by a way between them that the chart confirms (`lead`), or by preparing the least water that could
//!    hold one (`passable`).
//!
//! It knows charts, and neither vessels, plans, files nor the clock. It does one thing at a time on the thread that
//! asks; long work asks [`Cancel`] whether its answer is still wanted and its time is not used up.
//!
//! - [`Needs`] say how deep and how far off.
//! - [`Zones`] say where ways may lead beside that.
//! - [`Objective`] says what a route is good for where it is not the shortest: time or energy in a current ([`Currents`]),
//!   deeper water, more distance, no ordered traffic ([`TrafficArea`]).
//! - [`Router`] holds a chart and the rooms made of it, and answers a [`Request`] by a [`Route`] or by a [`Refusal`]
//!   that says what is in the way.
//! - [`classic`] is a plain A* on a grid, of one cell size or of several, to compare with.
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
mod landmarks;
mod lattice;
mod lead;
mod learned;
mod limits;
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
mod traffic;
mod turns;
mod walls;
mod weighed;
mod weighing;
mod zones;

pub use cancel::{Cancel, Progress};
pub use currents::{CurrentGrid, CurrentGridError, Currents, Flow, MOST_CURRENT_MPS, MOST_GRID_VALUES};
pub use needs::{Needs, NeedsError};
pub use objective::{Aim, LegCost, Objective, Power, Preferences, SpeedLimit};
pub use passable::{Passable, PassableGap};
pub use plane::{Plane, Point};
pub use refusal::{End, Refusal, Spent};
pub use room::{PlanError, SeaRoom};
pub use rooms::Prepared;
pub use route::{Moved, Narrow, Request, Route, RouteLeg};
pub use router::Router;
pub use search::Effort;
pub use traffic::{InTraffic, TrafficArea, TrafficKind};
pub use turns::{Turn, TurnTrouble};
pub use zones::{MOST_BORDER_KM, MOST_MARGIN_M, Zone, ZoneError, Zones};
