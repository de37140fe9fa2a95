//! Limits on how fast a value may change.

/// `previous` moved towards `target` by at most `max_change` (not negative).
pub(crate) fn toward(previous: f64, target: f64, max_change: f64) -> f64 {
    target.clamp(previous - max_change, previous + max_change)
}

/// `target`, but its magnitude at most `max_change` above that of `previous`; what goes the other way starts
/// from zero. Falling towards zero is never held back, so stopping is immediate.
pub(crate) fn rising(previous: f64, target: f64, max_change: f64) -> f64 {
    let start = if previous * target > 0.0 { previous.abs() } else { 0.0 };
    target.abs().min(start + max_change).copysign(target)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rising_holds_back_only_growing_magnitudes() {
        for (previous, target, got) in [
            (0.0, 1.0, 0.1),
            (0.5, 1.0, 0.6),
            (0.5, 0.0, 0.0),
            (0.5, -1.0, -0.1),
            (-0.5, -1.0, -0.6),
            (0.9, 0.2, 0.2),
        ] {
            assert!((rising(previous, target, 0.1) - got).abs() < 1e-12, "{previous} to {target}");
        }
    }
}
