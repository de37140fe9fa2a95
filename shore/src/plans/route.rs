//! The route of a plan that a vessel executes, for drawing.

use super::translate::degrees_of;
use api::RouteLeg;
use imc::Address;
use imc::messages::PlanSpecification;
use mission::Maneuver;
use onboard::Settings;

/// Most places that are returned.
const PLACES: usize = 20_000;

/// The maneuvers in order of execution, and whether they repeat.
///
/// # Errors
/// Why it cannot be drawn.
pub fn route(plan: &PlanSpecification) -> Result<(Vec<RouteLeg>, bool), String> {
    let checked = onboard::checked_plan(plan, &Settings::otter("shore", Address(0)))
        .map_err(|problems| problems.0.first().map_or_else(String::new, ToString::to_string))?;
    let mut room = PLACES;
    let mut legs = Vec::new();
    for index in checked.order() {
        let Some(node) = checked.node(index) else { continue };
        let places = node.maneuver().places();
        if places.len() > room {
            return Err(format!("it has more than {PLACES} places"));
        }
        room -= places.len();
        let radius_m = match node.maneuver() {
            Maneuver::StationKeeping(station) => Some(station.radius_m),
            _ => None,
        };
        legs.push(RouteLeg {
            id: node.id().to_owned(),
            kind: node.maneuver().kind().to_string(),
            places: places.into_iter().map(degrees_of).collect(),
            radius_m,
        });
    }
    Ok((legs, checked.is_cyclic()))
}
