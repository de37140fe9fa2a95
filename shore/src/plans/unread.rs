//! Why a file holds no plan, and what of it was left out, in words that the catalogue has. What readers of JSON and XML say within them is English.

use api::{Said, say};
use geofile::geojson::GeoJsonError;
use geofile::gpx::GpxError;
use geofile::{LeftOut, MOST_POSITIONS};

/// The same as the error says in English.
pub(super) fn no_gpx(why: GpxError) -> Said {
    let text = match why {
        GpxError::Text(byte) => {
            say("the file is not in UTF-8 from byte {byte} on; save it as UTF-8").with("byte", byte)
        }
        GpxError::Xml { line, what } => say("line {line}: this is not XML: {what}; fetch the file again")
            .with("line", line)
            .with("what", what),
        GpxError::NoGpx(found) => {
            say("the file holds <{found}> in place of <gpx>; export it as GPX").with("found", found)
        }
        GpxError::DocType(line) => say("line {line}: GPX has no <!DOCTYPE>; take it out").with("line", line),
        GpxError::Position { line, element, found } => say(
            "line {line}: <{element}> needs lat within ±90 and lon within ±180 in degrees, it has {found}",
        )
        .with("line", line)
        .with("element", element)
        .with("found", found),
        GpxError::Long(line) => say("line {line}: the file has more than {most} positions; divide it")
            .with("line", line)
            .with("most", MOST_POSITIONS),
        // Its text gives the reader's own limit.
        why @ GpxError::Deep(_) => return Said::as_is(why.to_string()),
        GpxError::Cut(element) => {
            say("the file ends within <{element}>; fetch it again, whole").with("element", element)
        }
    };
    text.into()
}

/// Likewise.
pub(super) fn no_geojson(why: GeoJsonError) -> Said {
    let text = match why {
        GeoJsonError::Json(what) => say("this is not JSON: {what}; fetch the file again").with("what", what),
        GeoJsonError::Type { place, found } => say(
            "{place}: a {found} is neither point nor line; export points and lines as a FeatureCollection",
        )
        .with("place", place)
        .with("found", found),
        GeoJsonError::Position { place, found } => {
            say("{place}: {found} is not longitude and latitude in degrees; convert the file to EPSG:4326")
                .with("place", place)
                .with("found", found)
        }
        GeoJsonError::System(found) => {
            say("the coordinate system is {found}; convert the file to EPSG:4326").with("found", found)
        }
        GeoJsonError::Long(place) => say("{place}: the file has more than {most} positions; divide it")
            .with("place", place)
            .with("most", MOST_POSITIONS),
        // Of polygons, which are not plans.
        why @ (GeoJsonError::NoPolygon { .. } | GeoJsonError::Ring { .. }) => {
            return Said::as_is(why.to_string());
        }
    };
    text.into()
}

/// Likewise.
pub(super) fn left_out(part: &LeftOut) -> Said {
    match part {
        LeftOut::Marks(count) => {
            say("way points beside routes and tracks were left out: {count}").with("count", count)
        }
        LeftOut::NoGeometry(place) => say("{place} has no geometry and was left out").with("place", place),
    }
    .into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_left_out_has_the_words_of_its_reader_and_a_template() {
        for part in [LeftOut::Marks(3), LeftOut::NoGeometry("feature 2".to_owned())] {
            let said = left_out(&part);
            assert_eq!(said, part.to_string().as_str());
            assert!(said.wording().is_some(), "{said}");
        }
    }

    #[test]
    fn a_file_is_refused_in_the_words_of_its_reader_and_by_a_template() {
        let text = |text: &str| text.to_owned();
        let gpx = [
            GpxError::Text(7),
            GpxError::Xml { line: 3, what: text("no end") },
            GpxError::NoGpx(text("kml")),
            GpxError::DocType(1),
            GpxError::Position { line: 2, element: text("wpt"), found: text("lat=91") },
            GpxError::Long(9),
            GpxError::Cut(text("rte")),
        ];
        for why in gpx {
            let said = no_gpx(why.clone());
            assert_eq!(said, why.to_string().as_str());
            assert!(said.wording().is_some(), "{said}");
        }
        let place = || text("feature 2");
        let geojson = [
            GeoJsonError::Json(text("EOF")),
            GeoJsonError::Type { place: place(), found: text("Polygon") },
            GeoJsonError::Position { place: place(), found: text("[91]") },
            GeoJsonError::System(text("EPSG:25832")),
            GeoJsonError::Long(place()),
        ];
        for why in geojson {
            let said = no_geojson(why.clone());
            assert_eq!(said, why.to_string().as_str());
            assert!(said.wording().is_some(), "{said}");
        }
    }
}
