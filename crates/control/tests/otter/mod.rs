//! Fossen's Otter in surge, sway and yaw with 25 kg of payload, as small as closed-loop tests need it.
//!
//! Constants and equations: MSS otter.m (2026) reduced to three degrees of freedom; see the reference values
//! checked in `closed_loop.rs`. States: n_port, n_stbd (rad/s), u, v, r (m/s, rad/s), north, east (m), psi (rad).

use control::{Motion, MotorPair};
use units::wrap_pi;

const MASS_KG: f64 = 80.0;
const X_G_M: f64 = 0.153_125;
/// Surge, sway and yaw inertia with added mass, and the coupling of sway and yaw.
const M11: f64 = 85.2815;
const M22: f64 = 162.5;
const M23: f64 = 12.25;
const M33: f64 = 40.044_92;
const X_UDOT: f64 = -5.281_52;
const Y_VDOT: f64 = -82.5;
const X_U: f64 = -77.554_43;
const Y_V: f64 = -162.5;
const N_R: f64 = -40.044_92;
const ARM_M: f64 = 0.395;
const K_AHEAD: f64 = 0.011_08;
const K_ASTERN: f64 = 0.006_445;
const N_MAX_RAD_S: f64 = 103.93;
const N_MIN_RAD_S: f64 = -101.74;
const SHAFT_LAG_S: f64 = 0.1;
/// ½ρ·draft·drag coefficient of the cross flow (kg/m²).
const CROSS_FLOW: f64 = 0.5 * 1025.0 * 0.195_122 * 1.004_21;
const STEP_S: f64 = 0.02;

/// The loads of water and wind.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Sea {
    /// Speed of the current (m/s).
    pub(crate) current_mps: f64,
    /// Where it flows to (rad).
    pub(crate) current_to_rad: f64,
    /// A steady moment of the wind, positive to starboard (N m).
    pub(crate) moment_nm: f64,
}

pub(crate) struct Otter {
    pub(crate) state: [f64; 8],
    pub(crate) sea: Sea,
    pub(crate) t_s: f64,
}

impl Otter {
    pub(crate) fn at_rest(heading_rad: f64, sea: Sea) -> Self {
        let mut state = [0.0; 8];
        state[7] = heading_rad;
        Self { state, sea, t_s: 0.0 }
    }

    pub(crate) fn north_m(&self) -> f64 {
        self.state[5]
    }

    pub(crate) fn east_m(&self) -> f64 {
        self.state[6]
    }

    pub(crate) fn speed_over_ground_mps(&self) -> f64 {
        self.state[2].hypot(self.state[3])
    }

    pub(crate) fn motion(&self) -> Motion {
        let [.., u, v, r, _, _, psi] = self.state;
        let (sin, cos) = psi.sin_cos();
        Motion {
            heading_rad: wrap_pi(psi),
            yaw_rate_rad_s: Some(r),
            north_mps: u * cos - v * sin,
            east_mps: u * sin + v * cos,
        }
    }

    /// Runs with actuation `motors` for `duration_s` (a multiple of 20 ms).
    pub(crate) fn run(&mut self, motors: MotorPair, duration_s: f64) {
        self.run_shafts([shaft(motors.port), shaft(motors.starboard)], duration_s);
    }

    /// Runs with shaft speeds (rad/s) as commanded.
    pub(crate) fn run_shafts(&mut self, wanted: [f64; 2], duration_s: f64) {
        let wanted = wanted.map(|n| n.clamp(N_MIN_RAD_S, N_MAX_RAD_S));
        for _ in 0..(duration_s / STEP_S).round() as usize {
            let x = self.state;
            let k1 = self.derivative(&x, wanted);
            let k2 = self.derivative(&moved(&x, &k1, STEP_S / 2.0), wanted);
            let k3 = self.derivative(&moved(&x, &k2, STEP_S / 2.0), wanted);
            let k4 = self.derivative(&moved(&x, &k3, STEP_S), wanted);
            self.state =
                std::array::from_fn(|i| x[i] + STEP_S / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
            self.t_s += STEP_S;
        }
    }

    fn derivative(&self, x: &[f64; 8], wanted: [f64; 2]) -> [f64; 8] {
        let [n_port, n_stbd, u, v, r, _, _, psi] = *x;
        let along = self.sea.current_to_rad - psi;
        let (u_c, v_c) = (self.sea.current_mps * along.cos(), self.sea.current_mps * along.sin());
        let (u_r, v_r) = (u - u_c, v - v_c);
        let (port_n, stbd_n) = (thrust(n_port), thrust(n_stbd));
        let mut flow = (0.0, 0.0);
        for i in -10..=10 {
            let x_i = f64::from(i) / 10.0;
            let w = v_r + x_i * r;
            flow.0 += w.abs() * w * 0.1;
            flow.1 += x_i * w.abs() * w * 0.1;
        }
        let x_n = port_n + stbd_n + X_U * u_r + MASS_KG * (X_G_M * r + v_r) * r - Y_VDOT * v_r * r;
        let y_n = Y_V * v_r - CROSS_FLOW * flow.0 - MASS_KG * u_r * r + X_UDOT * u_r * r;
        let n_nm = ARM_M * (port_n - stbd_n) + self.sea.moment_nm + N_R * (1.0 + 10.0 * r.abs()) * r
            - CROSS_FLOW * flow.1
            - MASS_KG * X_G_M * u_r * r
            - (X_UDOT - Y_VDOT) * u_r * v_r;
        let determinant = M22 * M33 - M23 * M23;
        let (sin, cos) = psi.sin_cos();
        [
            (wanted[0] - n_port) / SHAFT_LAG_S,
            (wanted[1] - n_stbd) / SHAFT_LAG_S,
            x_n / M11 + r * v_c,
            (M33 * y_n - M23 * n_nm) / determinant - r * u_c,
            (M22 * n_nm - M23 * y_n) / determinant,
            u * cos - v * sin,
            u * sin + v * cos,
            r,
        ]
    }
}

/// Shaft speed that an actuation asks for (rad/s).
fn shaft(actuation: f64) -> f64 {
    if actuation < 0.0 { -actuation * N_MIN_RAD_S } else { actuation * N_MAX_RAD_S }
}

fn thrust(n_rad_s: f64) -> f64 {
    let k = if n_rad_s < 0.0 { K_ASTERN } else { K_AHEAD };
    k * n_rad_s * n_rad_s.abs()
}

fn moved(x: &[f64; 8], slope: &[f64; 8], step_s: f64) -> [f64; 8] {
    std::array::from_fn(|i| x[i] + step_s * slope[i])
}
