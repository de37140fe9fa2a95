//! The supervisors' context, and how a remedy becomes a plan that the engine runs.

use crate::bus::Bus;
use crate::grounding::{Chart, DEEP_WATER, Grounding, GroundingSettings};
use crate::navigation::Estimate;
use crate::pilot::Pilot;
use crate::plans::{NotStarted, Plans};
use crate::routing::FoundRoute;
use crate::settings::RestartSettings;
use crate::states::States;
use crate::supervise::energy::EnergyLeft;
use guard::Area;
use guard::GuardLimits;
use imc::messages::{Message, SpeedUnits, StationKeeping, ZUnits};
use mission::{Remedy, RunId};
use std::time::Duration;
use units::{LatLon, UtcTime};

/// Name of the plan that keeps the vessel where it is.
pub(super) const HOLD_PLAN: &str = "hold";
/// A position that was last measured longer ago is not a place to keep.
const POSITION_KEPT: Duration = Duration::from_secs(2);
/// A station back inside the area keeps this much more than its radius from the border (m).
const BORDER_M: f64 = 5.0;
/// Where no way back inside is wide enough for plans, one with this share of their room will do.
const NARROW: f64 = 0.3;

/// The supervisors' context.
pub(crate) struct Context<'a> {
    pub(crate) bus: &'a mut Bus,
    pub(crate) states: &'a mut States,
    pub(crate) plans: &'a mut Plans,
    pub(crate) pilot: &'a mut Pilot,
    pub(crate) estimate: Option<&'a Estimate>,
    pub(crate) hold_radius_m: f64,
    pub(crate) hold_speed_mps: f64,
    pub(crate) capacity_wh: f64,
    /// Charge of the emptiest battery (%), if one reports.
    pub(crate) charge_percent: Option<f64>,
    pub(crate) grounding: &'a GroundingSettings,
    pub(crate) area: Option<&'a Area>,
    pub(crate) guard: GuardLimits,
    pub(crate) holds_after_failure: bool,
    pub(crate) restart: &'a RestartSettings,
    /// The time of the satellites, once known.
    pub(crate) satellite_utc: Option<UtcTime>,
}

/// A remedy that is carried out.
pub(super) struct Started {
    /// Its run; none where it needs none.
    pub(super) run: Option<RunId>,
    /// Further details.
    pub(super) how: Option<How>,
}

/// How a remedy is carried out.
#[derive(Debug, PartialEq)]
pub(super) struct How {
    pub(super) text: String,
    /// It is not what it should be.
    pub(super) is_doubtful: bool,
}

