//! Speeds in percent of full thrust, revolutions per minute and metres per second, by table.
//!
//! A table gives rpm and m/s at 0, 10, ... 100 percent; between the rows it is linear, below 0 it is
//! mirrored. Both columns may stay level at the top (the motor gives no more); the way back then answers the
//! least percentage that reaches the value.

use crate::range::RangeCheck;

/// Rpm and m/s at 0, 10, ... 100 percent; both columns start at 0 and never fall.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpeedTable {
    rpm: [f64; 11],
    mps: [f64; 11],
}

impl SpeedTable {
    /// The table of the thesis (N. Lauvås, NTNU 2020). Its m/s are a guess, linear to 6 knots.
    pub const THESIS: Self = Self {
        rpm: [0.0, 120.0, 245.0, 360.0, 490.0, 615.0, 725.0, 845.0, 980.0, 980.0, 980.0],
        mps: [0.0, 1.0, 1.3, 1.6, 1.9, 2.2, 2.5, 2.8, 3.09, 3.09, 3.09],
    };

    /// The table of NTNU's public configuration, with speeds measured on the real boat.
    pub const NTNU_OTTER: Self = Self {
        rpm: [0.0, 120.0, 240.0, 360.0, 480.0, 610.0, 726.0, 845.0, 960.0, 980.0, 980.0],
        mps: [0.0, 0.34, 0.66, 1.0, 1.36, 1.57, 1.75, 2.05, 2.4, 2.4, 2.4],
    };

    /// Fossen's Otter (MSS otter.m) going straight: n = percent·n_max with n_max 992.47 rpm, and
    /// u = 2·k_pos·n²/77.55443.
    pub const FOSSEN_OTTER: Self = Self {
        rpm: [0.0, 99.247, 198.494, 297.741, 396.988, 496.235, 595.482, 694.729, 793.976, 893.223, 992.47],
        mps: [
            0.0, 0.030_864, 0.123_456, 0.277_776, 0.493_824, 0.771_6, 1.111_104, 1.512_336, 1.975_296,
            2.499_984, 3.086_4,
        ],
    };

    /// A table of one's own; `None` unless both columns start at 0, never fall, and end above 0.
    pub fn new(rpm: [f64; 11], mps: [f64; 11]) -> Option<Self> {
        let rises = |column: &[f64; 11]| {
            column[0].abs() < f64::EPSILON
                && column.windows(2).all(|pair| pair[0] <= pair[1])
                && column[10] > 0.0
                && column[10].is_finite()
        };
        (rises(&rpm) && rises(&mps)).then_some(Self { rpm, mps })
    }

    /// Rpm at a percentage; beyond ±100 as at ±100.
    pub fn rpm_for_percent(&self, percent: f64) -> f64 {
        at_percent(&self.rpm, percent)
    }

    /// Metres per second at a percentage; beyond ±100 as at ±100.
    pub fn mps_for_percent(&self, percent: f64) -> f64 {
        at_percent(&self.mps, percent)
    }

    /// The least percentage that gives `rpm`; ±100 where none does.
    pub fn percent_for_rpm(&self, rpm: f64) -> f64 {
        percent_of(&self.rpm, rpm)
    }

    /// The least percentage that gives `mps`; ±100 where none does.
    pub fn percent_for_mps(&self, mps: f64) -> f64 {
        percent_of(&self.mps, mps)
    }

    /// Rpm that give `mps`; the highest of the table where none does.
    pub fn rpm_for_mps(&self, mps: f64) -> f64 {
        self.rpm_for_percent(self.percent_for_mps(mps))
    }

    /// Metres per second at `rpm`; the highest of the table beyond its end.
    pub fn mps_for_rpm(&self, rpm: f64) -> f64 {
        self.mps_for_percent(self.percent_for_rpm(rpm))
    }

    /// The highest speed of the table (m/s).
    pub fn highest_mps(&self) -> f64 {
        self.mps[10]
    }

    pub(crate) fn check(&self, check: &mut RangeCheck) {
        check.number("highest_rpm", "rpm", self.rpm[10], 1.0..=1e5);
        check.number("highest_mps", "m/s", self.mps[10], 0.01..=50.0);
    }
}

