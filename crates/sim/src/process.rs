//! A first-order Gauss-Markov process: noise with a memory, for slow errors, gusts and varying currents.
//!
//! x(t + dt) = x(t) e^(-dt/τ) + σ sqrt(1 - e^(-2dt/τ)) w with w normal: the exact sampling of white noise
//! behind a first-order lag (A. Gelb, "Applied Optimal Estimation", 1974, chapter 3). The value is held
//! within 4 σ, so that nothing built on it is unbounded.

use crate::rng::Rng;

/// One process with a fixed step.
#[derive(Debug, Clone)]
pub(crate) struct GaussMarkov {
    value: f64,
    decay: f64,
    kick: f64,
    bound: f64,
}

impl GaussMarkov {
    /// A process of standard deviation `sigma` and time constant `tau_s`, stepped every `dt_s`, that starts
    /// in its stationary distribution. With `sigma` 0 it stays 0 and draws nothing.
    pub(crate) fn new(sigma: f64, tau_s: f64, dt_s: f64, rng: &mut Rng) -> Self {
        let decay = (-dt_s / tau_s).exp();
        let mut process =
            Self { value: 0.0, decay, kick: sigma * (1.0 - decay * decay).sqrt(), bound: 4.0 * sigma };
        if sigma > 0.0 {
            process.value = (sigma * rng.normal()).clamp(-process.bound, process.bound);
        }
        process
    }

    /// The value after the last step.
    pub(crate) fn value(&self) -> f64 {
        self.value
    }

    /// Steps once and returns the new value.
    pub(crate) fn step(&mut self, rng: &mut Rng) -> f64 {
        if self.bound > 0.0 {
            self.value = (self.value * self.decay + self.kick * rng.normal()).clamp(-self.bound, self.bound);
        }
        self.value
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Stream;

    #[test]
    fn keeps_its_deviation_and_memory() {
        let mut rng = Rng::new(3, Stream::Current);
        let mut process = GaussMarkov::new(2.0, 10.0, 1.0, &mut rng);
        let values: Vec<f64> = (0..400_000).map(|_| process.step(&mut rng)).collect();
        let variance = values.iter().map(|v| v * v).sum::<f64>() / 4e5;
        let lagged = values.windows(11).map(|w| w[0] * w[10]).sum::<f64>() / 4e5;
        // 400 000 steps hold 20 000 independent values: the variance is known to about 1 %.
        assert!((variance.sqrt() - 2.0).abs() < 0.06, "{variance}");
        assert!((lagged / variance - (-1.0_f64).exp()).abs() < 0.03, "{lagged}");
        assert!(values.iter().all(|v| v.abs() <= 8.0));
    }

    #[test]
    fn without_deviation_it_stays_zero_and_draws_nothing() {
        let mut rng = Rng::new(3, Stream::Current);
        let untouched = rng.clone().uniform();
        let mut process = GaussMarkov::new(0.0, 10.0, 1.0, &mut rng);
        assert!(process.step(&mut rng).abs() < f64::MIN_POSITIVE);
        assert!((rng.uniform() - untouched).abs() < f64::MIN_POSITIVE);
    }
}
