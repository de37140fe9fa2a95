//! Paths, speeds and progress as IMC has them.

use control::{Geometry, PathCommand, PathStart, PathStatus};
use imc::messages::{
    DesiredPath, DesiredPathFlags, DesiredSpeed, PathControlState, PathControlStateFlags, SpeedUnits, ZUnits,
};
use units::{Speed, Turn};

fn speed_units(speed: Speed) -> SpeedUnits {
    match speed {
        Speed::MetresPerSecond(_) => SpeedUnits::MetersPs,
        Speed::Rpm(_) => SpeedUnits::Rpm,
        Speed::Percent(_) => SpeedUnits::Percentage,
    }
}

/// The speed that is wanted.
pub(crate) fn desired_speed(speed: Speed) -> DesiredSpeed {
    DesiredSpeed { value: speed.value(), speed_units: speed_units(speed) }
}

/// The path that is followed from here on.
pub(crate) fn desired_path(command: &PathCommand, status: &PathStatus, speed: Speed) -> DesiredPath {
    let mut flags = DesiredPathFlags::empty();
    flags.set(DesiredPathFlags::START, matches!(command.start, PathStart::At(_)));
    flags.set(DesiredPathFlags::DIRECT, matches!(command.start, PathStart::Here));
    flags.set(
        DesiredPathFlags::CCLOCKW,
        command.loiter.is_some_and(|loiter| loiter.turn == Turn::CounterClockwise),
    );
    DesiredPath {
        path_ref: command.path_ref,
        start_lat: status.start.lat_rad(),
        start_lon: status.start.lon_rad(),
        start_z: 0.0,
        start_z_units: ZUnits::Depth,
        end_lat: status.end.lat_rad(),
        end_lon: status.end.lon_rad(),
        end_z: 0.0,
        end_z_units: ZUnits::Depth,
        speed: speed.value() as f32,
        speed_units: speed_units(speed),
        lradius: command.loiter.map_or(0.0, |loiter| loiter.radius_m as f32),
        flags,
    }
}

/// The progress on that path.
pub(crate) fn path_state(status: &PathStatus) -> PathControlState {
    let mut flags = PathControlStateFlags::empty();
    flags.set(PathControlStateFlags::NEAR, status.near);
    flags.set(PathControlStateFlags::LOITERING, status.loitering);
    flags.set(
        PathControlStateFlags::CCLOCKW,
        status.loiter.is_some_and(|loiter| loiter.turn == Turn::CounterClockwise),
    );
    let (sin, cos) = status.course_error_rad.sin_cos();
    let along_m = match status.geometry {
        Geometry::Leg(_) => status.left_m,
        Geometry::Circle(_) => 0.0,
    };
    PathControlState {
        path_ref: status.path_ref,
        start_lat: status.start.lat_rad(),
        start_lon: status.start.lon_rad(),
        start_z: 0.0,
        start_z_units: ZUnits::Depth,
        end_lat: status.end.lat_rad(),
        end_lon: status.end.lon_rad(),
        end_z: 0.0,
        end_z_units: ZUnits::Depth,
        lradius: status.loiter.map_or(0.0, |loiter| loiter.radius_m as f32),
        flags,
        x: along_m as f32,
        y: status.geometry.cross_m() as f32,
        z: 0.0,
        vx: (status.speed_mps * cos) as f32,
        vy: (status.speed_mps * sin) as f32,
        vz: 0.0,
        course_error: status.course_error_rad as f32,
        eta: status.eta_s,
    }
}
