//! From demanded surge and yaw effort to two motors.
//!
//! - [`MotorPair`]: actuation of port (thruster 0) and starboard (thruster 1), -1 (full astern) to 1.
//! - [`allocate`]: common and differential effort shared between the motors within their limits.
//! - [`ThrustMap`]: force against actuation, strictly rising, each direction the inverse of the other.
//!
//! Forces are those of the *pair* with both motors at the same actuation (newtons), as in NTNU's files: a
//! motor commanded to F gives F/2. So common is the surge force, and differential times the lever arm of one
//! motor (0.395 m on the Otter) the yaw moment, positive to starboard.
//!
//! The published pair of fits for the real boat (NTNU dune-otter-public, HeadingAndSpeedForce) is not used
//! both ways: its map from actuation to force has the wrong sign near zero and falls off near full ahead, so
//! it is not an inverse of the other. Here the cubic from force to actuation, which is strictly rising on both
//! sides, is the one truth and the way back is solved from it.

/// Actuation of both motors, each -1 (full astern) to 1 (full ahead).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct MotorPair {
    /// Port motor, thruster 0.
    pub port: f64,
    /// Starboard motor, thruster 1.
    pub starboard: f64,
}

impl MotorPair {
    /// Both motors stopped.
    pub const STOPPED: Self = Self { port: 0.0, starboard: 0.0 };

    /// Both values through `f`.
    #[must_use]
    pub fn map(self, mut f: impl FnMut(f64) -> f64) -> Self {
        Self { port: f(self.port), starboard: f(self.starboard) }
    }

    /// Each value of `self` with its counterpart of `other` through `f`.
    #[must_use]
    pub fn zip(self, other: Self, mut f: impl FnMut(f64, f64) -> f64) -> Self {
        Self { port: f(self.port, other.port), starboard: f(self.starboard, other.starboard) }
    }

    /// Half the sum: what pushes.
    pub fn common(self) -> f64 {
        f64::midpoint(self.port, self.starboard)
    }
}

/// The effort one motor can give, in the unit of the allocation (actuation or newtons).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EffortLimits {
    /// Full astern, not above 0.
    pub astern: f64,
    /// Full ahead, not below 0.
    pub ahead: f64,
}

/// Which effort yields when a motor saturates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Sharing {
    /// Turning comes first: the common part shrinks towards zero, but never grows nor changes sign; then the
    /// differential shrinks too.
    #[default]
    TurnFirst,
    /// Each motor is limited separately.
    Independent,
}

/// The result of [`allocate`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Allocation {
    /// Effort of the two motors.
    pub motors: MotorPair,
    /// The common part that remained.
    pub common: f64,
    /// The differential part that remained.
    pub differential: f64,
}

/// Shares port = common + differential and starboard = common - differential within the limits of a motor.
/// NaN counts as 0.
pub fn allocate(common: f64, differential: f64, limits: EffortLimits, sharing: Sharing) -> Allocation {
    let zero_if_nan = |value: f64| if value.is_nan() { 0.0 } else { value };
    let (astern, ahead) = (limits.astern.min(0.0), limits.ahead.max(0.0));
    let common = zero_if_nan(common).clamp(astern, ahead);
    let differential = zero_if_nan(differential);
    match sharing {
        Sharing::TurnFirst => {
            let room = if common >= 0.0 { ahead.min(common - astern) } else { (-astern).min(ahead - common) };
            let differential = differential.clamp(-room, room);
            let turn = differential.abs();
            let common = if common >= 0.0 { common.min(ahead - turn) } else { common.max(astern + turn) };
            let motors = MotorPair { port: common + differential, starboard: common - differential }
                .map(|effort| effort.clamp(astern, ahead));
            Allocation { motors, common, differential }
        }
        Sharing::Independent => {
            let motors = MotorPair { port: common + differential, starboard: common - differential }
                .map(|effort| effort.clamp(astern, ahead));
            let differential = motors.port / 2.0 - motors.starboard / 2.0;
            Allocation { motors, common: motors.common(), differential }
        }
    }
}

/// Force of the motor pair (N) against actuation. Strictly rising; both directions agree.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ThrustMap {
    /// A propeller whose speed follows the actuation and whose force is k·n·|n|: F = F_max·a·|a|.
    Quadratic {
        /// Force at actuation 1 (N), above 0.
        ahead_n: f64,
        /// Magnitude of the force at actuation -1 (N), above 0.
        astern_n: f64,
    },
    /// Cubics from force (N) to actuation, one for each direction: a = c1·F + c2·F² + c3·F³, with F the
    /// magnitude of the force and a that of the actuation.
    Cubic {
        /// Coefficients c1, c2, c3 ahead (1/N, 1/N², 1/N³).
        ahead: [f64; 3],
        /// The same astern.
        astern: [f64; 3],
        /// Largest force ahead (N) to be asked for.
        ahead_n: f64,
        /// Largest magnitude of force astern (N) to be asked for.
        astern_n: f64,
    },
}

