//! Tables of portals as ours: animals, tags, receivers and deployments of an ETN data package, and receivers with their
//! deployments as GLATOS has them (1.0). What we have no column for is left out.

use super::Table;
use api::RegisterKind;
use std::collections::BTreeSet;

/// What comes into a column of ours.
enum Take {
    /// A cell as it stands.
    Cell(&'static str),
    /// What stands before the last `-` of a tag's code: `R01M-802761`.
    Protocol(&'static str),
    /// What stands after it.
    Number(&'static str),
    /// The carrier of a code space that names it, kHz: `A69-1303-7`.
    Carrier(&'static str),
    /// Model and serial number, as our receivers are called.
    Receiver(&'static str, &'static str),
    /// `female`, `F` and so on.
    Sex(&'static str),
    /// A value beside its unit, with what makes ours of it; of another unit it stays, with the unit, and is a problem then.
    Measure(&'static str, &'static str, &'static [(&'static str, f64)]),
}

use Take::{Carrier, Cell, Measure, Number, Protocol, Receiver, Sex};

const TO_MM: &[(&str, f64)] = &[("mm", 1.0), ("cm", 10.0), ("m", 1_000.0)];
const TO_G: &[(&str, f64)] = &[("g", 1.0), ("kg", 1_000.0)];

/// A table of a portal.
struct Foreign {
    kind: RegisterKind,
    /// Columns, in lower case, by which it is known.
    known_by: &'static [&'static str],
    /// Ours, with what comes into them.
    columns: &'static [(&'static str, Take)],
}

const FOREIGN: [Foreign; 6] = [
    Foreign {
        kind: RegisterKind::Animal,
        known_by: &["animal_id", "animal_project_code", "scientific_name"],
        columns: &[
            ("name", Cell("animal_id")),
            ("project", Cell("animal_project_code")),
            ("scientific_name", Cell("scientific_name")),
            ("aphia_id", Cell("aphia_id")),
            ("common_name", Cell("common_name")),
            ("length_mm", Measure("length1", "length1_unit", TO_MM)),
            ("length_type", Cell("length1_type")),
            ("weight_g", Measure("weight", "weight_unit", TO_G)),
            ("sex", Sex("sex")),
            ("life_stage", Cell("life_stage")),
            ("capture_time", Cell("capture_date_time")),
            ("capture_place", Cell("capture_location")),
            ("capture_lat_deg", Cell("capture_latitude")),
            ("capture_lon_deg", Cell("capture_longitude")),
            ("release_time", Cell("release_date_time")),
            ("release_place", Cell("release_location")),
            ("release_lat_deg", Cell("release_latitude")),
            ("release_lon_deg", Cell("release_longitude")),
        ],
    },
    Foreign {
        kind: RegisterKind::Tag,
        known_by: &["tag_serial_number", "acoustic_tag_id", "sensor_slope"],
        columns: &[
            ("name", Cell("acoustic_tag_id")),
            ("protocol", Protocol("acoustic_tag_id")),
            ("tag_id", Number("acoustic_tag_id")),
            ("frequency_khz", Carrier("acoustic_tag_id")),
            ("serial", Cell("tag_serial_number")),
            ("manufacturer", Cell("manufacturer")),
            ("model", Cell("model")),
            ("sensor_type", Cell("sensor_type")),
            ("sensor_slope", Cell("sensor_slope")),
            ("sensor_intercept", Cell("sensor_intercept")),
            ("sensor_unit", Cell("sensor_unit")),
            ("interval_min_s", Cell("step1_min_delay")),
            ("interval_max_s", Cell("step1_max_delay")),
        ],
    },
    Foreign {
        kind: RegisterKind::Receiver,
        known_by: &["receiver_id", "receiver_serial_number"],
        columns: &[
            ("name", Cell("receiver_id")),
            ("serial", Cell("receiver_serial_number")),
            ("model", Cell("receiver_model")),
            ("manufacturer", Cell("manufacturer")),
        ],
    },
    Foreign {
        kind: RegisterKind::Deployment,
        known_by: &["deployment_id", "receiver_id", "station_name", "deploy_date_time"],
        columns: &[
            ("name", Cell("deployment_id")),
            ("receiver", Cell("receiver_id")),
            ("vessel", Cell("station_name")),
            ("project", Cell("acoustic_project_code")),
            ("from_time", Cell("deploy_date_time")),
            ("to_time", Cell("recover_date_time")),
            ("depth_m", Cell("deploy_depth")),
            ("lat_deg", Cell("deploy_latitude")),
            ("lon_deg", Cell("deploy_longitude")),
            ("notes", Cell("comments")),
        ],
    },
    Foreign {
        kind: RegisterKind::Receiver,
        known_by: &["glatos_array", "ins_model_no", "ins_serial_no"],
        columns: &[
            ("name", Receiver("ins_model_no", "ins_serial_no")),
            ("serial", Cell("ins_serial_no")),
            ("model", Cell("ins_model_no")),
        ],
    },
    Foreign {
        kind: RegisterKind::Deployment,
        known_by: &["glatos_array", "station", "ins_serial_no", "deploy_date_time"],
        columns: &[
            ("receiver", Receiver("ins_model_no", "ins_serial_no")),
            ("vessel", Cell("station")),
            ("project", Cell("glatos_project")),
            ("from_time", Cell("deploy_date_time")),
            ("to_time", Cell("recover_date_time")),
            ("depth_m", Cell("instrument_depth")),
            ("lat_deg", Cell("deploy_lat")),
            ("lon_deg", Cell("deploy_long")),
            ("notes", Cell("comments")),
        ],
    },
];

