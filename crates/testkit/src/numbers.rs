//! Numbers that look random and are the same in every run.

use units::LocalPoint;

/// Marsaglia's xorshift of 64 bits; what it begins with must not be 0.
#[derive(Debug, Clone)]
pub struct Numbers(pub u64);

impl Numbers {
    /// In [0, 1).
    pub fn share(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// From `least` on, below `most`.
    pub fn within(&mut self, least: f64, most: f64) -> f64 {
        least + (most - least) * self.share()
    }

    /// In a square that reaches `half_m` to each side.
    pub fn point(&mut self, half_m: f64) -> LocalPoint {
        LocalPoint { north_m: self.within(-half_m, half_m), east_m: self.within(-half_m, half_m) }
    }
}
