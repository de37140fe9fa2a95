//! Why a request for a route makes no sense, in words that the catalogue has.

use api::{Said, Wording, say};
use planner::{
    CurrentGridError, MOST_BORDER_KM, MOST_CURRENT_MPS, MOST_GRID_VALUES, MOST_MARGIN_M, NeedsError,
    ZoneError,
};

/// The same as the error says in English.
pub(super) fn needs(NeedsError { name, value, least, most }: NeedsError) -> Said {
    say("the {name} is {value}; it must be a number from {least} to {most}")
        .with_said("name", quantity(name))
        .with("value", value)
        .with("least", least)
        .with("most", most)
        .into()
}

/// What is asked for, by the name that the planner has for it.
fn quantity(name: &'static str) -> Said {
    match name {
        "least depth (m)" => say("least depth (m)").into(),
        "clearance (m)" => say("clearance (m)").into(),
        "uncertainty of the position (m)" => say("uncertainty of the position (m)").into(),
        "water level (m)" => say("water level (m)").into(),
        "speed (m/s)" => say("speed (m/s)").into(),
        "preferred depth (m)" => say("preferred depth (m)").into(),
        "preferred distance (m)" => say("preferred distance (m)").into(),
        "factor of preferences" => say("factor of preferences").into(),
        "factor of traffic" => say("factor of traffic").into(),
        "number of traffic areas" => say("number of traffic areas").into(),
        "number of speed limits" => say("number of speed limits").into(),
        "time of departure (s)" => say("time of departure (s)").into(),
        "speed limit (m/s)" => say("speed limit (m/s)").into(),
        "turning radius (m)" => say("turning radius (m)").into(),
        "longest route (m)" => say("longest route (m)").into(),
        name => Said::as_is(name),
    }
}

/// The same as the error says in English.
pub(super) fn zone(why: ZoneError) -> Said {
    match why {
        ZoneError::TooFewCorners => say("a zone needs at least three corners"),
        ZoneError::Crosses { lat_deg, lon_deg } => {
            say("two sides of the zone cross or touch near {lat}, {lon}: draw it without that")
                .with("lat", format!("{lat_deg:.5}"))
                .with("lon", format!("{lon_deg:.5}"))
        }
        ZoneError::TooWide => say("a zone is less than 180 degrees wide"),
        ZoneError::TooLong { km } => {
            say("the border of the zone is {km} km long; at most {most} km are taken")
                .with("km", format!("{km:.0}"))
                .with("most", format!("{MOST_BORDER_KM:.0}"))
        }
        ZoneError::Margin(margin) => {
            say("the margin to zones is {margin} m; it must be a number from 0 to {most} m")
                .with("margin", margin)
                .with("most", format!("{MOST_MARGIN_M:.0}"))
        }
    }
    .into()
}

/// The same as the error says in English.
pub(super) fn grid(why: &CurrentGridError) -> Said {
    match *why {
        CurrentGridError::Axis { axis, number } => {
            say("{axis}: value {number} is not a number or not greater than the one before; sort the grid")
                .with("axis", axis)
                .with("number", number)
        }
        CurrentGridError::Few { axis, found, least } => {
            say("{axis}: there are {found}; a grid needs {least} or more")
                .with("axis", axis)
                .with("found", found)
                .with("least", least)
        }
        CurrentGridError::Range { axis, first, last, limits } => {
            say("{axis}: it goes from {first} to {last}; {limits}")
                .with("axis", axis)
                .with("first", first)
                .with("last", last)
                .with_said("limits", bounds(limits))
        }
        CurrentGridError::Count { component, found, times, lats, lons, needed } => {
            counted(component, found, needed).with("times", times).with("lats", lats).with("lons", lons)
        }
        CurrentGridError::Large(count) => say(
            "the grid has {count} values; up to {most} are read: cut it to the area and the time of the route",
        )
        .with("count", count)
        .with("most", MOST_GRID_VALUES),
        CurrentGridError::Speed { component, number, found } => {
            say("{component}: value {number} is {found} m/s; up to {most} m/s is taken: give m/s")
                .with("component", component)
                .with("number", number)
                .with("found", found)
                .with("most", MOST_CURRENT_MPS)
        }
    }
    .into()
}

/// What an axis may be, by the words that the planner has for it.
fn bounds(limits: &'static str) -> Said {
    match limits {
        "latitudes are within ±90°" => say("latitudes are within ±90°").into(),
        "longitudes are degrees, and go round the globe once at most" => {
            say("longitudes are degrees, and go round the globe once at most").into()
        }
        limits => Said::as_is(limits),
    }
}

fn counted(component: &'static str, found: usize, needed: usize) -> Wording {
    say("{component}: there are {found} values; {times} times of {lats} latitudes and {lons} longitudes need {needed}")
        .with("component", component)
        .with("found", found)
        .with("needed", needed)
}

#[cfg(test)]
mod tests {
    use super::*;
    use units::LatLon;

    #[test]
    fn what_is_wrong_with_a_request_is_said_as_the_planner_says_it_and_by_a_template() {
        let at = |lat, lon| LatLon::from_deg(lat, lon).unwrap();
        let zones = [
            ZoneError::TooFewCorners,
            ZoneError::Crosses { lat_deg: 63.4, lon_deg: 10.25 },
            ZoneError::TooWide,
            ZoneError::TooLong { km: 2_000.4 },
            ZoneError::Margin(f64::NAN),
        ];
        for why in zones {
            assert_eq!(zone(why), why.to_string().as_str());
        }
        let (axis, component) = ("lats_deg", "east_mps");
        let grids = [
            CurrentGridError::Axis { axis, number: 2 },
            CurrentGridError::Few { axis, found: 1, least: 2 },
            CurrentGridError::Range { axis, first: -91.0, last: 3.0, limits: "give degrees" },
            CurrentGridError::Count { component, found: 3, times: 1, lats: 2, lons: 2, needed: 4 },
            CurrentGridError::Large(9_000_000),
            CurrentGridError::Speed { component, number: 7, found: 40.5 },
        ];
        for why in grids {
            assert_eq!(grid(&why), why.to_string().as_str());
        }
        let wrong = planner::Needs::depth_and_clearance(f64::NAN, 0.0).validate().unwrap_err();
        assert_eq!(needs(wrong), wrong.to_string().as_str());
        let far = planner::Request {
            turn_radius_m: Some(-1.0),
            ..planner::Request::new(at(63.0, 10.0), at(63.1, 10.0))
        };
        let wrong = far.validate().unwrap_err();
        assert_eq!(needs(wrong), wrong.to_string().as_str());
        let named = needs(wrong);
        let bokmal = named.wording().unwrap().in_words(&|english| match english {
            "turning radius (m)" => "svingradius (m)",
            english => english,
        });
        assert!(bokmal.starts_with("the svingradius (m) is -1;"), "{bokmal}");
    }
}