/// The table with our columns, where it is one of a portal; else as it is. Lines that say the same as one before are left out.
pub(super) fn ours(kind: RegisterKind, table: Table) -> Table {
    let names: Vec<String> = table.header.iter().map(|name| crate::check::folded(name)).collect();
    let has = |name: &str| names.iter().any(|one| one == name);
    let is_it = |one: &&Foreign| one.kind == kind && one.known_by.iter().all(|name| has(name));
    let Some(found) = FOREIGN.iter().find(is_it) else { return table };
    let columns: Vec<&(&str, Take)> = found.columns.iter().filter(|(_, take)| has(take.column())).collect();
    let decimal = if table.separator == b';' { ',' } else { '.' };
    let mut seen = BTreeSet::new();
    let rows = table.rows.into_iter().filter_map(|(line, cells)| {
        // A line with a cell too many or too few is reported as such, by its count.
        if cells.len() != names.len() {
            let odd = columns.len() + cells.len().abs_diff(names.len());
            return Some((line, vec![String::new(); odd]));
        }
        let cell = |name: &str| {
            let at = names.iter().position(|one| one == name);
            at.and_then(|at| cells.get(at)).map_or("", |text| text.trim())
        };
        let row: Vec<String> = columns.iter().map(|(_, take)| take.of(&cell, decimal)).collect();
        seen.insert(row.clone()).then_some((line, row))
    });
    let rows = rows.collect();
    Table { header: columns.iter().map(|(name, _)| (*name).to_owned()).collect(), rows, ..table }
}

impl Take {
    /// The column without which there is nothing to take.
    fn column(&self) -> &'static str {
        match self {
            Cell(name) | Protocol(name) | Number(name) | Carrier(name) | Sex(name) | Measure(name, ..) => {
                name
            }
            Receiver(_, serial) => serial,
        }
    }

    fn of<'c>(&self, cell: &dyn Fn(&str) -> &'c str, decimal: char) -> String {
        let text = cell(self.column());
        match self {
            Cell(_) => text.to_owned(),
            Protocol(_) => text.rsplit_once('-').map_or(text, |(protocol, _)| protocol).to_owned(),
            Number(_) => text.rsplit('-').next().unwrap_or_default().to_owned(),
            Carrier(_) => {
                let carrier = text.strip_prefix('A').and_then(|rest| rest.split_once('-'));
                let digits = carrier.map_or("", |(khz, _)| khz);
                if digits.bytes().all(|byte| byte.is_ascii_digit()) {
                    digits.to_owned()
                } else {
                    String::new()
                }
            }
            Receiver(model, _) => match cell(model) {
                "" | "NA" => text.to_owned(),
                model => format!("{model}-{text}"),
            },
            Sex(_) => match text.to_lowercase().as_str() {
                "female" | "f" => "F".to_owned(),
                "male" | "m" => "M".to_owned(),
                "unknown" | "u" => "U".to_owned(),
                _ => text.to_owned(),
            },
            Measure(_, unit, factors) => measure(text, cell(unit), factors, decimal),
        }
    }
}