fn at_percent(column: &[f64; 11], percent: f64) -> f64 {
    if percent.is_nan() {
        return 0.0;
    }
    let rows = percent.abs().min(100.0) / 10.0;
    // 0 to 9: the row below, so that there is always one above.
    let row = (rows as usize).min(9);
    let value = column[row] + (column[row + 1] - column[row]) * (rows - row as f64);
    value.copysign(percent)
}

fn percent_of(column: &[f64; 11], value: f64) -> f64 {
    if value.is_nan() {
        return 0.0;
    }
    let magnitude = value.abs();
    let Some(row) = column.iter().position(|&entry| entry >= magnitude) else {
        // The flat top adds nothing: answer where it begins.
        return 100.0_f64.copysign(value);
    };
    let rows = if row == 0 {
        0.0
    } else {
        let (below, above) = (column[row - 1], column[row]);
        (row - 1) as f64 + (magnitude - below) / (above - below)
    };
    (10.0 * rows).copysign(value)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const TABLES: [SpeedTable; 3] = [SpeedTable::THESIS, SpeedTable::NTNU_OTTER, SpeedTable::FOSSEN_OTTER];

    #[test]
    fn converts_along_the_rows_of_the_real_boat() {
        let table = SpeedTable::NTNU_OTTER;
        for (percent, rpm, mps) in [
            (0.0, 0.0, 0.0),
            (30.0, 360.0, 1.0),
            (35.0, 420.0, 1.18),
            (80.0, 960.0, 2.4),
            (-10.0, -120.0, -0.34),
        ] {
            assert!((table.rpm_for_percent(percent) - rpm).abs() < 1e-9);
            assert!((table.mps_for_percent(percent) - mps).abs() < 1e-9);
            assert!((table.percent_for_rpm(rpm) - percent).abs() < 1e-9);
            assert!((table.percent_for_mps(mps) - percent).abs() < 1e-9);
        }
    }

    #[test]
    fn a_flat_top_answers_the_least_percentage() {
        let table = SpeedTable::NTNU_OTTER;
        assert!((table.percent_for_mps(2.4) - 80.0).abs() < 1e-9);
        assert!((table.percent_for_mps(9.0) - 100.0).abs() < 1e-9);
        assert!((table.mps_for_percent(1000.0) - 2.4).abs() < 1e-9);
    }

    #[test]
    fn fossens_table_is_that_of_the_closed_form() {
        for percent in (0..=100).step_by(10) {
            let n_rad_s = f64::from(percent) / 100.0 * 103.93;
            let mps = 2.0 * 0.011_08 * n_rad_s * n_rad_s / 77.554_43;
            let got = SpeedTable::FOSSEN_OTTER.mps_for_percent(f64::from(percent));
            assert!((got - mps).abs() < 1e-3, "{percent} %: {got}, {mps}");
        }
    }

    #[test]
    fn refuses_columns_that_fall() {
        let good = std::array::from_fn(|i| i as f64);
        let mut falling = good;
        falling[5] = 3.0;
        assert!(SpeedTable::new(good, good).is_some());
        assert!(SpeedTable::new(falling, good).is_none());
        assert!(SpeedTable::new(good, [0.0; 11]).is_none());
        falling[5] = f64::NAN;
        assert!(SpeedTable::new(good, falling).is_none());
    }

    proptest! {
        #[test]
        fn conversions_are_monotone_and_odd(a in any::<f64>(), b in any::<f64>()) {
            for table in TABLES {
                for f in [
                    SpeedTable::rpm_for_percent, SpeedTable::mps_for_percent, SpeedTable::percent_for_rpm,
                    SpeedTable::percent_for_mps, SpeedTable::rpm_for_mps, SpeedTable::mps_for_rpm,
                ] {
                    prop_assert!(f(&table, a).is_finite());
                    prop_assert!((f(&table, a) + f(&table, -a)).abs() < 1e-9);
                    if a <= b {
                        prop_assert!(f(&table, a) <= f(&table, b) + 1e-9);
                    }
                }
            }
        }

        #[test]
        fn speeds_within_the_table_return(mps in 0.0..2.4_f64) {
            for table in TABLES {
                prop_assert!((table.mps_for_percent(table.percent_for_mps(mps)) - mps).abs() < 1e-9);
                prop_assert!((table.mps_for_rpm(table.rpm_for_mps(mps)) - mps).abs() < 1e-9);
            }
        }
    }
}
