//! What a route is good for: its length, its time or its energy, with preferences for deeper water and more distance.
//!
//! The vessel steers a straight course over ground at a steady speed through the water, and steers up against the current
//! for that. Energy is the power at that speed times the time; the power is a function that the caller gives, for the
//! planner knows no vessels. A preference makes water cost more: a metre, second or joule in water that is shallower than
//! preferred, or nearer to what closes it, counts as so many times more.

use crate::currents::{Currents, Flow, made_good_mps};
use crate::limits::{Limits, Piece};
use crate::needs::{Needs, NeedsError};
use crate::plane::{Plane, Point};
use crate::traffic::{InTraffic, TrafficArea};
use crate::zones::Zone;
use charts::depth_index::{Demand, Leg};
use std::fmt;
use std::sync::Arc;
use units::LatLon;

/// Greatest factor of a preference.
const MOST_FACTOR: f64 = 100.0;
/// Farthest that can be preferred to keep off (m).
const MOST_OFF_M: f64 = 2_000.0;
/// Speeds through the water that can be asked for (m/s).
const SLOWEST_MPS: f64 = 0.05;
const FASTEST_MPS: f64 = 20.0;
/// Most areas of ordered traffic.
const MOST_TRAFFIC: usize = 200;
/// Most areas with a speed limit.
const MOST_LIMITS: usize = 50;
/// Where currents or limits differ from place to place, a leg is reckoned in pieces so long (m), but no more than so many.
const PIECE_M: f64 = 25.0;
const MOST_PIECES: f64 = 2_000.0;
/// The legs of one way are reckoned in about so many pieces together; on longer ways each piece is longer.
const MOST_OF_A_WAY: f64 = 20_000.0;
/// Where the current is not known, ways are compared as against the fastest current of the grid, but never slower over
/// ground than this share of the speed through the water.
const LEAST_SHARE: f64 = 0.25;
/// Speeds that are tried for the least energy: tenths of the asked one, from this one to all ten.
const LEAST_TENTHS: u8 = 3;

/// What is to be least.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Aim {
    /// The length.
    #[default]
    Length,
    /// The time at the asked speed through the water.
    Time,
    /// The energy, at the asked speed through the water or a slower one: of 0.3 to 1 times the asked speed, in tenths, the
    /// one that takes least. A route by way of several places keeps one speed: the best one along its shortest stretches.
    Energy,
}

/// The power that a speed through the water takes.
#[derive(Clone)]
pub struct Power(Arc<dyn Fn(f64) -> Option<f64> + Send + Sync>);

impl Power {
    /// By a function from speed (m/s) to power (W); `None` where it is not known.
    pub fn new(power_w: impl Fn(f64) -> Option<f64> + Send + Sync + 'static) -> Self {
        Self(Arc::new(power_w))
    }

    /// At a speed through the water (W).
    pub fn at_w(&self, through_water_mps: f64) -> Option<f64> {
        (self.0)(through_water_mps)
    }
}

impl fmt::Debug for Power {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Power")
    }
}

/// Which water is preferred.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Preferences {
    /// Water shallower than this, at the water level and with the chart errors of the route's demand, costs more (m).
    pub depth_m: Option<f64>,
    /// Water nearer than this to land, dangers and water that is not deep enough for the route costs more (m).
    pub off_m: Option<f64>,
    /// How many times as much such water costs, 1 or more. In water that is both shallow and near, the two surcharges add.
    pub factor: f64,
}

impl Default for Preferences {
    /// Without any; a factor of 3.
    fn default() -> Self {
        Self { depth_m: None, off_m: None, factor: 3.0 }
    }
}

/// An area where a vessel may not be faster.
#[derive(Debug, Clone, PartialEq)]
pub struct SpeedLimit {
    /// The area.
    pub zone: Zone,
    /// Greatest speed through the water (m/s).
    pub most_mps: f64,
}

/// What a route is good for, and in what conditions.
#[derive(Debug, Clone)]
pub struct Objective {
    /// What is to be least.
    pub aim: Aim,
    /// Speed through the water (m/s); for the least energy the greatest one.
    pub through_water_mps: f64,
    /// The power that a speed takes.
    pub power: Power,
    /// The current.
    pub currents: Currents,
    /// When the route begins (s since 1970, UTC): the time of currents that change.
    pub depart_s: f64,
    /// What water is preferred.
    pub preferences: Preferences,
    /// Areas with speed limits; where several overlap, the slowest holds.
    pub limits: Vec<SpeedLimit>,
    /// Areas of ordered traffic.
    pub traffic: Vec<TrafficArea>,
    /// How many times as much a metre, second or joule in them costs, 1 or more; straight against the direction of a lane the
    /// surcharge is twice as large. With 1 they are not minded.
    pub traffic_factor: f64,
}