impl ThrustMap {
    /// Fossen's Otter (MSS otter.m): k_pos n_max² and k_neg n_min² of two propellers, n_max 103.93 rad/s
    /// and n_min -101.74 rad/s.
    pub const FOSSEN_OTTER: Self = Self::Quadratic { ahead_n: 239.364, astern_n: 133.417 };

    /// The fit to the real boat (NTNU dune-otter-public, HeadingAndSpeedForce), cut at its own force limits;
    /// astern the fit reaches actuation -1 at 139.4 N, and the source asks for at most 135 N.
    pub const NTNU_OTTER: Self = Self::Cubic {
        ahead: [0.011_37, -7.549e-5, 1.86e-7],
        astern: [0.019_12, -2.268e-4, 1.012e-6],
        ahead_n: 239.364,
        astern_n: 135.0,
    };

    /// Smallest and largest force to be asked for (N).
    pub fn limits(&self) -> EffortLimits {
        let (Self::Quadratic { ahead_n, astern_n } | Self::Cubic { ahead_n, astern_n, .. }) = *self;
        EffortLimits { astern: -astern_n, ahead: ahead_n }
    }

    /// The actuation, -1 to 1, that gives `force_n`; forces beyond the limits give the actuation there.
    pub fn actuation_for(&self, force_n: f64) -> f64 {
        if force_n.is_nan() {
            return 0.0;
        }
        let limits = self.limits();
        let force_n = force_n.clamp(limits.astern, limits.ahead);
        let magnitude = match self {
            Self::Quadratic { ahead_n, astern_n } => {
                (force_n.abs() / if force_n < 0.0 { astern_n } else { ahead_n }).sqrt()
            }
            Self::Cubic { ahead, astern, .. } => {
                cubic(if force_n < 0.0 { astern } else { ahead }, force_n.abs())
            }
        };
        magnitude.min(1.0).copysign(force_n)
    }

    /// The force (N) that `actuation` gives, within the limits.
    pub fn force_at(&self, actuation: f64) -> f64 {
        if actuation.is_nan() {
            return 0.0;
        }
        let actuation = actuation.clamp(-1.0, 1.0);
        let limits = self.limits();
        let strongest_n = if actuation < 0.0 { -limits.astern } else { limits.ahead };
        let magnitude_n = match self {
            Self::Quadratic { .. } => strongest_n * actuation * actuation,
            Self::Cubic { ahead, astern, .. } => {
                let coefficients = if actuation < 0.0 { astern } else { ahead };
                solve_cubic(coefficients, actuation.abs(), strongest_n)
            }
        };
        magnitude_n.copysign(actuation)
    }

    pub(crate) fn check(&self, check: &mut crate::range::RangeCheck) {
        let limits = self.limits();
        check.number("ahead", "N", limits.ahead, 1.0..=1e5);
        check.number("astern", "N", -limits.astern, 1.0..=1e5);
        if let Self::Cubic { ahead, astern, ahead_n, astern_n } = self {
            for (name, coefficients, strongest_n) in
                [("ahead_slope", ahead, ahead_n), ("astern_slope", astern, astern_n)]
            {
                check.number(name, "1/N", least_slope(coefficients, *strongest_n), 1e-9..=1e3);
            }
        }
    }
}

fn cubic([c1, c2, c3]: &[f64; 3], x: f64) -> f64 {
    x * (c1 + x * (c2 + x * c3))
}

/// The smallest slope of the cubic between 0 and `end`: a parabola, least at an end or at its vertex.
fn least_slope([c1, c2, c3]: &[f64; 3], end: f64) -> f64 {
    let slope = |x: f64| c1 + x * (2.0 * c2 + x * 3.0 * c3);
    let vertex = -c2 / (3.0 * c3);
    let inside = if vertex > 0.0 && vertex < end { slope(vertex) } else { slope(0.0) };
    inside.min(slope(0.0)).min(slope(end))
}

