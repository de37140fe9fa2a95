//! The part of a dataset that a link gives.

use super::grid::Grid;
use crate::study::Heard;
use api::{Said, say};
use detections::{Area, Detection, Effort, Pose, TagFilter};
use std::borrow::Cow;

/// Words for sensors whose values do not tell how deep the water is. The register takes any words for a sensor: a value is given
/// where all of them stand here.
const HARMLESS: [&str; 11] = [
    "temp",
    "temperature",
    "temperatur",
    "accel",
    "acceleration",
    "accelerometer",
    "akselerasjon",
    "akselerometer",
    "activity",
    "aktivitet",
    "tilt",
];

/// The limits of a link's detections. Times are the requester's.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Limits {
    /// Only these tags; all where empty.
    tags: Vec<TagFilter>,
    /// Only there; everywhere where absent.
    area: Option<Area>,
    grid: Option<Grid>,
    precision_m: Option<u32>,
    /// Whether a part of the time alone is given.
    is_part_of_time: bool,
}

impl Limits {
    /// Of these tags, in the area of these corners (everywhere where empty), with places coarsened to cells of a size.
    ///
    /// # Errors
    /// A tag, the area or the size is wrong; the text names the field and says what to do.
    pub fn new(
        tags: &[String],
        area: &str,
        precision_m: Option<u32>,
        is_part_of_time: bool,
    ) -> Result<Self, Said> {
        let tag = |text: &String| {
            crate::filters::tag(text).map_err(|why| {
                let wrong = say("`{tag}`: {error}").with("tag", text).with_said("error", why);
                Said::from(wrong).of_field("tags")
            })
        };
        let area = Some(area.trim()).filter(|text| !text.is_empty()).map(crate::filters::area).transpose();
        Ok(Self {
            tags: tags.iter().map(tag).collect::<Result<_, _>>()?,
            area: area.map_err(|why| Said::from(why).of_field("area"))?,
            grid: precision_m
                .map(Grid::new)
                .transpose()
                .map_err(|text| Said::from(text).of_field("precision_m"))?,
            precision_m,
            is_part_of_time,
        })
    }

    /// Size of the cells to which places are coarsened, m: then the register must not tell any either
    /// ([`crate::Study::without_places`]).
    pub fn cells_m(&self) -> Option<u32> {
        self.precision_m
    }

    /// Whether times to the detections before and after are left out, as some of these detections are not given.
    pub fn hides_neighbours(&self) -> bool {
        self.area.is_some() || self.is_part_of_time
    }

    /// The detection as released; `None` where it is withheld.
    ///
    /// With coarsened places it holds nothing that would reveal the place more exactly: not its accuracy, not the
    /// receiver's line, and no value of a sensor that measures depth or that the register does not know. The area filter
    /// uses the coarsened place too: two areas that differ by a little would reveal on which side a place lies.
    pub fn given<'d>(&self, heard: &Heard<'d>) -> Option<Cow<'d, Detection>> {
        let one = heard.detection;
        if !self.tags.is_empty() && !self.tags.iter().any(|tag| tag.admits(one)) {
            return None;
        }
        let mut given = Cow::Borrowed(one);
        if let Some(grid) = self.grid {
            let given = given.to_mut();
            let place = one.pose.and_then(|pose| grid.middle(pose.place));
            given.pose = place.map(|place| Pose { place, age_s: None, sigma_m: None });
            given.raw = None;
            given.effort = Effort { lines_lost: one.effort.lines_lost, ..Effort::default() };
            if !is_harmless(heard) {
                given.data = None;
            }
        }
        let place = given.pose.map(|pose| (pose.place.lat_deg(), pose.place.lon_deg()));
        let is_there = |area: &Area| place.is_some_and(|(lat, lon)| area.contains_deg(lat, lon));
        self.area.as_ref().is_none_or(is_there).then_some(given)
    }
}