/// What a leg takes.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LegCost {
    /// Time (s); `None` where the current is too strong or not known, and where it changes with time and the time of the leg
    /// is not known.
    pub duration_s: Option<f64>,
    /// Energy (J); `None` without a time, and at speeds of which the power is not known.
    pub energy_j: Option<f64>,
    /// Length of the leg on which the current is not known (m): beyond the grid or its times, and where the time at which
    /// the leg begins is not known, but the current changes with time.
    pub unknown_m: f64,
    /// Whether the current is too strong somewhere.
    pub too_strong: bool,
    /// The slowest limit of the areas with speed limits that the leg enters or touches, where that is slower than the speed
    /// through the water (m/s).
    pub limit_mps: Option<f64>,
    /// The ordered traffic that the leg enters or touches.
    pub traffic: Option<InTraffic>,
}

/// The sea at one point of a plane.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Spot {
    pub(crate) place: LatLon,
    /// The direction of true north in the plane, of length 1.
    pub(crate) north: Point,
    /// How many times as much it costs here.
    pub(crate) factor: f64,
}

/// What a part of a way costs.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Toll {
    /// In metres, seconds or joules, and more where that is not preferred.
    pub(crate) cost: f64,
    /// Where the current is not known, as in still water.
    pub(crate) duration_s: f64,
    /// Length on which the current is not known.
    pub(crate) unknown_m: f64,
}

impl Toll {
    /// The same where everything costs so many times as much.
    pub(crate) fn times(self, factor: f64) -> Self {
        Self { cost: factor * self.cost, ..self }
    }

    pub(crate) fn and(self, other: Self) -> Self {
        Self {
            cost: self.cost + other.cost,
            duration_s: self.duration_s + other.duration_s,
            unknown_m: self.unknown_m + other.unknown_m,
        }
    }
}

impl Objective {
    /// The shortest way in still water, at a speed through the water that takes a power.
    pub fn shortest(through_water_mps: f64, power: Power) -> Self {
        Self {
            aim: Aim::Length,
            through_water_mps,
            power,
            currents: Currents::default(),
            depart_s: 0.0,
            preferences: Preferences::default(),
            limits: Vec::new(),
            traffic: Vec::new(),
            traffic_factor: 3.0,
        }
    }

    /// Whether the shortest way is the best one.
    pub fn is_shortest(&self) -> bool {
        let Preferences { depth_m, off_m, factor } = self.preferences;
        let prefers = factor > 1.0 && (depth_m.is_some() || off_m.is_some());
        self.aim == Aim::Length && !prefers && !self.minds_traffic()
    }

    /// Whether nothing but ordered traffic makes another way better than the shortest.
    pub(crate) fn minds_only_traffic(&self) -> bool {
        let Preferences { depth_m, off_m, .. } = self.preferences;
        self.aim == Aim::Length && depth_m.is_none() && off_m.is_none()
    }

    fn minds_traffic(&self) -> bool {
        self.traffic_factor > 1.0 && !self.traffic.is_empty()
    }

    /// Whether every metre costs the same: then the shortest way is the best one at any speed.
    pub(crate) fn is_uniform(&self) -> bool {
        let Preferences { depth_m, off_m, .. } = self.preferences;
        let plain = depth_m.is_none() && off_m.is_none() && !self.minds_traffic();
        self.currents.is_still() && self.limits.is_empty() && plain
    }

    /// Whether all its values are numbers in range.
    ///
    /// # Errors
    /// The first that is not.
    pub fn validate(&self) -> Result<(), NeedsError> {
        let Preferences { depth_m, off_m, factor } = self.preferences;
        NeedsError::of("speed (m/s)", self.through_water_mps, SLOWEST_MPS, FASTEST_MPS)?;
        NeedsError::of("preferred depth (m)", depth_m.unwrap_or(0.0), 0.0, 12_000.0)?;
        NeedsError::of("preferred distance (m)", off_m.unwrap_or(0.0), 0.0, MOST_OFF_M)?;
        NeedsError::of("factor of preferences", factor, 1.0, MOST_FACTOR)?;
        NeedsError::of("factor of traffic", self.traffic_factor, 1.0, MOST_FACTOR)?;
        NeedsError::of("number of traffic areas", self.traffic.len() as f64, 0.0, MOST_TRAFFIC as f64)?;
        NeedsError::of("number of speed limits", self.limits.len() as f64, 0.0, MOST_LIMITS as f64)?;
        NeedsError::of("time of departure (s)", self.depart_s, -1e11, 1e11)?;
        self.limits.iter().try_for_each(|limit| {
            NeedsError::of("speed limit (m/s)", limit.most_mps, SLOWEST_MPS, FASTEST_MPS)
        })
    }

