//! The events of maneuvers: the vessel's position, its path's progress, messages of others.

use units::LatLon;
use units::Speed;

/// An event of interest to the active maneuver.
#[derive(Debug, Clone, PartialEq)]
pub enum Event {
    /// A position and motion estimate.
    Fix(Fix),
    /// How the path under way goes.
    Path(PathProgress),
    /// The path was refused or abandoned by path control.
    PathFailed {
        /// Its number.
        path_ref: u32,
        /// Why, for people.
        reason: String,
    },
    /// A commander's wish for the maneuver FollowReference.
    Reference(Reference),
    /// Another system reported its position.
    Sighting(Sighting),
    /// The medium that the vessel is in.
    Medium(Medium),
    /// A way that the maneuver FollowReference requested.
    Way(Way),
    /// Control ashore has changed hands: requests of the previous holder that were not begun are dropped.
    CommanderChanged,
    /// An operator ended the teleoperation.
    TeleoperationDone {
        /// Address of the sender.
        from: u16,
    },
}

/// Where the vessel is and how it moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fix {
    /// Position.
    pub place: LatLon,
    /// Where the bow points (rad).
    pub heading_rad: f64,
    /// Speed over ground (m/s).
    pub speed_mps: f64,
    /// How uncertain the position is: its standard deviation on each axis (m).
    pub sigma_m: f64,
    /// Water below the vessel (m), where measured.
    pub water_below_m: Option<f64>,
}

/// How a path goes, as path control reports it about once per second and at once when near.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathProgress {
    /// Which path. Reports of older ones are ignored.
    pub path_ref: u32,
    /// The end is near.
    pub near: bool,
    /// The vessel is on the circle around the end.
    pub loitering: bool,
    /// Distance left along the path (m).
    pub left_m: f64,
    /// Distance from the path, positive to starboard (m).
    pub cross_m: f64,
    /// Time to arrival (s).
    pub eta_s: f64,
}

/// A commander's wish. What is absent stays as the reference before had it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reference {
    /// Address of the commander.
    pub system: u16,
    /// Entity of the commander.
    pub entity: u8,
    /// Where to be (flag LOCATION).
    pub location: Option<LatLon>,
    /// Where the track starts (flag START_POINT), until a reference says `direct`.
    pub start_point: Option<LatLon>,
    /// How fast (flag SPEED); 0 stops.
    pub speed: Option<Speed>,
    /// How far from the place is near enough (m, flag RADIUS).
    pub radius_m: Option<f64>,
    /// Go straight from where the vessel is (flag DIRECT).
    pub direct: bool,
    /// The maneuver is over (flag MANDONE).
    pub done: bool,
}

/// The result of a search for a way.
#[derive(Debug, Clone, PartialEq)]
pub struct Way {
    /// The place that it was to lead to.
    pub to: LatLon,
    /// Its corners from where the vessel was, or why no way was found.
    pub places: Result<Vec<LatLon>, String>,
}

/// Where another system is, from its announcement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sighting {
    /// Its address.
    pub system: u16,
    /// Its place.
    pub place: LatLon,
    /// Whether it is something afloat rather than a console.
    pub afloat: bool,
}

/// The medium that the vessel is in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Medium {
    /// On land.
    Ground,
    /// In the air.
    Air,
    /// Afloat.
    Water,
    /// Submerged.
    Underwater,
    /// Not known.
    Unknown,
}