/// A value in our unit.
fn measure(text: &str, unit: &str, factors: &[(&str, f64)], decimal: char) -> String {
    if matches!(text, "" | "NA") {
        return String::new();
    }
    // A spreadsheet with decimal commas shows 1340 as `1.340`, and leaves a text `1.340` of a portal as it is: the reader of
    // numbers asks which of both it is.
    if decimal == ',' && super::has_thousands(text) {
        return text.to_owned();
    }
    let factor = factors.iter().find(|(name, _)| name.eq_ignore_ascii_case(unit)).map(|(_, factor)| *factor);
    match (factor, text.replacen(decimal, ".", 1).parse::<f64>()) {
        // As it stands: a product has crumbs.
        (Some(1.0), _) => text.to_owned(),
        (Some(factor), Ok(value)) => {
            let product = (value * factor * 1e6).round() / 1e6;
            product.to_string().replacen('.', &decimal.to_string(), 1)
        }
        _ => format!("{text} {unit}"),
    }
}

#[cfg(test)]
mod tests {
    use crate::csv::{Names, read_csv};
    use crate::{Read, check_all};
    use api::{RegisterKind, RegisterRecord};

    const STATION: u16 = 0x1C01;

    fn read(kind: RegisterKind, text: &str) -> Read {
        let address = |name: &str| match name {
            "ws-Pier" => Ok(STATION),
            _ => Err(api::Said::as_is(format!("no vessel is called {name}"))),
        };
        read_csv(kind, text.as_bytes(), &[], &Names { address: &address, name: &|_| String::new() })
    }

    fn records(kind: RegisterKind, text: &str) -> Vec<RegisterRecord> {
        let read = read(kind, text);
        assert_eq!(read.wrong, [], "{text}");
        read.rows.into_iter().map(|row| row.record).collect()
    }

    #[test]
    fn a_data_package_of_etn_is_the_register_of_a_study() {
        let animals = "animal_id,animal_project_code,tag_serial_number,acoustic_tag_id,scientific_name,aphia_id,length1,length1_type,length1_unit,weight,weight_unit,sex,life_stage,capture_date_time,release_date_time,release_location,release_latitude,release_longitude,rearing\n305,,1187450,A69-1601-16130,Rutilus rutilus,154333,33.6,total length,cm,607,g,female,adult,2014-06-11T00:00:00Z,2014-06-11T12:00:00Z,Herk,50.9,5.1,no\n";
        let [RegisterRecord::Animal(one)] = &records(RegisterKind::Animal, animals)[..] else { panic!() };
        assert_eq!(
            (&*one.name, one.length_mm, one.weight_g, &*one.sex),
            ("305", Some(336.0), Some(607.0), "F")
        );
        assert_eq!(
            (&*one.release_place, one.release_lat_deg, one.aphia_id),
            ("Herk", Some(50.9), Some(154_333))
        );
        assert_eq!(one.release_us, Some(1_402_488_000_000_000));
        let tags = "tag_serial_number,tag_type,acoustic_tag_id,manufacturer,model,sensor_slope,sensor_intercept,sensor_unit,step1_min_delay,step1_max_delay\n1187450,acoustic,A69-1601-16130,VEMCO,V13-1x,NA,NA,,80,160\n7,acoustic,R01M-802761,THELMA,D,0.2,-1,m,,\n";
        let [RegisterRecord::Tag(one), RegisterRecord::Tag(other)] = &records(RegisterKind::Tag, tags)[..]
        else {
            panic!()
        };
        assert_eq!((&*one.protocol, one.tag_id, one.frequency_khz), ("A69-1601", Some(16_130), Some(69)));
        assert_eq!((one.sensor_slope, one.interval_max_s, &*one.serial), (None, Some(160.0), "1187450"));
        assert_eq!(
            (&*other.protocol, other.tag_id, other.frequency_khz, other.sensor_slope),
            ("R01M", Some(802_761), None, Some(0.2))
        );
        let receivers = "receiver_id,manufacturer,receiver_model,receiver_serial_number,modem_address,status\nVR2W-109924,VEMCO,VR2W,109924,,broken\n";
        let mut all = records(RegisterKind::Receiver, receivers);
        let deployments = "deployment_id,receiver_id,acoustic_project_code,station_name,deploy_date_time,deploy_latitude,deploy_longitude,deploy_depth,recover_date_time,comments\n1437,VR2W-109924,,ws-Pier,2014-05-10T13:15:00Z,50.95,5.08,2.5,2014-09-01T00:00:00Z,on a buoy\n";
        all.extend(records(RegisterKind::Deployment, deployments));
        assert_eq!(check_all(&all), []);
        let RegisterRecord::Deployment(one) = &all[1] else { panic!() };
        assert_eq!(
            (one.vessel, one.lat_deg, one.lon_deg, one.depth_m),
            (Some(STATION), Some(50.95), Some(5.08), Some(2.5))
        );
        assert!(one.from_us < one.to_us && one.notes == "on a buoy");
    }