    /// What the preferred depth and distance need of the water, beside what a route needs.
    pub(crate) fn preferred(&self, needs: &Needs) -> [Option<Needs>; 2] {
        let Preferences { depth_m, off_m, .. } = self.preferences;
        let deep = depth_m.filter(|depth_m| *depth_m > needs.demand.needed_m()).map(|depth_m| {
            let demand =
                Demand { draught_m: depth_m, squat_m: 0.0, reserve_m: 0.0, position_m: 0.0, ..needs.demand };
            Needs { demand, clearance_m: 0.0 }
        });
        let off = off_m.filter(|off_m| *off_m > needs.clearance_m);
        [deep, off.map(|clearance_m| Needs { clearance_m, ..*needs })]
    }

    /// The factor where some preferences are not met.
    pub(crate) fn factor(&self, unmet: usize) -> f64 {
        1.0 + (self.preferences.factor - 1.0) * unmet as f64
    }

    /// Speeds through the water that are tried (m/s), the asked one last.
    pub(crate) fn paces_mps(&self) -> Vec<f64> {
        let tenths = if self.aim == Aim::Energy { LEAST_TENTHS..=10 } else { 10..=10 };
        let all = tenths.map(|tenth| self.through_water_mps * f64::from(tenth) / 10.0);
        all.filter(|mps| *mps >= SLOWEST_MPS.min(self.through_water_mps)).collect()
    }

    /// No metre anywhere costs less than this at a pace.
    pub(crate) fn least_per_m(&self, pace_mps: f64) -> f64 {
        let limits = self.limits.iter().map(|limit| limit.most_mps).filter(|most_mps| *most_mps < pace_mps);
        let speeds = limits.chain([pace_mps]);
        let per_m = |mps: f64| match self.aim {
            Aim::Length => 1.0,
            Aim::Time => 1.0 / (mps + self.currents.most_mps()),
            Aim::Energy => self.power.at_w(mps).unwrap_or(0.0) / (mps + self.currents.most_mps()),
        };
        speeds.map(per_m).fold(f64::INFINITY, f64::min)
    }

    /// What a short straight piece costs at a speed through the water that its limit allows; `None` where the current is too
    /// strong, or the power is not known and counts.
    /// Where the current is not known, the cost is that of the fastest current of the grid from ahead, so that no way is
    /// better for leading where nothing is known.
    pub(crate) fn piece(
        &self,
        spot: &Spot,
        (from, to): (Point, Point),
        since_s: f64,
        through_water_mps: f64,
    ) -> Option<Toll> {
        let length_m = from.distance_m(to);
        if self.aim == Aim::Length || length_m == 0.0 {
            return Some(Toll { cost: spot.factor * length_m, ..Toll::default() });
        }
        let each_s = if self.aim == Aim::Energy { self.power.at_w(through_water_mps)? } else { 1.0 };
        let Some(flow) = self.currents.at(spot.place, self.depart_s + since_s) else {
            let against_mps = through_water_mps - self.currents.most_mps();
            let over_ground_mps = against_mps.max(LEAST_SHARE * through_water_mps);
            let cost = spot.factor * each_s * length_m / over_ground_mps;
            return Some(Toll { cost, duration_s: length_m / through_water_mps, unknown_m: length_m });
        };
        let duration_s = length_m / over_ground_mps(spot, (from, to), through_water_mps, flow)?;
        Some(Toll { cost: spot.factor * each_s * duration_s, duration_s, unknown_m: 0.0 })
    }

    /// What legs of a length (m) take, one after the other from the time of departure, at a speed through the water (m/s).
    pub(crate) fn reckon(&self, legs: &[(Leg, f64)], through_water_mps: f64) -> Vec<LegCost> {
        let length_m: f64 = legs.iter().map(|(_, leg_m)| leg_m).sum();
        let piece_m = PIECE_M.max(length_m / MOST_OF_A_WAY);
        let mut since_s = Some(0.0);
        let mut reckoned = Vec::new();
        for (leg, leg_m) in legs {
            // Where the time is not known, neither is a current that changes with it.
            let begin_s = if self.currents.varies_in_time() { since_s } else { Some(0.0) };
            let limit_mps = self.slowest_mps(*leg).filter(|limit_mps| *limit_mps < through_water_mps);
            let cost = match begin_s {
                Some(begin_s) => self.leg((*leg, *leg_m), piece_m, begin_s, through_water_mps),
                None => LegCost { unknown_m: *leg_m, ..LegCost::default() },
            };
            since_s = since_s.zip(cost.duration_s).map(|(since_s, duration_s)| since_s + duration_s);
            reckoned.push(LegCost { limit_mps, traffic: self.traffic_on(*leg), ..cost });
        }
        reckoned
    }

