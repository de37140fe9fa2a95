//! The fictitious sea floor: height at any point, made of coasts, islands, skerries and noise.
//!
//! Points are metres east and north of the demonstration's first Otter. Heights are metres above the sounding
//! datum; a depth is a negative height.

use super::noise::{rough, unit};

/// Where the demonstration's Otters sail: nothing here is shallower than [`OPEN_DEPTH_M`].
pub(super) const OPEN: Box = Box { west: -70.0, south: -70.0, east: 790.0, north: 1_060.0 };
/// Depth that is kept in [`OPEN`] (m).
pub(super) const OPEN_DEPTH_M: f64 = 14.0;
/// The harbour's basin, dredged flat.
pub(super) const BASIN: Box = Box { west: 300.0, south: -1_230.0, east: 640.0, north: -1_010.0 };
/// Depth of the basin (m).
pub(super) const BASIN_DEPTH_M: f64 = 4.0;
/// The basin is flat so far from its quays (m).
const QUAY_M: f64 = 6.0;
/// The way into the harbour and its depth along the middle (m).
const WAY_IN: [[f64; 2]; 2] = [[470.0, -1_000.0], [470.0, -640.0]];
const WAY_IN_DEPTH_M: f64 = 6.0;
/// The sound between the eastern islands, and its depth along the middle (m).
pub(super) const SOUND: [[f64; 2]; 4] =
    [[1_500.0, 20.0], [1_535.0, 320.0], [1_480.0, 600.0], [1_560.0, 960.0]];
const SOUND_DEPTH_M: f64 = 4.2;
/// Breakwaters of the harbour, from the shore to their heads.
pub(super) const BREAKWATERS: [[[f64; 2]; 4]; 2] = [
    [[285.0, -1_170.0], [285.0, -1_020.0], [330.0, -940.0], [420.0, -915.0]],
    [[655.0, -1_170.0], [655.0, -1_020.0], [620.0, -935.0], [525.0, -905.0]],
];

/// A rectangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Box {
    pub(super) west: f64,
    pub(super) south: f64,
    pub(super) east: f64,
    pub(super) north: f64,
}

impl Box {
    /// How far outside a point lies; inside, how far from the border, negative.
    pub(super) fn distance(&self, [x, y]: [f64; 2]) -> f64 {
        let dx = (self.west - x).max(x - self.east);
        let dy = (self.south - y).max(y - self.north);
        if dx > 0.0 && dy > 0.0 { (dx * dx + dy * dy).sqrt() } else { dx.max(dy) }
    }
}

/// An island: an ellipse whose shore noise bends.
struct Island {
    middle: [f64; 2],
    /// Half axes along and across its length (m).
    half: [f64; 2],
    /// Direction of its length: cosine and sine of the angle from east.
    along: [f64; 2],
    height_m: f64,
}

const ISLANDS: [Island; 9] = [
    island([-820.0, 420.0], [640.0, 350.0], [0.28, 0.96], 62.0),
    island([-1_230.0, -520.0], [260.0, 170.0], [0.8, 0.6], 28.0),
    island([1_230.0, 430.0], [470.0, 230.0], [0.28, 0.96], 48.0),
    island([1_700.0, 560.0], [420.0, 240.0], [0.0, 1.0], 40.0),
    island([940.0, 860.0], [75.0, 48.0], [0.8, 0.6], 14.0),
    island([-260.0, -330.0], [95.0, 50.0], [0.96, 0.28], 11.0),
    island([300.0, 1_440.0], [230.0, 100.0], [0.96, -0.28], 24.0),
    island([2_700.0, 1_500.0], [600.0, 330.0], [0.8, 0.6], 55.0),
    island([-2_500.0, 1_600.0], [700.0, 380.0], [0.6, 0.8], 70.0),
];

const fn island(middle: [f64; 2], half: [f64; 2], along: [f64; 2], height_m: f64) -> Island {
    Island { middle, half, along, height_m }
}

