//! Areas and tags by which detections are narrowed down: read from text, or refused in words that the catalogue has.

use api::{Wording, say};
use detections::{AREA_CORNERS, Area, NoArea, NoTag, TagFilter};

/// The area that a text gives by its corners.
///
/// # Errors
/// It is not one.
pub fn area(text: &str) -> Result<Area, Wording> {
    text.trim().parse().map_err(|why| no_area(&why))
}

/// The tag that a text names.
///
/// # Errors
/// It is not one.
pub fn tag(text: &str) -> Result<TagFilter, Wording> {
    text.parse().map_err(|NoTag| {
        say("this is not a tag: write protocol and number, like S256-101, or the number alone, like 101")
    })
}

fn no_area(why: &NoArea) -> Wording {
    match why {
        NoArea::Corners(count) => say(
            "it has {count} corners; give {least} to {most}, each as latitude,longitude in degrees, with `;` between corners",
        )
        .with("count", count)
        .with("least", AREA_CORNERS.start())
        .with("most", AREA_CORNERS.end()),
        NoArea::Corner(corner) => say(
            "corner {corner} is not a place; write it as latitude,longitude in degrees, like 63.44,10.35",
        )
        .with("corner", corner),
        NoArea::Side(corner) => say(
            "the side from corner {corner} to the next spans more than 180 degrees of longitude; an area cannot cross the 180th meridian: ask for the part on each side of it by itself",
        )
        .with("corner", corner),
        NoArea::Crossing(one, other) => say(
            "the sides from corner {one} and from corner {other} to their next corners cross or touch; give the corners in the order in which one sails around the area",
        )
        .with("one", one)
        .with("other", other),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_an_area_is_said_by_a_template_with_its_values() {
        for (text, template, said) in [
            ("63,10;64,10", "it has {count} corners", "it has 2 corners; give 3 to 100"),
            ("63,10;64,10;91,10", "corner {corner} is not a place", "corner 3 is not a place"),
            ("-17,179;-17,-179;-18,-179;-18,179", "the side from corner {corner}", "the side from corner 1"),
            (
                "63,10;64,11;64,10;63,11",
                "the sides from corner {one}",
                "the sides from corner 1 and from corner 3",
            ),
        ] {
            let wrong = area(text).unwrap_err();
            assert!(wrong.template.starts_with(template), "{wrong:?}");
            assert!(wrong.to_string().starts_with(said), "{wrong}");
        }
        assert!(tag("R64K-").unwrap_err().to_string().starts_with("this is not a tag"));
    }
}