    /// The ordered traffic that a leg meets; first that which it goes against.
    fn traffic_on(&self, leg: Leg) -> Option<InTraffic> {
        self.traffic.iter().filter_map(|area| area.on(leg)).max_by_key(|met| met.against)
    }

    /// The slowest limit of the areas that a leg enters or touches (m/s).
    fn slowest_mps(&self, leg: Leg) -> Option<f64> {
        let met = self.limits.iter().filter(|limit| limit.zone.meets(leg));
        met.map(|limit| limit.most_mps).min_by(f64::total_cmp)
    }

    /// The limits that hold somewhere on a leg, in a plane.
    pub(crate) fn limits_on(&self, leg: Leg, plane: &Plane) -> Limits {
        let met = self.limits.iter().filter(|limit| limit.zone.meets(leg));
        Limits::new(met.map(|limit| (&limit.zone, limit.most_mps)), plane)
    }

    fn leg(&self, (leg, leg_m): (Leg, f64), piece_m: f64, begin_s: f64, pace_mps: f64) -> LegCost {
        let plane = Plane::new(leg.from);
        let (from, to) = (Point::default(), plane.point(leg.to));
        let limits = self.limits_on(leg, &plane);
        let piece_m = if self.currents.varies() { piece_m.max(leg_m / MOST_PIECES) } else { f64::INFINITY };
        // The plane's metres are not quite the sea's.
        let scale = leg_m / from.distance_m(to).max(f64::MIN_POSITIVE);
        let mut cost = LegCost { duration_s: Some(0.0), energy_j: Some(0.0), ..LegCost::default() };
        let mut since_s = begin_s;
        for Piece { begin, end, most_mps, .. } in limits.pieces((from, to), piece_m) {
            let spot = Spot::of(&plane, begin.towards(end, 0.5));
            let length_m = scale * begin.distance_m(end);
            // After water of an unknown current the time is not known either.
            let is_timed = cost.duration_s.is_some() || !self.currents.varies_in_time();
            let flow = self.currents.at(spot.place, self.depart_s + since_s).filter(|_| is_timed);
            let through_water_mps = pace_mps.min(most_mps);
            let Some(flow) = flow else {
                cost = LegCost {
                    duration_s: None,
                    energy_j: None,
                    unknown_m: cost.unknown_m + length_m,
                    ..cost
                };
                continue;
            };
            let Some(mps) = over_ground_mps(&spot, (from, to), through_water_mps, flow) else {
                cost = LegCost { duration_s: None, energy_j: None, too_strong: true, ..cost };
                continue;
            };
            let duration_s = length_m / mps;
            since_s += duration_s;
            let energy_j = self.power.at_w(through_water_mps).map(|power_w| power_w * duration_s);
            cost.duration_s = cost.duration_s.map(|sum| sum + duration_s);
            cost.energy_j = cost.energy_j.zip(energy_j).map(|(sum, energy_j)| sum + energy_j);
        }
        cost
    }
}

impl Spot {
    /// At a point of a plane, with a factor of 1.
    pub(crate) fn of(plane: &Plane, at: Point) -> Self {
        Self { place: plane.place(at), north: plane.north(at), factor: 1.0 }
    }
}

/// Speed over ground from one point towards another (m/s); `None` where the current is too strong.
fn over_ground_mps(
    spot: &Spot,
    (from, to): (Point, Point),
    through_water_mps: f64,
    flow: Flow,
) -> Option<f64> {
    let length_m = from.distance_m(to);
    if length_m == 0.0 {
        return Some(through_water_mps);
    }
    let (north, east) = (spot.north, Point { x: spot.north.y, y: -spot.north.x });
    let x = flow.east_mps * east.x + flow.north_mps * north.x;
    let y = flow.east_mps * east.y + flow.north_mps * north.y;
    let (ahead_x, ahead_y) = ((to.x - from.x) / length_m, (to.y - from.y) / length_m);
    made_good_mps(through_water_mps, x * ahead_x + y * ahead_y, x * ahead_y - y * ahead_x)
}
