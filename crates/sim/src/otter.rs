//! Fossen's model of the Otter in three degrees of freedom: surge, sway and yaw.
//!
//! Source: MSS, `otter.m` (T. I. Fossen, github.com/cybergalactic/MSS, June 2026), reduced to the horizontal
//! plane by leaving out heave, roll and pitch; the vectorial equation of motion is that of T. I.
//! Fossen, "Handbook of Marine Craft Hydrodynamics and Motion Control", 2nd ed. 2021, chapter 6 and section
//! 10.3 (current). The reduction stays within 0.05 % in u and r of the six-degree model.
//!
//! Units are SI and radians. Body frame: x forward, y to starboard, origin amidships; positions are metres
//! north and east in a local frame; headings turn clockwise from north. A current is the velocity of the
//! water, so it points to where it flows.
//!
//! The published constants belong to a 55 kg hull and, as the demonstration load, 25 kg at (0.05, 0) m; the
//! centre of gravity, inertia, draft and drag follow from the payload given.

use crate::range::{OutOfRange, within};
use devices::Pair;
use units::LocalPoint;

const WATER_KGPM3: f64 = 1025.0;
const GRAVITY_MPS2: f64 = 9.81;
const LENGTH_M: f64 = 2.0;
const HULL_KG: f64 = 55.0;
const HULL_X_M: f64 = 0.2;
const PAYLOAD_X_M: f64 = 0.05;
/// Radius of gyration in yaw, a quarter of the length.
const GYRATION_M: f64 = 0.25 * LENGTH_M;
const PONTOON_BEAM_M: f64 = 0.25;
const BLOCK: f64 = 0.4;
/// Six knots, with the knot rounded as the source rounds it.
const TOP_SPEED_MPS: f64 = 6.0 * 0.5144;
const SWAY_TIME_S: f64 = 1.0;
const YAW_TIME_S: f64 = 1.0;
/// Lever arm of each propeller: half the spacing of the pontoons.
const PROPELLER_ARM_M: f64 = 0.395;
const THRUST_AHEAD: f64 = 0.022_16 / 2.0;
const THRUST_ASTERN: f64 = 0.012_89 / 2.0;
const MAX_PULL_KGF: f64 = 24.4;
const SHAFT_LAG_S: f64 = 0.1;

/// The step of the reference responses (s).
pub const STEP_S: f64 = 0.02;

/// The heaviest payload the model holds for (kg).
pub const MAX_PAYLOAD_KG: f64 = 45.0;

/// Shaft speed at full throttle ahead: 103.93 rad/s (992.5 rpm), where both propellers together pull 24.4
/// kilogram-force.
pub fn shaft_max_radps() -> f64 {
    (0.5 * MAX_PULL_KGF * GRAVITY_MPS2 / THRUST_AHEAD).sqrt()
}

/// Shaft speed at full throttle astern, negative: -101.74 rad/s, where both pull 13.6 kilogram-force.
pub fn shaft_min_radps() -> f64 {
    -(0.5 * 13.6 * GRAVITY_MPS2 / THRUST_ASTERN).sqrt()
}

/// Thrust of one propeller (N) at a shaft speed (rad/s): k n|n| with k by direction, bollard pull.
pub fn thrust_n(shaft_radps: f64) -> f64 {
    let k = if shaft_radps >= 0.0 { THRUST_AHEAD } else { THRUST_ASTERN };
    k * shaft_radps * shaft_radps.abs()
}

/// A horizontal force and moment in the body frame, about the origin amidships.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BodyForce {
    /// Forward (N).
    pub surge_n: f64,
    /// To starboard (N).
    pub sway_n: f64,
    /// Bow to starboard (N m).
    pub yaw_nm: f64,
}

/// The loads of the surroundings on the hull during one step.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Load {
    /// Velocity of the water to the north (m/s).
    pub current_north_mps: f64,
    /// Velocity of the water to the east (m/s).
    pub current_east_mps: f64,
    /// Wind and waves.
    pub force: BodyForce,
}

/// Where the vessel is and how it moves over ground.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct OtterState {
    /// Position of the point amidships.
    pub position: LocalPoint,
    /// Heading (rad), counted on over full turns, not wrapped.
    pub psi_rad: f64,
    /// Velocity over ground along the hull (m/s).
    pub u_mps: f64,
    /// Velocity over ground to starboard (m/s).
    pub v_mps: f64,
    /// Rate of turn, bow to starboard (rad/s).
    pub r_radps: f64,
    /// Speeds of the propeller shafts (rad/s).
    pub shaft_radps: Pair<f64>,
}

impl OtterState {
    /// Velocity over ground to the north and to the east (m/s).
    pub fn ground_velocity_mps(&self) -> (f64, f64) {
        let (sin, cos) = self.psi_rad.sin_cos();
        (self.u_mps * cos - self.v_mps * sin, self.u_mps * sin + self.v_mps * cos)
    }

