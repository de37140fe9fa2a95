//! Motion control of a small catamaran with two motors.
//!
//! From a path to thrust: [`PathTracker`] keeps the geometry and progress of a path, [`Guidance`] turns it
//! into a desired course, [`CourseSpeed`] into two actuations. [`Remote`] does the same from the keys of an
//! operator. Everything is a pure state machine: states and times come in, decisions go out.
//!
//! SI units and radians throughout. Headings and courses turn clockwise from north; a course is where the
//! vessel goes, a heading where its bow points. Cross-track errors are positive to starboard of the track,
//! turning effort is positive to starboard.
//!
//! ```
//! use control::{
//!     CourseSpeed, CourseSpeedConfig, Fix, Guidance, GuidanceConfig, Motion, MotorPair, PathCommand, PathConfig,
//!     PathEnd, PathStart, PathTracker, Setpoint, YawTarget,
//! };
//! use units::{LatLon, MonoTime, Speed};
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let mut path = PathTracker::new(PathConfig::default())?;
//! let mut guidance = Guidance::new(GuidanceConfig::default())?;
//! let mut control = CourseSpeed::new(CourseSpeedConfig::default())?;
//!
//! // A new path, once.
//! let now = MonoTime::from_micros(0);
//! let motion = Motion::from_course(0.0, Some(0.0), 0.0, 0.0);
//! let fix = Fix { place: LatLon::from_deg(63.33, 10.0833)?, motion, variance_m2: None };
//! let end = PathEnd::At(LatLon::from_deg(63.34, 10.0833)?);
//! let command = PathCommand { path_ref: 1, start: PathStart::Here, end, loiter: None };
//! path.start(now, &command, &fix)?;
//! guidance.new_path();
//! control.enable(MotorPair::STOPPED);
//!
//! // At every fix.
//! let status = path.update(now, &fix, false)?;
//! let steering = guidance.steer(now, &status, &fix.motion);
//! let setpoint = Setpoint {
//!     yaw: Some(YawTarget::Course {
//!         course_rad: steering.course_rad,
//!         turn_rate_rad_s: steering.turn_rate_rad_s,
//!     }),
//!     speed: Some(Speed::MetresPerSecond(1.5)),
//! };
//! let output = control.update(now, &fix.motion, &setpoint, None)?;
//! assert_eq!(output.motors, MotorPair::STOPPED); // enabling goes on from there
//! # Ok(())
//! # }
//! ```
//!
//! It knows `units` only: no IMC, charts, plans or devices.

mod activity;
mod circle;
mod corridor;
mod course_speed;
mod crab;
mod guidance;
mod ilos;
mod motion;
mod path;
mod pid;
mod pure_pursuit;
mod ramp;
mod range;
mod remote;
mod speed_table;
mod steering;
mod thrust;
mod vector_field;

pub use activity::MotorActivity;
pub use circle::CircleConfig;
pub use corridor::Corridor;
pub use course_speed::{
    ControlFault, ControlOutput, CourseSpeed, CourseSpeedConfig, Damping, Drive, FeedForward, Governor,
    OutputConfig, Setpoint, SpeedConfig, YawConfig, YawTarget,
};
pub use crab::CourseTracking;
pub use guidance::{Guidance, GuidanceConfig, Law};
pub use ilos::{IlosConfig, IntegratorForm, OutsideCorridor};
pub use motion::Motion;
pub use path::{
    AlongTrackConfig, CirclePosition, CrossTrackConfig, Fix, Geometry, JumpConfig, Leg, LegPosition, Loiter,
    NearRule, PathCommand, PathConfig, PathEnd, PathError, PathEvent, PathFault, PathStart, PathStatus,
    PathTracker, TrackPosition, range_and_bearing,
};
pub use pid::{ErrorKind, FirstDerivative, Integration, Pid, PidConfig, PidTerms, Saturation};
pub use range::{InvalidConfig, OutOfRange};
pub use remote::{Mixing, REMOTE_ACTIONS, Remote, RemoteActions, RemoteCommand, RemoteConfig, RemoteReply};
pub use speed_table::SpeedTable;
pub use steering::Steering;
pub use thrust::{Allocation, EffortLimits, MotorPair, Sharing, ThrustMap, allocate};
pub use vector_field::{ExtendedField, VectorFieldConfig};