    #[test]
    fn a_number_that_can_be_two_is_asked_for_and_a_decimal_is_what_it_says() {
        let weigh = |separator: &str, weight: &str, unit: &str| {
            let cells = ["animal_id", "animal_project_code", "scientific_name", "weight", "weight_unit"];
            let row = ["A", "", "Salmo salar", weight, unit].join(separator);
            let read = read(RegisterKind::Animal, &format!("{}\n{row}\n", cells.join(separator)));
            let wrong = read.wrong.first().map(|one| (one.column.clone(), one.text.to_string()));
            let weight_g = read.rows.into_iter().find_map(|row| match row.record {
                RegisterRecord::Animal(one) => one.weight_g,
                _ => None,
            });
            (weight_g, wrong)
        };
        // Commas between cells: decimal points, as portals write them.
        assert_eq!(weigh(",", "1.340", "kg"), (Some(1_340.0), None));
        assert_eq!(weigh(",", "1.340", "g"), (Some(1.34), None));
        // Semicolons: a spreadsheet with decimal commas, where `1.340` is 1340, or a text that it left.
        assert_eq!(weigh(";", "1,340", "kg"), (Some(1_340.0), None));
        assert_eq!(weigh(";", "33.6", "g"), (Some(33.6), None));
        for unit in ["kg", "g"] {
            let (weight_g, wrong) = weigh(";", "1.340", unit);
            let (column, text) = wrong.unwrap();
            assert_eq!((weight_g, &*column), (None, "weight_g"));
            assert!(text.contains("`1.340` can be 1340 or 1,340 here"), "{text}");
        }
    }

    #[test]
    fn stations_of_glatos_are_receivers_and_their_deployments() {
        let text = "station,glatos_array,station_no,consecutive_deploy_no,deploy_lat,deploy_long,deploy_date_time,recover_date_time,instrument_depth,ins_model_no,ins_serial_no,comments\nws-Pier,WHT,1,1,44.1,-83.2,2011-03-11 16:00:00,2011-06-01 10:00:00,3,VR2W,109924,\nws-Pier,WHT,1,2,44.1,-83.2,2011-07-11 16:00:00,NA,3,VR2W,109924,\n";
        let mut all = records(RegisterKind::Receiver, text);
        assert_eq!(all.len(), 1, "a receiver once");
        all.extend(records(RegisterKind::Deployment, text));
        assert_eq!((all.len(), check_all(&all)), (3, Vec::new()));
    }

    #[test]
    fn a_bad_line_of_a_portal_is_told_by_our_column_and_its_line() {
        let text = "animal_id,animal_project_code,scientific_name,length1,length1_unit\nA,,Salmo salar,12,inch\nB,,Salmo salar,7\nC,,Salmo salar,8,cm\n";
        let read = read(RegisterKind::Animal, text);
        let told: Vec<_> =
            read.wrong.iter().map(|one| (one.line, &*one.column, one.text.to_string())).collect();
        assert_eq!((told.len(), read.rows.len()), (2, 1), "{told:?}");
        assert!(
            told[0].0 == 2 && told[0].1 == "length_mm" && told[0].2.contains("`12 inch` is not a number"),
            "{told:?}"
        );
        assert!(told[1].0 == 3 && told[1].2.contains("cells"), "{told:?}");
    }
}
