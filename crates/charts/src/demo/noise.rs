//! Numbers that look random and are the same on every computer: integer hashes, and arithmetic that IEEE 754
//! fixes to the last bit.

/// A hash of a lattice point (the finaliser of SplitMix64, G. Steele et al., OOPSLA 2014).
fn hash(x: i64, y: i64, salt: u64) -> u64 {
    let mut z = (x as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15)
        ^ (y as u64).wrapping_mul(0xC2B2_AE3D_27D4_EB4F)
        ^ salt.wrapping_mul(0x1656_67B1_9E37_79F9);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

/// From 0 to 1.
pub(super) fn unit(x: i64, y: i64, salt: u64) -> f64 {
    (hash(x, y, salt) >> 11) as f64 / (1_u64 << 53) as f64
}

/// Smooth noise from -1 to 1 with bumps of a size (m).
fn smooth([x, y]: [f64; 2], size_m: f64, salt: u64) -> f64 {
    let (u, v) = (x / size_m, y / size_m);
    let (i, j) = (u.floor(), v.floor());
    let fade = |t: f64| t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
    let (s, t) = (fade(u - i), fade(v - j));
    let at = |di: i64, dj: i64| unit(i as i64 + di, j as i64 + dj, salt) * 2.0 - 1.0;
    let mix = |a: f64, b: f64, t: f64| a + (b - a) * t;
    mix(mix(at(0, 0), at(1, 0), s), mix(at(0, 1), at(1, 1), s), t)
}

/// Noise of several sizes, each half as large and half as high as the previous one; from -2 to 2.
pub(super) fn rough(at: [f64; 2], size_m: f64, octaves: u32, salt: u64) -> f64 {
    let (mut sum, mut size_m, mut weight) = (0.0, size_m, 1.0);
    for octave in 0..octaves {
        sum += weight * smooth(at, size_m, salt + u64::from(octave));
        (size_m, weight) = (size_m / 2.0, weight / 2.0);
    }
    sum
}