/// A skerry or shoal: a paraboloid.
struct Skerry {
    middle: [f64; 2],
    radius_m: f64,
    /// Of its top; below 0 for a shoal.
    height_m: f64,
    /// How far it falls within its radius (m).
    fall_m: f64,
}

/// Dangers close to where the Otters sail: a shoal west, skerries around, a rock awash east.
const NEAR: [Skerry; 7] = [
    skerry([-175.0, -120.0], 55.0, -2.4, 9.0),
    skerry([-165.0, 270.0], 42.0, 3.6, 8.0),
    skerry([-190.0, 620.0], 34.0, -0.9, 8.0),
    skerry([330.0, -205.0], 46.0, -3.3, 8.0),
    skerry([905.0, 150.0], 30.0, 0.6, 8.0),
    skerry([900.0, 480.0], 36.0, -1.6, 8.0),
    skerry([420.0, 1_185.0], 48.0, 2.9, 9.0),
];

const fn skerry(middle: [f64; 2], radius_m: f64, height_m: f64, fall_m: f64) -> Skerry {
    Skerry { middle, radius_m, height_m, fall_m }
}

/// The sea floor.
pub(super) struct Sea {
    skerries: Vec<Skerry>,
}

impl Sea {
    /// The same in every run.
    pub(super) fn new() -> Self {
        let mut skerries: Vec<Skerry> = NEAR.into();
        // Belts of skerries: middle, half widths, number.
        let belts = [
            ([250.0, 1_380.0], [900.0, 230.0], 34),
            ([-620.0, -420.0], [500.0, 260.0], 20),
            ([1_500.0, -250.0], [600.0, 300.0], 24),
            ([2_400.0, 2_300.0], [1_500.0, 700.0], 60),
            ([-1_900.0, 2_600.0], [1_400.0, 700.0], 50),
            ([-2_600.0, -900.0], [800.0, 700.0], 30),
            ([3_300.0, -700.0], [800.0, 900.0], 30),
        ];
        for (belt, (middle, half, count)) in belts.into_iter().enumerate() {
            let belt = belt as i64;
            for one in 0..count {
                let random = |salt| unit(belt, one, salt);
                let at = |axis: usize, salt| middle[axis] + half[axis] * (random(salt) * 2.0 - 1.0);
                let skerry = Skerry {
                    middle: [at(0, 1), at(1, 2)],
                    radius_m: 14.0 + 44.0 * random(3) * random(3),
                    height_m: 6.0 * random(4) - 3.4,
                    fall_m: 5.0 + 5.0 * random(5),
                };
                if OPEN.distance(skerry.middle) > skerry.radius_m + 60.0 {
                    skerries.push(skerry);
                }
            }
        }
        Self { skerries }
    }

    /// Height above the sounding datum (m).
    pub(super) fn height_m(&self, at: [f64; 2]) -> f64 {
        // Bays and headlands, then creeks and points.
        let bend = |salt| 150.0 * rough(at, 620.0, 2, salt) + 62.0 * rough(at, 170.0, 4, salt + 7);
        let warped = [at[0] + bend(11), at[1] + bend(31)];
        let mut height = floor_m(at);
        for coast in [south_coast_m(warped), north_coast_m(warped)] {
            height = height.max(coast);
        }
        for island in &ISLANDS {
            height = height.max(island_m(island, warped));
        }
        let near = [at[0] + 15.0 * rough(at, 64.0, 3, 51), at[1] + 15.0 * rough(at, 64.0, 3, 61)];
        for skerry in &self.skerries {
            // Six radii away it is deeper than the fjord.
            if (near[0] - skerry.middle[0]).abs() < 6.0 * skerry.radius_m {
                height = height.max(skerry_m(skerry, near));
            }
        }
        // Rougher ashore and close to it than on the soft bottom of the deep.
        let roughness = ((height + 45.0) / 45.0).clamp(0.15, 1.0);
        height += roughness * 2.6 * rough(at, 150.0, 4, 71);
        shaped_m(height, at)
    }
}

