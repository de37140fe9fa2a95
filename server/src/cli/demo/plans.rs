//! The plans of a demo's Otters, which repeat.

use super::fleet::{Otter, Pattern};
use anyhow::anyhow;
use api::PlanDocument;
use imc::messages::{
    Goto, Loiter, LoiterDirection, LoiterType, Message, PlanManeuver, PlanSpecification, PlanTransition,
    Rows, SpeedUnits, StationKeeping, ZUnits,
};
use shore::plans;
use std::f64::consts::FRAC_PI_2;
use units::{LatLon, LocalFrame, LocalPoint};

/// Speed (m/s).
const SPEED_MPS: f32 = 1.5;
/// Sides of the square (m).
const SIDE_M: f64 = 120.0;
/// Duration of the circle, and of the station keeping after it (s).
const CIRCLE_S: u16 = 300;
const STATION_S: u16 = 90;

impl Pattern {
    /// The plan of an Otter that starts at `start`, within some 200 m north and east of there.
    pub(super) fn plan(self, start: LatLon) -> PlanSpecification {
        let frame = LocalFrame::new(start);
        let at = |north_m, east_m| frame.to_place(LocalPoint { north_m, east_m });
        match self {
            Self::Square => {
                let corners = [(SIDE_M, 0.0), (SIDE_M, SIDE_M), (0.0, SIDE_M), (0.0, 0.0)];
                round("square", corners.map(|(north_m, east_m)| goto(at(north_m, east_m)).into()).into())
            }
            Self::Rows => round("rows", vec![rows(at(20.0, 0.0)).into(), goto(start).into()]),
            Self::Circle => {
                let centre = at(60.0, 60.0);
                round("circle", vec![circle(centre).into(), station(centre).into()])
            }
        }
    }
}

/// An Otter's plan, in the forms for people ashore and for the vessel.
///
/// # Errors
/// One form cannot be converted to the other.
pub(super) fn drawn(otter: &Otter) -> anyhow::Result<(PlanDocument, PlanSpecification)> {
    let told = |texts: Vec<String>| anyhow!("the plan of {}: {}", otter.name, texts.join("; "));
    let (document, _) = plans::document(&otter.pattern.plan(otter.start))
        .map_err(|troubles| told(troubles.into_iter().map(String::from).collect()))?;
    let description = format!("{} sails {} in the demonstration.", otter.name, otter.pattern.words());
    let document = PlanDocument { vessel: Some(otter.address.0), description, ..document };
    let specification = plans::specification(&document)
        .map_err(|troubles| told(troubles.into_iter().map(|trouble| trouble.text).collect()))?;
    Ok((document, specification))
}

fn goto(place: LatLon) -> Goto {
    Goto {
        lat: place.lat_rad(),
        lon: place.lon_rad(),
        z_units: ZUnits::Depth,
        speed: SPEED_MPS,
        speed_units: SpeedUnits::MetersPs,
        ..Goto::default()
    }
}

fn rows(origin: LatLon) -> Rows {
    Rows {
        lat: origin.lat_rad(),
        lon: origin.lon_rad(),
        z_units: ZUnits::Depth,
        speed: SPEED_MPS,
        speed_units: SpeedUnits::MetersPs,
        bearing: FRAC_PI_2,
        width: 120.0,
        length: 150.0,
        hstep: 20.0,
        coff: 10,
        alternation: 100,
        // Without the flag for a first turn to the right, the rows go north from here.
        ..Rows::default()
    }
}

fn circle(centre: LatLon) -> Loiter {
    Loiter {
        lat: centre.lat_rad(),
        lon: centre.lon_rad(),
        z_units: ZUnits::Depth,
        duration: CIRCLE_S,
        speed: SPEED_MPS,
        speed_units: SpeedUnits::MetersPs,
        r#type: LoiterType::Circular,
        radius: 40.0,
        direction: LoiterDirection::Clockw,
        ..Loiter::default()
    }
}

fn station(centre: LatLon) -> StationKeeping {
    StationKeeping {
        lat: centre.lat_rad(),
        lon: centre.lon_rad(),
        z_units: ZUnits::Depth,
        radius: 10.0,
        duration: STATION_S,
        speed: 1.0,
        speed_units: SpeedUnits::MetersPs,
        ..StationKeeping::default()
    }
}

/// Maneuvers one after the other, and again from the first.
fn round(id: &str, maneuvers: Vec<Message>) -> PlanSpecification {
    let name = |index: usize| format!("{id} {}", index + 1);
    let count = maneuvers.len();
    let transition = |index: usize| PlanTransition {
        source_man: name(index).into(),
        dest_man: name((index + 1) % count).into(),
        conditions: "ManeuverIsDone".into(),
        ..PlanTransition::default()
    };
    let maneuver = |(index, data): (usize, Message)| PlanManeuver {
        maneuver_id: name(index).into(),
        data: data.into(),
        ..PlanManeuver::default()
    };
    PlanSpecification {
        plan_id: id.into(),
        start_man_id: name(0).into(),
        transitions: (0..count).map(transition).collect(),
        maneuvers: maneuvers.into_iter().enumerate().map(maneuver).collect(),
        ..PlanSpecification::default()
    }
}

#[cfg(test)]
mod tests {
    use super::super::fleet;
    use super::*;

    #[test]
    fn every_plan_can_be_edited_ashore_and_sails_as_it_was_meant() {
        for otter in fleet::otters(3) {
            let (document, specification) = drawn(&otter).unwrap();
            let meant = otter.pattern.plan(otter.start);
            assert!(document.repeat && document.vessel == Some(otter.address.0));
            assert_eq!(
                (document.name.as_bytes(), &specification.plan_id),
                (meant.plan_id.as_bytes(), &meant.plan_id)
            );
            let ways = |plan: &PlanSpecification| {
                let ids = plan.maneuvers.of().map(|maneuver: PlanManeuver| maneuver.maneuver_id);
                (ids.collect::<Vec<_>>(), plan.transitions.of::<PlanTransition>().count())
            };
            assert_eq!(ways(&specification), ways(&meant));
        }
    }
}
