//! Where the vessel may sail autonomously, for goals that others set under way: the area of operation and the sea chart.
//! Plans are checked against both before they start.

use crate::area::Area;
use crate::check::check_way;
use crate::limits::GuardLimits;
use crate::sweep::distance_m;
use charts::depth_index::DepthIndex;
use std::fmt;
use std::sync::Arc;
use units::{LatLon, LocalFrame, LocalPoint};

/// The border is searched for along a way in steps of this length (m), but not in more steps than these.
const STEP_M: f64 = 5.0;
const MOST_STEPS: u32 = 400;

/// Where the vessel may sail autonomously.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Waters {
    /// The area of operation; anywhere without.
    pub area: Option<Area>,
    /// The sea chart.
    pub chart: WaterChart,
}

/// The sea chart that ways are checked against.
#[derive(Clone, PartialEq, Default)]
pub enum WaterChart {
    /// No chart is configured: ways are not checked against one.
    #[default]
    Off,
    /// The chart cannot be read, and no way is allowed without it.
    Unreadable,
    /// Ways are checked against this chart, by these limits.
    Loaded(Arc<DepthIndex>, Box<GuardLimits>),
}

impl fmt::Debug for WaterChart {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // A chart has millions of numbers.
        f.write_str(match self {
            Self::Off => "Off",
            Self::Unreadable => "Unreadable",
            Self::Loaded(..) => "Loaded",
        })
    }
}

impl Waters {
    /// Whether a place lies where the vessel may go, the way there not being known yet.
    ///
    /// # Errors
    /// Why not, for people.
    pub fn place(&self, place: LatLon) -> Result<(), String> {
        let outside_m = self.area.as_ref().map_or(0.0, |area| area.outside_m(place));
        if outside_m > 0.0 { Err(format!("it lies {outside_m:.0} m outside the area")) } else { Ok(()) }
    }

    /// Whether the straight way between two places keeps to the area and to deep water.
    ///
    /// # Errors
    /// Why not, for people.
    pub fn way(&self, from: LatLon, to: LatLon) -> Result<(), String> {
        self.place(to)?;
        if self.area.as_ref().is_some_and(|area| leaves(area, from, to)) {
            return Err("the way there leads out of the area".to_owned());
        }
        match &self.chart {
            WaterChart::Off => Ok(()),
            WaterChart::Unreadable => Err("the chart that is configured cannot be read".to_owned()),
            WaterChart::Loaded(index, limits) => {
                let way = check_way("the way", from, to, index, limits);
                if way.reason.is_some() { Err(way.to_string()) } else { Ok(()) }
            }
        }
    }
}

/// Whether a way that begins inside leads outside: an area may have bays.
fn leaves(area: &Area, from: LatLon, to: LatLon) -> bool {
    if area.outside_m(from) > 0.0 {
        return false;
    }
    let frame = LocalFrame::new(from);
    let end = frame.to_local(to);
    // From a distance to a small number of steps.
    let steps = ((distance_m(from, to) / STEP_M).ceil() as u32).clamp(1, MOST_STEPS);
    (1..steps).any(|step| {
        let share = f64::from(step) / f64::from(steps);
        let point = LocalPoint { north_m: share * end.north_m, east_m: share * end.east_m };
        area.outside_m(frame.to_place(point)) > 0.0
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use testkit::sea::{Ground, Sea};

    fn frame() -> LocalFrame {
        LocalFrame::new(LatLon::from_deg(63.33, 10.0833).unwrap())
    }

    fn place(north_m: f64, east_m: f64) -> LatLon {
        frame().to_place(LocalPoint { north_m, east_m })
    }

    #[test]
    fn a_way_keeps_to_the_area_also_around_its_bays() {
        // A square with a bay from the south.
        let corners = [
            (0.0, 0.0),
            (0.0, 80.0),
            (150.0, 100.0),
            (0.0, 120.0),
            (0.0, 200.0),
            (200.0, 200.0),
            (200.0, 0.0),
        ];
        let area = Some(Area::new(&corners.map(|(n, e)| place(n, e))).unwrap());
        let waters = Waters { area, chart: WaterChart::Off };
        let from = place(20.0, 20.0);
        assert_eq!(waters.way(from, place(180.0, 20.0)), Ok(()));
        assert!(waters.way(from, place(20.0, 180.0)).unwrap_err().contains("leads out of the area"));
        assert!(waters.way(from, place(20.0, 260.0)).unwrap_err().contains("60 m outside"));
        assert_eq!(waters.way(place(-40.0, 20.0), from), Ok(()), "from outside the way leads in");
    }

    #[test]
    fn a_way_keeps_to_deep_water() {
        let north = LocalPoint { north_m: 200.0, east_m: 0.0 };
        let index = Sea::new(frame().origin(), 600.0, 30.0).with(Ground::Depth(2.0), north, 30.0, 12).index();
        let chart = WaterChart::Loaded(Arc::new(index), Box::default());
        let waters = Waters { area: None, chart };
        let from = place(0.0, 0.0);
        assert_eq!(waters.way(from, place(0.0, 300.0)), Ok(()));
        let why = waters.way(from, place(300.0, 0.0)).unwrap_err();
        assert!(why.contains("2.0 m"), "{why}");
        assert!(Waters { area: None, chart: WaterChart::Unreadable }.way(from, from).is_err());
    }
}