    /// The state after `dt_s` at constant ground velocity and rate of turn; for instants within one step.
    #[must_use]
    pub fn moved(&self, dt_s: f64) -> Self {
        let (north_mps, east_mps) = self.ground_velocity_mps();
        Self {
            position: LocalPoint {
                north_m: self.position.north_m + north_mps * dt_s,
                east_m: self.position.east_m + east_mps * dt_s,
            },
            psi_rad: self.psi_rad + self.r_radps * dt_s,
            ..*self
        }
    }

    fn pose(&self) -> Vector {
        [self.position.north_m, self.position.east_m, self.psi_rad, self.u_mps, self.v_mps, self.r_radps]
    }
}

/// North, east, psi, u, v, r.
type Vector = [f64; 6];

/// The constants of one Otter, worked out from its payload.
#[derive(Debug, Clone)]
pub struct Otter {
    mass_kg: f64,
    x_g_m: f64,
    /// Added mass in surge, -X_udot (kg).
    added_surge_kg: f64,
    /// Added mass in sway, -Y_vdot (kg).
    added_sway_kg: f64,
    m11: f64,
    m22: f64,
    m23: f64,
    m33: f64,
    damping_surge: f64,
    damping_sway: f64,
    damping_yaw: f64,
    draft_m: f64,
    /// Half density times draft times drag coefficient times the width of a strip.
    cross_flow: f64,
}

impl Otter {
    /// An Otter that carries `payload_kg`.
    ///
    /// # Errors
    /// When the payload is not a number within 0 to 45 kg.
    pub fn new(payload_kg: f64) -> Result<Self, OutOfRange> {
        within("payload (kg)", payload_kg, 0.0, MAX_PAYLOAD_KG)?;
        let mass_kg = HULL_KG + payload_kg;
        let x_g_m = (HULL_KG * HULL_X_M + payload_kg * PAYLOAD_X_M) / mass_kg;
        // Inertia about the common centre of gravity by the theorem of Steiner, then about amidships.
        let inertia_cg = HULL_KG * (GYRATION_M.powi(2) + (HULL_X_M - x_g_m).powi(2))
            + payload_kg * (PAYLOAD_X_M - x_g_m).powi(2);
        let inertia = inertia_cg + mass_kg * x_g_m.powi(2);
        // Added mass in surge after MSS addedMassSurge.m; it belongs to the hull, whatever the payload.
        let added_surge_kg = 2.7 * WATER_KGPM3 * (HULL_KG / WATER_KGPM3).powf(5.0 / 3.0) / LENGTH_M.powi(2);
        let added_sway_kg = 1.5 * HULL_KG;
        let added_yaw = 1.7 * inertia_cg;
        let (m22, m33) = (mass_kg + added_sway_kg, inertia + added_yaw);
        let draft_m = mass_kg / (WATER_KGPM3 * 2.0 * BLOCK * PONTOON_BEAM_M * LENGTH_M);
        let drag_coefficient = hoerner(PONTOON_BEAM_M / (2.0 * draft_m));
        Ok(Self {
            mass_kg,
            x_g_m,
            added_surge_kg,
            added_sway_kg,
            m11: mass_kg + added_surge_kg,
            m22,
            m23: mass_kg * x_g_m,
            m33,
            damping_surge: MAX_PULL_KGF * GRAVITY_MPS2 / TOP_SPEED_MPS,
            damping_sway: m22 / SWAY_TIME_S,
            damping_yaw: m33 / YAW_TIME_S,
            draft_m,
            cross_flow: 0.5 * WATER_KGPM3 * draft_m * drag_coefficient * STRIP_M,
        })
    }

    /// Hull and payload (kg).
    pub fn mass_kg(&self) -> f64 {
        self.mass_kg
    }

    /// Mass and added mass in surge and in sway (kg).
    pub fn virtual_mass_kg(&self) -> (f64, f64) {
        (self.m11, self.m22)
    }

    /// Mass times the distance of its centre before amidships (kg m).
    pub fn mass_moment_kgm(&self) -> f64 {
        self.m23
    }

    /// The speed through still water that both propellers keep up at a throttle (m/s), 0 to 1 ahead.
    pub fn steady_speed_mps(&self, throttle: f64) -> f64 {
        2.0 * thrust_n(throttle.clamp(0.0, 1.0) * shaft_max_radps()) / self.damping_surge
    }

    /// Depth of the pontoons in the water (m).
    pub fn draft_m(&self) -> f64 {
        self.draft_m
    }

