//! Motion control of a small catamaran with two motors.
//!
//! From a path to thrust: [`PathTracker`] keeps the geometry and progress of a path, [`Guidance`] turns it
//! into a desired course, [`CourseSpeed`] into two actuations. [`Remote`] does the same from the keys of an
//! operator. Everything is a pure state machine: states and times come in, decisions go out.
//!
//! SI units and radians throughout. Headings and courses turn clockwise from north; a course is where the
//! vessel goes, a heading where its bow points. Cross-track errors are positive to starboard of the track,
//! turning effort is positive to starboard.

mod circle;
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
mod speed_table;
mod thrust;
mod vector_field;

pub use circle::CircleConfig;
pub use course_speed::{
    ControlFault, ControlOutput, CourseSpeed, CourseSpeedConfig, Damping, Drive, FeedForward, Governor,
    OutputConfig, Setpoint, SpeedConfig, YawConfig, YawTarget,
};
pub use crab::CourseTracking;
pub use guidance::{Corridor, Guidance, GuidanceConfig, Law, Steering};
pub use ilos::{IlosConfig, IntegratorForm, OutsideCorridor};
pub use motion::Motion;
pub use path::{
    AlongTrackConfig, CirclePosition, CrossTrackConfig, Fix, Geometry, JumpConfig, Leg, LegPosition, Loiter,
    NearRule, PathCommand, PathConfig, PathEnd, PathError, PathEvent, PathFault, PathStart, PathStatus,
    PathTracker, TrackPosition, Turn, range_and_bearing,
};
pub use pid::{ErrorKind, FirstDerivative, Integration, Pid, PidConfig, PidTerms, Saturation};
pub use range::{InvalidConfig, OutOfRange};
pub use speed_table::{SpeedTable, SpeedTarget};
pub use thrust::{Allocation, EffortLimits, MotorPair, Sharing, ThrustMap, allocate};
pub use vector_field::{ExtendedField, VectorFieldConfig};