/// Whether the value of a tag's sensor says nothing of the depth.
fn is_harmless(heard: &Heard<'_>) -> bool {
    let kind = heard.tag.map(|tag| tag.sensor_type.to_lowercase()).unwrap_or_default();
    let mut words =
        kind.split(|letter: char| !letter.is_alphanumeric()).filter(|word| !word.is_empty()).peekable();
    words.peek().is_some() && words.all(|word| HARMLESS.contains(&word))
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::formats::unzipped;
    use crate::study::Study;
    use crate::{About, Lag, Writer};
    use api::{RegisterAnimal, RegisterDeployment, RegisterReceiver, RegisterRecord, RegisterTag};
    use detections::{Noise, Origin, Protocol, ReceiverClock};
    use imc::Address;
    use units::{LatLon, UtcTime};

    pub(crate) fn detection(lat_deg: f64, lon_deg: f64) -> Detection {
        Detection {
            origin: Origin {
                system: Address(2_068),
                entity: 1,
                reported: UtcTime::from_micros(1_795_248_001_000_000),
                received: None,
            },
            receiver: 1_024,
            maker: None,
            clock: ReceiverClock::read(1_795_248_000, 7),
            protocol: Protocol::named("S256"),
            tag_id: 101,
            data: Some(42),
            snr_db: Some(20),
            frequency_khz: Some(69),
            line: 5,
            pose: Some(Pose {
                place: LatLon::from_deg(lat_deg, lon_deg).unwrap(),
                age_s: Some(0.25),
                sigma_m: Some(1.5),
            }),
            effort: Effort {
                lines_lost: None,
                noise: Some(Noise { average: 9, peak: 11, age_s: 1.0 }),
                propeller_rpm: Some(77.0),
            },
            raw: Some("$001024,63.4321".to_owned()),
        }
    }

    struct RegisterEntries {
        tag: RegisterTag,
        animal: RegisterAnimal,
    }

    pub(crate) fn study(sensor_type: &str) -> Study {
        let RegisterEntries { tag, animal } = entries(sensor_type);
        Study::new([RegisterRecord::Tag(tag), RegisterRecord::Animal(animal)])
    }

    fn entries(sensor_type: &str) -> RegisterEntries {
        let tag = RegisterTag {
            name: "S256-101".into(),
            protocol: "S256".into(),
            tag_id: Some(101),
            animal: "Fish".into(),
            sensor_type: sensor_type.into(),
            ..RegisterTag::default()
        };
        let animal = RegisterAnimal {
            name: "Fish".into(),
            release_place: "Munkholmen".into(),
            release_lat_deg: Some(63.45),
            release_lon_deg: Some(10.385),
            capture_place: "Korsvika".into(),
            ..RegisterAnimal::default()
        };
        RegisterEntries { tag, animal }
    }

    /// All that the register can know of places.
    fn placed() -> Study {
        let RegisterEntries { tag, animal } = entries("depth");
        let deployment = RegisterDeployment {
            name: "Munkholmen north".into(),
            receiver: "TBR".into(),
            vessel: Some(2_068),
            ..RegisterDeployment::default()
        };
        let receiver =
            RegisterReceiver { name: "TBR".into(), serial: Some(1_024), ..RegisterReceiver::default() };
        let animal = RegisterAnimal { scientific_name: "Salmo salar".into(), ..animal };
        Study::new([
            RegisterRecord::Tag(tag),
            RegisterRecord::Animal(animal),
            RegisterRecord::Receiver(receiver),
            RegisterRecord::Deployment(deployment),
        ])
    }

    fn given(limits: &Limits, study: &Study, one: &Detection) -> Option<Detection> {
        limits.given(&study.heard(one, "otter", Lag::Unknown)).map(Cow::into_owned)
    }

    #[test]
    fn with_coarse_places_nothing_tells_the_place_better_in_any_format() {
        let limits = Limits::new(&[], "", Some(1_000), false).unwrap();
        let study = placed().without_places(1_000);
        let (one, other) = (detection(63.432_123_4, 10.398_765_4), detection(63.439_4, 10.381_2));
        let exact = one.pose.unwrap().place;
        let (one, other) = (given(&limits, &study, &one).unwrap(), given(&limits, &study, &other).unwrap());
        assert_eq!(one, other, "two places in a cell give the same");
        for format in crate::FORMATS {
            if format.is_database() {
                // Written elsewhere, by the values of `lutra`.
                continue;
            }
            let spool = Box::new(std::io::Cursor::new(Vec::new()));
            let mut writer = Writer::new(format, tables::Dialect::Plain).with_spool(spool);
            let mut out = Vec::new();
            writer.header(&mut out).unwrap();
            let begun = out.len();
            writer.row(&mut out, &study.heard(&one, "otter", Lag::Unknown)).unwrap();
            writer.end(&mut out, &study, &About::default()).unwrap();
            if format.ending() == "parquet" {
                // Packed; its values are those of `lutra`, as a test of its own says.
                continue;
            }
            if format.ending() == "nc" {
                let has = |degrees: f64| out.windows(8).any(|bytes| bytes == degrees.to_be_bytes());
                let middle = one.pose.unwrap().place;
                assert!(has(middle.lat_deg()) && has(middle.lon_deg()), "the middle of the cell");
                assert!(!has(exact.lat_deg()) && !has(exact.lon_deg()), "no exact place");
            }
            let text = match format.ending() {
                "zip" => unzipped(&out).into_iter().map(|(_, text)| text).collect(),
                "nc" => String::from_utf8_lossy(&out).into_owned(),
                _ => String::from_utf8(out.split_off(begun)).unwrap(),
            };
            let middle = format!("{:.8}", one.pose.unwrap().place.lat_deg());
            let is_without = ["thelma", "thelma-old", "actel", "actel-biometrics", "yaps", "netcdf"]
                .contains(&format.name);
            assert!(text.contains(&middle) || is_without, "{}: {text}", format.name);
            for told in ["63.4321", "10.3987", "Munkholmen", "Korsvika", "63.45", "10.385", "4242", "77"] {
                assert!(!text.contains(told), "{}: {told} in {text}", format.name);
            }
        }
        assert_eq!(
            given(&limits, &self::study("temperature"), &detection(63.0, 10.0)).unwrap().data,
            Some(42)
        );
    }

    #[test]
    fn a_value_is_given_only_where_every_word_of_the_sensor_is_harmless() {
        let limits = Limits::new(&[], "", Some(1_000), false).unwrap();
        let data = |sensor: &str| given(&limits, &study(sensor), &detection(63.0, 10.0)).unwrap().data;
        for sensor in ["temperature", "Temp", "acceleration / tilt", "Temperatur, aktivitet"] {
            assert_eq!(data(sensor), Some(42), "{sensor}");
        }
        for sensor in [
            "",
            " / ",
            "depth",
            "temperature/depth",
            "temperature,pressure",
            "temp+dybde",
            "depth activity",
            "tempdepth",
            "attemperature",
            "inactivated",
            "temperature2",
            "D-T",
            "temperature (m)",
            "activity sensor",
        ] {
            assert_eq!(data(sensor), None, "{sensor}");
        }
    }

    #[test]
    fn an_area_is_asked_about_the_coarsened_place() {
        let narrow = "63.430,10.30;63.434,10.30;63.434,10.50;63.430,10.50";
        let study = study("");
        let one = detection(63.432, 10.39);
        let exact = Limits::new(&[], narrow, None, false).unwrap();
        assert!(given(&exact, &study, &one).is_some() && exact.hides_neighbours());
        let coarse = Limits::new(&[], narrow, Some(1_000), false).unwrap();
        assert!(given(&coarse, &study, &one).is_none(), "the middle of its cell, 63.435, lies outside");
    }

    #[test]
    fn without_limits_a_detection_is_given_as_it_is() {
        let study = study("");
        let one = detection(63.432, 10.39);
        assert_eq!(given(&Limits::default(), &study, &one).as_ref(), Some(&one));
        let other = Limits::new(&["S256-102".to_owned()], "", None, false).unwrap();
        assert_eq!(given(&other, &study, &one), None);
        for (tags, area, size, named) in [
            (vec!["fish".to_owned()], "", None, "tags: `fish`"),
            (vec![], "1,2", None, "area: "),
            (vec![], "", Some(7), "precision_m: "),
        ] {
            assert!(Limits::new(&tags, area, size, false).unwrap_err().starts_with(named));
        }
    }
}