    /// The state `dt_s` later by the classical Runge-Kutta method of fourth order.
    ///
    /// `command_radps` are the shaft speeds asked for, limited to what the motors reach; the shafts follow
    /// with an exact first-order lag of 0.1 s. Thrust, wind and waves are held during the step, as in the
    /// reference responses, which were made with [`STEP_S`]: a longer step delays the thrust by half of
    /// what it is longer.
    #[must_use]
    pub fn step(&self, state: &OtterState, command_radps: Pair<f64>, load: &Load, dt_s: f64) -> OtterState {
        let force = propulsion(state.shaft_radps, &load.force);
        let x = state.pose();
        let k1 = self.derivative(&x, &force, load);
        let k2 = self.derivative(&along(&x, &k1, 0.5 * dt_s), &force, load);
        let k3 = self.derivative(&along(&x, &k2, 0.5 * dt_s), &force, load);
        let k4 = self.derivative(&along(&x, &k3, dt_s), &force, load);
        let mut next = x;
        for i in 0..6 {
            next[i] += dt_s / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]);
        }
        let [north_m, east_m, psi_rad, u_mps, v_mps, r_radps] = next;
        let remain = (-dt_s / SHAFT_LAG_S).exp();
        let follow = |now: f64, command: f64| {
            let goal = command.clamp(shaft_min_radps(), shaft_max_radps());
            goal + (now - goal) * remain
        };
        OtterState {
            position: LocalPoint { north_m, east_m },
            psi_rad,
            u_mps,
            v_mps,
            r_radps,
            shaft_radps: Pair {
                port: follow(state.shaft_radps.port, command_radps.port),
                starboard: follow(state.shaft_radps.starboard, command_radps.starboard),
            },
        }
    }

    /// M dν/dt = τ - D ν_r - cross flow - C(ν_r) ν_r.
    fn derivative(&self, x: &Vector, force: &BodyForce, load: &Load) -> Vector {
        let [_, _, psi, u, v, r] = *x;
        let (sin, cos) = psi.sin_cos();
        let u_c = load.current_north_mps * cos + load.current_east_mps * sin;
        let v_c = load.current_east_mps * cos - load.current_north_mps * sin;
        let (u_r, v_r) = (u - u_c, v - v_c);
        let (drag_n, drag_nm) = self.cross_flow_drag(v_r, r);

        let surge = force.surge_n - self.damping_surge * u_r
            + self.mass_kg * (self.x_g_m * r + v_r) * r
            + self.added_sway_kg * v_r * r;
        let sway =
            force.sway_n - self.damping_sway * v_r - drag_n - (self.mass_kg + self.added_surge_kg) * u_r * r;
        let yaw = force.yaw_nm
            - self.damping_yaw * (1.0 + 10.0 * r.abs()) * r
            - drag_nm
            - self.mass_kg * self.x_g_m * u_r * r
            - (self.added_sway_kg - self.added_surge_kg) * u_r * v_r;

        let determinant = self.m22 * self.m33 - self.m23 * self.m23;
        [
            u * cos - v * sin,
            u * sin + v * cos,
            r,
            surge / self.m11 + r * v_c,
            (self.m33 * sway - self.m23 * yaw) / determinant - r * u_c,
            (self.m22 * yaw - self.m23 * sway) / determinant,
        ]
    }

    /// Cross-flow drag by strip theory: the force to starboard (N) and the moment (N m) it takes away.
    fn cross_flow_drag(&self, v_r: f64, r: f64) -> (f64, f64) {
        let (mut force, mut moment) = (0.0, 0.0);
        for x_m in STRIPS_M {
            let flow = v_r + x_m * r;
            let drag = flow.abs() * flow;
            force += drag;
            moment += x_m * drag;
        }
        (self.cross_flow * force, self.cross_flow * moment)
    }
}

const STRIP_M: f64 = 0.1;
const STRIPS_M: [f64; 21] = {
    let mut strips = [0.0; 21];
    let mut i = 0;
    while i < 21 {
        strips[i] = (i as f64 - 10.0) / 10.0;
        i += 1;
    }
    strips
};

fn along(x: &Vector, slope: &Vector, dt_s: f64) -> Vector {
    let mut moved = *x;
    for i in 0..6 {
        moved[i] += slope[i] * dt_s;
    }
    moved
}

/// Both propellers and the given outer force.
fn propulsion(shaft_radps: Pair<f64>, outer: &BodyForce) -> BodyForce {
    let thrust = shaft_radps.map(thrust_n);
    BodyForce {
        surge_n: outer.surge_n + thrust.port + thrust.starboard,
        sway_n: outer.sway_n,
        yaw_nm: outer.yaw_nm + PROPELLER_ARM_M * (thrust.port - thrust.starboard),
    }
}

