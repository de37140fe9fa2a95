//! Chance that repeats: a seeded generator, so that two runs of a simulation give the same bytes.
//!
//! The generator is xoshiro256++ 1.0 (D. Blackman and S. Vigna, "Scrambled linear pseudorandom number
//! generators", ACM TOMS 47, 2021), its state filled by SplitMix64 (G. Steele et al., "Fast splittable
//! pseudorandom number generators", OOPSLA 2014), as its authors advise. Every source of chance in a vessel
//! has a [`Stream`] of its own: switching one sensor off leaves the noise of the others as it was.
//!
//! Normal and exponential deviates use the platform's `ln`; runs are therefore equal on one platform and may
//! differ in the last bit between two.

/// Which part of a simulation draws the numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Stream {
    Current = 1,
    Wind = 2,
    Waves = 3,
    Gnss = 4,
    Hydrophone = 5,
    Fish = 6,
    Battery = 7,
}

/// A seeded generator of one stream.
#[derive(Debug, Clone)]
pub(crate) struct Rng {
    state: [u64; 4],
    /// The second half of the last pair of normal deviates.
    spare: Option<f64>,
}

impl Rng {
    /// The generator of `stream` in the simulation seeded with `seed`.
    pub(crate) fn new(seed: u64, stream: Stream) -> Self {
        let mut mixer = SplitMix64(seed ^ (stream as u64).wrapping_mul(0xd1b5_4a32_d192_ed03));
        Self { state: [mixer.next(), mixer.next(), mixer.next(), mixer.next()], spare: None }
    }

    fn next(&mut self) -> u64 {
        let [s0, s1, s2, s3] = self.state;
        let result = s0.wrapping_add(s3).rotate_left(23).wrapping_add(s0);
        let (s2, s3) = (s2 ^ s0, s3 ^ s1);
        self.state = [s0 ^ s3, s1 ^ s2, s2 ^ (s1 << 17), s3.rotate_left(45)];
        result
    }

    /// Uniform in [0, 1).
    pub(crate) fn uniform(&mut self) -> f64 {
        // The upper 53 bits fill a double exactly.
        (self.next() >> 11) as f64 / 9_007_199_254_740_992.0
    }

    /// Uniform in [`low`, `high`).
    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.uniform()
    }

    /// True with the given probability.
    pub(crate) fn chance(&mut self, probability: f64) -> bool {
        self.uniform() < probability
    }

    /// Exponential with the given mean.
    pub(crate) fn exponential(&mut self, mean: f64) -> f64 {
        -mean * (1.0 - self.uniform()).ln()
    }

    /// Normal with mean 0 and standard deviation 1, by Marsaglia's polar method (G. Marsaglia and T. Bray,
    /// SIAM Review 6, 1964).
    pub(crate) fn normal(&mut self) -> f64 {
        if let Some(value) = self.spare.take() {
            return value;
        }
        loop {
            let x = self.between(-1.0, 1.0);
            let y = self.between(-1.0, 1.0);
            let square = x * x + y * y;
            if square < 1.0 && square > 0.0 {
                let scale = (-2.0 * square.ln() / square).sqrt();
                self.spare = Some(y * scale);
                return x * scale;
            }
        }
    }
}

/// Fills the state of the larger generator from one number.
struct SplitMix64(u64);

impl SplitMix64 {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gives_the_published_numbers() {
        // First outputs of xoshiro256++ from the state 1, 2, 3, 4 (vector of the rand_xoshiro crate).
        let mut rng = Rng { state: [1, 2, 3, 4], spare: None };
        let first: Vec<u64> = (0..4).map(|_| rng.next()).collect();
        assert_eq!(first, [41_943_041, 58_720_359, 3_588_806_011_781_223, 3_591_011_842_654_386]);
        // First outputs of SplitMix64 from 1234567 (vector of rosettacode.org).
        let mut mixer = SplitMix64(1_234_567);
        assert_eq!(mixer.next(), 6_457_827_717_110_365_317);
        assert_eq!(mixer.next(), 3_203_168_211_198_807_973);
    }

    #[test]
    fn normal_numbers_have_mean_zero_and_deviation_one() {
        let mut rng = Rng::new(7, Stream::Wind);
        let count = 200_000;
        let (mut sum, mut squares) = (0.0, 0.0);
        for _ in 0..count {
            let value = rng.normal();
            sum += value;
            squares += value * value;
        }
        // Five standard errors: 5/sqrt(200 000) = 0.011, for the square sqrt(2) as much.
        assert!((sum / f64::from(count)).abs() < 0.011);
        assert!((squares / f64::from(count) - 1.0).abs() < 0.016);
    }

    #[test]
    fn exponential_numbers_have_their_mean() {
        let mut rng = Rng::new(7, Stream::Gnss);
        let sum: f64 = (0..100_000).map(|_| rng.exponential(4.0)).sum();
        assert!((sum / 1e5 - 4.0).abs() < 0.07);
    }

    #[test]
    fn streams_of_one_seed_differ() {
        let mut wind = Rng::new(1, Stream::Wind);
        let mut waves = Rng::new(1, Stream::Waves);
        assert!((0..8).all(|_| wind.next() != waves.next()));
    }
}