/// Where the rising cubic reaches `value` within 0 to `end`, by halving the interval.
fn solve_cubic(coefficients: &[f64; 3], value: f64, end: f64) -> f64 {
    let (mut low, mut high) = (0.0, end);
    if value <= 0.0 {
        return 0.0;
    }
    if cubic(coefficients, end) <= value {
        return end;
    }
    // 60 halvings: below 1e-15 of the range.
    for _ in 0..60 {
        let middle = f64::midpoint(low, high);
        if cubic(coefficients, middle) < value {
            low = middle;
        } else {
            high = middle;
        }
    }
    f64::midpoint(low, high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const UNIT: EffortLimits = EffortLimits { astern: -1.0, ahead: 1.0 };
    const MAPS: [ThrustMap; 2] = [ThrustMap::FOSSEN_OTTER, ThrustMap::NTNU_OTTER];

    fn table(kind: &str) -> Vec<(f64, f64)> {
        let Some(path) = testkit::shared("data/onboard/otter_thrust_map.csv") else { return Vec::new() };
        let text = std::fs::read_to_string(path).unwrap();
        let rows = text.lines().map(|line| line.split(',').collect::<Vec<_>>());
        rows.filter(|row| row[0] == kind)
            .map(|row| (row[1].parse().unwrap(), row[2].parse().unwrap()))
            .collect()
    }

    #[test]
    fn follows_the_published_force_to_actuation_fit_within_its_limits() {
        for (force_n, actuation) in table("force_to_act") {
            let got = ThrustMap::NTNU_OTTER.actuation_for(force_n);
            if (-135.0..=239.364).contains(&force_n) {
                assert!((got - actuation).abs() < 1e-6, "{force_n} N: {got}, table {actuation}");
            } else {
                assert!(got.abs() <= actuation.abs().min(1.0));
            }
        }
    }

    #[test]
    fn agrees_roughly_with_the_published_way_back_where_that_rises() {
        // The two published fits differ by up to 18 N of 240 N; the ends and the sign error near 0 are theirs.
        for (actuation, force_n) in table("act_to_force") {
            let got = ThrustMap::NTNU_OTTER.force_at(actuation);
            if (-0.6..=0.8).contains(&actuation) {
                assert!((got - force_n).abs() < 18.0, "{actuation}: {got} N, table {force_n} N");
            }
        }
    }

    #[test]
    fn fossens_otter_gives_its_bollard_forces() {
        let map = ThrustMap::FOSSEN_OTTER;
        // k n|n| of two propellers at half of n_max: a quarter of the force.
        assert!((map.force_at(0.5) - 239.364 / 4.0).abs() < 1e-9);
        assert!((map.force_at(-1.0) + 133.417).abs() < 1e-9);
        assert!((map.actuation_for(1e9) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn refuses_a_map_that_does_not_rise() {
        let mut check = crate::range::RangeCheck::default();
        ThrustMap::Cubic {
            ahead: [0.01, -1e-3, 1e-7],
            astern: [0.01, 0.0, 0.0],
            ahead_n: 200.0,
            astern_n: 90.0,
        }
        .check(&mut check);
        assert_eq!(check.finish().unwrap_err().problems.len(), 1);
    }

    #[test]
    fn turning_first_gives_up_speed_and_never_reverses_it() {
        // common, differential -> port, starboard
        for (common, differential, port, starboard) in [
            (0.5, 0.2, 0.7, 0.3),
            (0.9, 0.3, 1.0, 0.4),
            (0.9, -0.3, 0.4, 1.0),
            (0.0, 3.0, 1.0, -1.0),
            (-0.8, 0.5, 0.0, -1.0),
            (2.0, 0.0, 1.0, 1.0),
        ] {
            let got = allocate(common, differential, UNIT, Sharing::TurnFirst).motors;
            assert!((got.port - port).abs() < 1e-12 && (got.starboard - starboard).abs() < 1e-12, "{got:?}");
        }
        // Weak astern: turning on the spot stays on the spot.
        let weak = EffortLimits { astern: -133.0, ahead: 239.0 };
        let spin = allocate(0.0, 500.0, weak, Sharing::TurnFirst);
        assert!(spin.common.abs() < 1e-12 && (spin.motors.starboard + 133.0).abs() < 1e-12);
    }

    #[test]
    fn independent_cutting_loses_turn() {
        let got = allocate(0.9, 0.3, UNIT, Sharing::Independent);
        assert!((got.motors.port - 1.0).abs() < 1e-12 && (got.motors.starboard - 0.6).abs() < 1e-12);
        assert!((got.differential - 0.2).abs() < 1e-12);
    }

    proptest! {
        #[test]
        fn force_and_actuation_undo_each_other(force_n in -133.0..239.0_f64, other_n in -133.0..239.0_f64) {
            for map in MAPS {
                prop_assert!((map.force_at(map.actuation_for(force_n)) - force_n).abs() < 1e-6);
                prop_assert_eq!(force_n < other_n, map.actuation_for(force_n) < map.actuation_for(other_n));
            }
        }

        #[test]
        fn force_rises_with_actuation(a in any::<f64>(), b in any::<f64>()) {
            for map in MAPS {
                let limits = map.limits();
                prop_assert!((limits.astern..=limits.ahead).contains(&map.force_at(a)));
                prop_assert!(map.actuation_for(a).abs() <= 1.0);
                if a <= b {
                    prop_assert!(map.force_at(a) <= map.force_at(b));
                    prop_assert!(map.actuation_for(a) <= map.actuation_for(b));
                }
            }
        }

        #[test]
        fn allocation_stays_within_limits_and_mirrors(
            common in any::<f64>(), differential in any::<f64>(), astern in -300.0..0.0_f64, ahead in 0.0..300.0_f64,
        ) {
            for sharing in [Sharing::TurnFirst, Sharing::Independent] {
                let limits = EffortLimits { astern, ahead };
                let one = allocate(common, differential, limits, sharing);
                let other = allocate(common, -differential, limits, sharing);
                for effort in [one.motors.port, one.motors.starboard] {
                    prop_assert!((astern..=ahead).contains(&effort));
                }
                prop_assert!((one.motors.port - other.motors.starboard).abs() < 1e-9);
                prop_assert!((one.motors.starboard - other.motors.port).abs() < 1e-9);
            }
        }
    }
}