/// The fjord's floor: deepest along its middle.
fn floor_m(at: [f64; 2]) -> f64 {
    let trough = (at[1] - 900.0).abs() / 2_600.0;
    -34.0 - 75.0 * (1.0 - trough * trough).max(0.0) * ((at[0].abs() - 300.0) / 2_500.0).clamp(0.0, 1.0)
        + 8.0 * rough(at, 900.0, 3, 81)
}

fn south_coast_m([x, y]: [f64; 2]) -> f64 {
    let shore = -990.0 - 0.00004 * (x - 450.0) * (x - 450.0);
    slope_m(shore - y)
}

fn north_coast_m([x, y]: [f64; 2]) -> f64 {
    slope_m(y - 3_250.0 - 0.1 * x)
}

/// From the distance ashore, negative at sea: steep below water, gentler above.
fn slope_m(ashore_m: f64) -> f64 {
    if ashore_m > 0.0 { (ashore_m * 0.16).min(120.0) } else { ashore_m * 0.085 }
}

fn island_m(island: &Island, [x, y]: [f64; 2]) -> f64 {
    let (dx, dy) = (x - island.middle[0], y - island.middle[1]);
    let [cos, sin] = island.along;
    let (u, v) = ((dx * cos + dy * sin) / island.half[0], (dy * cos - dx * sin) / island.half[1]);
    let out = (u * u + v * v).sqrt() - 1.0;
    if out < 0.0 { -out * island.height_m } else { -out * island.half[1] * 0.13 }
}

fn skerry_m(skerry: &Skerry, [x, y]: [f64; 2]) -> f64 {
    let (dx, dy) = (x - skerry.middle[0], y - skerry.middle[1]);
    let square = (dx * dx + dy * dy) / (skerry.radius_m * skerry.radius_m);
    skerry.height_m - skerry.fall_m * square
}

/// What people made, and what the demonstration needs: open water, a sound, a harbour.
fn shaped_m(natural_m: f64, at: [f64; 2]) -> f64 {
    let open = OPEN.distance(at).max(0.0) * 0.32 - OPEN_DEPTH_M;
    // Its shores wind, but never as far as its middle.
    let wound = [at[0] + 9.0 * rough(at, 110.0, 3, 101), at[1]];
    let shelf = 0.16 + 0.06 * rough(at, 140.0, 2, 111);
    let sound = (distance_to(&SOUND, wound) - 22.0).max(0.0) * shelf - SOUND_DEPTH_M;
    let way_in = (distance_to(&WAY_IN, at) - 30.0).max(0.0) * 0.2 - WAY_IN_DEPTH_M;
    let mut height = natural_m.min(open).min(sound).min(way_in);
    for line in &BREAKWATERS {
        let wall = 4.2 - (distance_to(line, at) - 7.0).max(0.0) * 0.75;
        height = height.max(wall);
    }
    let inside = BASIN.distance(at);
    if inside < -QUAY_M { -BASIN_DEPTH_M } else { height.min((inside + QUAY_M) * 1.1 - BASIN_DEPTH_M) }
}

/// Distance to a line of points (m).
fn distance_to(line: &[[f64; 2]], [x, y]: [f64; 2]) -> f64 {
    let square = line
        .windows(2)
        .map(|pair| {
            let [[ax, ay], [bx, by]] = [pair[0], pair[1]];
            let (ux, uy) = (bx - ax, by - ay);
            let t = (((x - ax) * ux + (y - ay) * uy) / (ux * ux + uy * uy)).clamp(0.0, 1.0);
            let (dx, dy) = (x - ax - ux * t, y - ay - uy * t);
            dx * dx + dy * dy
        })
        .fold(f64::INFINITY, f64::min);
    square.sqrt()
}