/// Hoerner's two-dimensional cross-flow coefficient over beam / (2 draft), linear between the points that
/// MSS `Hoerner.m` lists (A. J. P. Leite et al., Applied Ocean Research 20, 1998, pp. 145-156).
fn hoerner(beam_by_two_drafts: f64) -> f64 {
    const CURVE: [(f64, f64); 20] = [
        (0.010_862_3, 1.966_08),
        (0.176_606, 1.965_73),
        (0.353_025, 1.897_56),
        (0.451_863, 1.787_18),
        (0.472_838, 1.583_74),
        (0.492_877, 1.278_62),
        (0.493_252, 1.210_82),
        (0.558_473, 1.083_56),
        (0.646_401, 0.998_631),
        (0.833_589, 0.879_59),
        (0.988_002, 0.828_415),
        (1.308_07, 0.759_941),
        (1.639_18, 0.691_442),
        (1.859_98, 0.657_076),
        (2.312_88, 0.630_693),
        (2.599_98, 0.596_186),
        (3.008_77, 0.586_846),
        (3.450_75, 0.585_909),
        (3.737_9, 0.559_877),
        (4.003_09, 0.559_315),
    ];
    let above = CURVE.partition_point(|&(x, _)| x < beam_by_two_drafts).clamp(1, CURVE.len() - 1);
    let ((x0, y0), (x1, y1)) = (CURVE[above - 1], CURVE[above]);
    y0 + (y1 - y0) * (beam_by_two_drafts.clamp(CURVE[0].0, 4.003_09) - x0) / (x1 - x0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(value: f64, expected: f64, tolerance: f64) {
        assert!((value - expected).abs() <= tolerance, "{value} is not {expected}");
    }

    #[test]
    fn constants_with_the_demonstration_load_are_the_published_ones() {
        // Those of `otter.m` with 25 kg at (0.05, 0) m.
        let otter = Otter::new(25.0).unwrap();
        close(otter.x_g_m, 0.153_125, 1e-9);
        close(otter.m11, 85.281_52, 1e-5);
        close(otter.m22, 162.5, 1e-9);
        close(otter.m23, 12.25, 1e-9);
        close(otter.m33, 40.044_92, 1e-5);
        close(otter.damping_surge, 77.554_43, 1e-5);
        close(otter.damping_yaw, 40.044_92, 1e-5);
        close(otter.draft_m, 0.195_122, 1e-6);
        close(hoerner(PONTOON_BEAM_M / (2.0 * otter.draft_m)), 1.004_21, 1e-5);
    }

    #[test]
    fn constants_without_load_follow_the_same_rules() {
        let otter = Otter::new(0.0).unwrap();
        close(otter.x_g_m, 0.2, 1e-12);
        close(otter.m33, 13.75 * 2.7 + 55.0 * 0.04, 1e-9);
        close(otter.draft_m, 0.134_146, 1e-6);
    }

    #[test]
    fn shaft_limits_are_the_published_ones() {
        close(shaft_max_radps(), 103.93, 0.005);
        close(shaft_min_radps(), -101.74, 0.005);
        close(thrust_n(shaft_max_radps()), 119.7, 0.05);
        close(thrust_n(shaft_min_radps()), -66.7, 0.05);
    }

    #[test]
    fn keeps_up_the_speed_that_it_says() {
        let otter = Otter::new(25.0).unwrap();
        for throttle in [0.3, 0.7, 1.0] {
            let shaft = throttle * shaft_max_radps();
            let mut state = OtterState::default();
            for _ in 0..3_000 {
                state = otter.step(&state, Pair::new(shaft, shaft), &Load::default(), STEP_S);
            }
            close(otter.steady_speed_mps(throttle), state.u_mps, 1e-6);
        }
        close(otter.steady_speed_mps(1.0), TOP_SPEED_MPS, 1e-9);
    }

    #[test]
    fn refuses_a_payload_it_does_not_hold_for() {
        for payload_kg in [-0.1, 45.1, f64::NAN, f64::INFINITY] {
            assert!(Otter::new(payload_kg).is_err());
        }
        assert!(Otter::new(MAX_PAYLOAD_KG).is_ok());
    }

    #[test]
    fn left_alone_in_a_current_it_comes_to_drift_with_the_water() {
        let otter = Otter::new(25.0).unwrap();
        let load = Load { current_north_mps: 0.3, current_east_mps: -0.2, ..Load::default() };
        let mut state = OtterState::default();
        for _ in 0..5_000 {
            state = otter.step(&state, Pair::default(), &load, 0.04);
        }
        let (north_mps, east_mps) = state.ground_velocity_mps();
        close(north_mps, 0.3, 1e-3);
        close(east_mps, -0.2, 1e-3);
    }

    #[test]
    fn hoerner_curve_meets_its_points_and_stays_flat_outside() {
        close(hoerner(0.558_473), 1.083_56, 1e-12);
        close(hoerner(0.0), 1.966_08, 1e-12);
        close(hoerner(9.0), 0.559_315, 1e-9);
    }
}
