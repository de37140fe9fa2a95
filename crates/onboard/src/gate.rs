//! Manual control near danger: thrust towards it is blocked, way towards it is braked.

use control::MotorPair;

/// The limits of manual control by the sea chart.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Gate {
    /// Thrust ahead is blocked.
    pub(crate) ahead: bool,
    /// Thrust astern is blocked.
    pub(crate) astern: bool,
    /// Speed over ground in the direction of the bow (m/s), to brake against.
    pub(crate) surge_mps: f64,
}

/// Actuation that brakes for each m/s of way towards danger, and at most.
const BRAKE_PER_MPS: f64 = 0.5;
const MOST_BRAKE: f64 = 0.4;
/// Slower way is not braked (m/s).
const LEAST_BRAKED_MPS: f64 = 0.05;

impl Gate {
    /// The motors without thrust towards danger; turning is let through, and way towards danger is braked.
    pub(crate) fn pass(&self, motors: MotorPair) -> MotorPair {
        let (thrust, turn) =
            (f64::midpoint(motors.port, motors.starboard), (motors.port - motors.starboard) / 2.0);
        let brake = (BRAKE_PER_MPS * self.surge_mps.abs()).min(MOST_BRAKE);
        let brakes = self.surge_mps.abs() > LEAST_BRAKED_MPS;
        let thrust = match (self.ahead, self.astern) {
            (true, true) => 0.0,
            (true, false) if thrust >= 0.0 => {
                if brakes && self.surge_mps > 0.0 {
                    -brake
                } else {
                    0.0
                }
            }
            (false, true) if thrust <= 0.0 => {
                if brakes && self.surge_mps < 0.0 {
                    brake
                } else {
                    0.0
                }
            }
            _ => return motors,
        };
        let pair = |turn: f64| (thrust + turn).clamp(-1.0, 1.0);
        MotorPair { port: pair(turn), starboard: pair(-turn) }
    }
}