impl Context<'_> {
    /// Carries a remedy out, or answers why it is not possible now; `in_need` in spite of errors of parts.
    pub(super) fn start(&mut self, remedy: &Remedy, in_need: bool) -> Result<Started, String> {
        let (plan_id, maneuver, how) = match remedy {
            Remedy::Stop => {
                self.plans.stop_own(self.bus, self.pilot);
                return Ok(Started { run: None, how: None });
            }
            Remedy::Run { plan_id } if plan_id == DEEP_WATER => (
                DEEP_WATER,
                Some(self.deep_water().ok_or("no deep water is known that a straight way leads to")?),
                None,
            ),
            Remedy::Run { plan_id } if self.plans.has(plan_id) => (plan_id.as_str(), None, None),
            Remedy::Run { plan_id } => return Err(format!("there is no plan '{plan_id}'")),
            Remedy::Hold => {
                let (station, how) = self.hold()?;
                (HOLD_PLAN, Some(station), how)
            }
        };
        let run = self.plans.start_own(self.bus, self.pilot, plan_id, maneuver, in_need)?;
        Ok(Started { run: Some(run), how })
    }

    /// Starts a plan of the database by a route to its beginning, if guard and area allow it from here and it takes no more
    /// energy than `left` has.
    pub(super) fn start_by_route(
        &mut self,
        plan_id: &str,
        from: LatLon,
        route: &FoundRoute,
        left: Option<EnergyLeft>,
        in_need: bool,
    ) -> Result<RunId, NotStarted> {
        let ways_out = self.looser_and_looser();
        let led = self.plans.led_by_route((plan_id, from), route, &ways_out).map_err(NotStarted::Refused)?;
        if let Some(left) = left {
            left.reaches(self.plans.energy_wh(self.bus, &led, from)).map_err(NotStarted::OutOfReach)?;
        }
        self.plans.start_led(self.bus, self.pilot, led, in_need).map_err(NotStarted::Engine)
    }

    /// The energy of the batteries above a share of their charge, if one reports.
    pub(super) fn energy_left(&self, kept: f64) -> Option<EnergyLeft> {
        let percent = self.charge_percent?;
        Some(EnergyLeft { percent, kept, wh: self.capacity_wh * (percent / 100.0 - kept).max(0.0) })
    }

    pub(super) fn position(&self) -> Result<&Estimate, String> {
        let known = self.estimate.filter(|estimate| estimate.age < POSITION_KEPT);
        known.ok_or_else(|| "the position is not known".to_owned())
    }

    /// Keeping station where the vessel is, or inside the area if it is outside or close to the border.
    fn hold(&self) -> Result<(Message, Option<How>), String> {
        let (place, radius_m) = (self.position()?.place, self.hold_radius_m);
        let here = self.station(place, radius_m);
        let Some((area, depth_m)) =
            self.area.map(|area| (area, area.depth_m(place))).filter(|(_, depth_m)| *depth_m < radius_m)
        else {
            return Ok((here, None));
        };
        match self.way_in(area, place) {
            Ok((inside, station)) => {
                let is_doubtful = self.grounding.chart == Chart::Off;
                let way = if is_doubtful {
                    ", straight in, as there is no chart to hold the way against"
                } else {
                    ""
                };
                let text =
                    format!("back inside the area to {:.5}, {:.5}{way}", inside.lat_deg(), inside.lon_deg());
                Ok((station, (depth_m < 0.0).then_some(How { text, is_doubtful })))
            }
            Err(_) if depth_m >= 0.0 => Ok((here, None)),
            Err(why) => {
                let text = format!("no safe way back inside is known ({why}): it holds where it is, outside");
                Ok((here, Some(How { text, is_doubtful: true })))
            }
        }
    }

    /// A place inside the area that a safe way leads to, and keeping station there.
    fn way_in(&self, area: &Area, from: LatLon) -> Result<(LatLon, Message), String> {
        let places = area.ways_in(from, self.hold_radius_m + BORDER_M);
        let mut refusal = None;
        for limits in self.looser_and_looser() {
            for place in &places {
                let station = self.station(*place, self.hold_radius_m.min(area.depth_m(*place)));
                match self.plans.may_lead(station.clone(), from, &limits) {
                    Ok(()) => return Ok((*place, station)),
                    Err(why) => refusal.get_or_insert(why),
                };
            }
        }
        Err(refusal.unwrap_or_else(|| "the area has no room".to_owned()))
    }

    /// The limits to check a way by, in turn: as for plans; with the least depth for manual steering; that in a narrow
    /// corridor too. The vessel may have been steered where plans do not lead.
    fn looser_and_looser(&self) -> [GuardLimits; 3] {
        let guard = self.guard;
        let anybody = GuardLimits { autonomous_m: guard.navigable_m, ..guard };
        [guard, anybody, GuardLimits { cross_track_m: NARROW * guard.cross_track_m, ..anybody }]
    }

    /// Keeping station where it is deep.
    fn deep_water(&self) -> Option<Message> {
        let refuge = Grounding::refuge(self.grounding, self.position().ok()?, self.hold_radius_m)?;
        Some(self.station(refuge.place, refuge.radius_m))
    }

    fn station(&self, place: LatLon, radius_m: f64) -> Message {
        let station = StationKeeping {
            lat: place.lat_rad(),
            lon: place.lon_rad(),
            z_units: ZUnits::Depth,
            radius: radius_m as f32,
            speed: self.hold_speed_mps as f32,
            speed_units: SpeedUnits::MetersPs,
            ..StationKeeping::default()
        };
        station.into()
    }
}
