//! Grids of currents in CSV and NetCDF, whole, damaged and of any bytes.

use geofile::currents::{CurrentField, read};
use proptest::prelude::*;

const CSV: &str = "time,lat,lon,east_mps,north_mps
2026-11-21T06:00:00Z,63.0,10.0,0.1,-0.1
2026-11-21T06:00:00Z,63.0,10.2,0.2,-0.1
2026-11-21T06:00:00Z,63.1,10.0,0.3,-0.1
2026-11-21T06:00:00Z,63.1,10.2,,
2026-11-21T08:00:00+01:00,63.0,10.0,0.5,0
2026-11-21T07:00:00Z,63.0,10.2,0.6,0
2026-11-21T07:00:00Z,63.1,10.2,0.8,0
";

#[test]
fn csv_gives_a_grid_whatever_the_order_of_its_lines_and_columns() {
    let field = read(CSV.as_bytes()).unwrap();
    assert_eq!((field.lats_deg, field.lons_deg), (vec![63.0, 63.1], vec![10.0, 10.2]));
    assert!((field.times_s[1] - field.times_s[0] - 3_600.0).abs() < 1e-3);
    let east = field.east_mps;
    assert_eq!(east[..3], [0.1, 0.2, 0.3]);
    assert!(east[3].is_nan() && east[6].is_nan(), "an empty value, and a line that is missing");
    assert_eq!((east[4], east[5], east[7]), (0.5, 0.6, 0.8));
    let swapped: Vec<String> =
        CSV.lines().map(|line| line.split(',').rev().collect::<Vec<_>>().join(",")).collect();
    let reversed = read(
        format!("{}\n{}", swapped[0], swapped[1..].iter().rev().cloned().collect::<Vec<_>>().join("\r\n"))
            .as_bytes(),
    );
    assert_eq!(reversed.unwrap().east_mps[..3], [0.1, 0.2, 0.3]);
}

#[test]
fn csv_that_is_not_a_grid_is_refused_with_its_line_and_the_remedy() {
    let row = |row: &str| format!("time,lat,lon,east_mps,north_mps\n\n{row}\n");
    for (text, part) in [
        (String::new(), "line 1: the heading has no column time"),
        ("time,lat,lon,u,v\n".to_owned(), "line 1: the heading has no column east_mps"),
        (row("yesterday,63,10,0,0"), "line 3: time: yesterday is not a time such as"),
        (row("2026-11-21T06:00:00Z,93,10,0,0"), "line 3: lat: 93 is not within -90 to 90"),
        (row("2026-11-21T06:00:00Z,63,x,0,0"), "line 3: lon: x is not within"),
        (row("2026-11-21T06:00:00Z,63,10,fast,0"), "line 3: east_mps: fast is not a speed"),
        (row("2026-11-21T06:00:00Z,63,10"), "line 3: there is no east_mps: it has 3 columns"),
        (row("2026-11-21T06:00:00Z,63,10,0,0"), "has 1 latitudes and 1 longitudes"),
        (
            format!("{CSV}2026-11-21T07:00:00Z,63.1,10.2,0.8,0\n"),
            "line 9: the same time and place as in line 8",
        ),
    ] {
        let error = read(text.as_bytes()).unwrap_err().to_string();
        assert!(error.contains(part), "{error}");
    }
    let line = |n: i32| {
        let (lat, lon) = (63.0 + f64::from(n) / 100.0, 10.0 + f64::from(n) / 90.0);
        format!("2026-11-21T06:{n:02}:00Z,{lat},{lon},0,0\n")
    };
    let scattered = (0..40).map(line).collect::<Vec<_>>().concat();
    let error =
        read(format!("time,lat,lon,east_mps,north_mps\n{scattered}").as_bytes()).unwrap_err().to_string();
    assert!(error.contains("64000 crossings, and the file has 40 lines"), "{error}");
    assert!(read(&[0xff, 0xfe, 0]).unwrap_err().to_string().contains("neither NetCDF nor text"));
}

/// A file of the classic format, written from its grammar: what is filled up to four bytes, and where variables begin.
#[expect(clippy::struct_excessive_bools, reason = "each is a way in which a file may differ")]
#[derive(Clone)]
struct Classic {
    wide: bool,
    /// Whether time is the dimension of records.
    records: bool,
    depths: u32,
    falling: bool,
    packed: bool,
    units: &'static str,
    names: [&'static str; 2],
    standard: bool,
    /// The `standard_name` of the component to the east, if it is not the one of a current.
    eastward: Option<&'static str>,
    calendar: Option<&'static str>,
    /// Numbers beside those of packing: of which variable, its name, and its values.
    more: &'static [(usize, &'static str, &'static [f64])],
    fill: bool,
}

const PLAIN: Classic = Classic {
    wide: false,
    records: false,
    depths: 0,
    falling: false,
    packed: false,
    units: "m s-1",
    names: ["u", "v"],
    standard: false,
    eastward: None,
    calendar: None,
    more: &[],
    fill: true,
};

fn word(out: &mut Vec<u8>, value: usize) {
    out.extend((value as u32).to_be_bytes());
}

fn name(out: &mut Vec<u8>, name: &str) {
    word(out, name.len());
    out.extend(name.as_bytes());
    out.resize(out.len().next_multiple_of(4), 0);
}

impl Classic {
    /// Two times, two latitudes, three longitudes; to the east 0.01 × place in the file, its second value missing.
    fn bytes(&self) -> Vec<u8> {
        let sized = self.header(&[0; 6]).len();
        let values = self.values();
        let mut begins = [0; 6];
        let (mut fixed, mut record_at) = (sized, sized);
        for (number, (_, of_records, bytes)) in values.iter().enumerate() {
            if !of_records {
                begins[number] = fixed;
                fixed += bytes.len().next_multiple_of(4);
            }
        }
        record_at += fixed - sized;
        for (number, (_, of_records, bytes)) in values.iter().enumerate() {
            if *of_records {
                begins[number] = record_at;
                record_at += (bytes.len() / 2).next_multiple_of(4);
            }
        }
        let mut out = self.header(&begins);
        let fill = |out: &mut Vec<u8>| out.resize(out.len().next_multiple_of(4), 0);
        for (_, _, bytes) in values.iter().filter(|(_, of_records, _)| !of_records) {
            out.extend(bytes);
            fill(&mut out);
        }
        for half in 0..2 {
            for (_, _, bytes) in values.iter().filter(|(_, of_records, _)| *of_records) {
                let size = bytes.len() / 2;
                out.extend(&bytes[half * size..][..size]);
                fill(&mut out);
            }
        }
        out
    }

    /// Of each variable its name, whether it is of records, and its values.
    fn values(&self) -> [(&'static str, bool, Vec<u8>); 6] {
        let doubles =
            |values: &[f64]| values.iter().flat_map(|value| value.to_be_bytes()).collect::<Vec<u8>>();
        let lats = if self.falling { [63.1, 63.0] } else { [63.0, 63.1] };
        let depths: Vec<f64> = (0..self.depths).map(|n| 30.0 - 10.0 * f64::from(n)).collect();
        let component = |scale: f64| {
            let count = 12 * self.depths.max(1);
            let each = (0..count).flat_map(|n| {
                let value = if n == 1 { 9_999.0 } else { scale * f64::from(n) };
                if self.packed {
                    ((value * if n == 1 { 1.0 } else { 1_000.0 }).round() as i16).to_be_bytes().to_vec()
                } else {
                    (value as f32).to_be_bytes().to_vec()
                }
            });
            each.collect::<Vec<u8>>()
        };
        [
            ("time", self.records, doubles(&[0.0, 1.5])),
            ("depth", false, doubles(&depths)),
            ("lat", false, doubles(&lats)),
            ("lon", false, doubles(&[10.0, 10.1, 10.2])),
            (self.names[0], self.records, component(0.01)),
            (self.names[1], self.records, component(-0.01)),
        ]
    }

    fn header(&self, begins: &[usize; 6]) -> Vec<u8> {
        let mut out = if self.wide { b"CDF\x02".to_vec() } else { b"CDF\x01".to_vec() };
        word(&mut out, if self.records { 2 } else { 0 });
        word(&mut out, 0x0A);
        word(&mut out, 4);
        for (dimension, length) in [
            ("time", if self.records { 0 } else { 2 }),
            ("depth", self.depths.max(1) as usize),
            ("lat", 2),
            ("lon", 3),
        ] {
            name(&mut out, dimension);
            word(&mut out, length);
        }
        word(&mut out, 0);
        word(&mut out, 0);
        word(&mut out, 0x0B);
        word(&mut out, 6);
        for (number, (variable, _, values)) in self.values().iter().enumerate() {
            name(&mut out, variable);
            let over: &[usize] = match number {
                4 | 5 if self.depths > 0 => &[0, 1, 2, 3],
                4 | 5 => &[0, 2, 3],
                0 => &[0],
                1 => &[1],
                2 => &[2],
                _ => &[3],
            };
            word(&mut out, over.len());
            for dimension in over {
                word(&mut out, *dimension);
            }
            let mut texts = Vec::new();
            match number {
                0 => {
                    texts.push(("units", "hours since 2026-11-21 06:00:00"));
                    texts.extend(self.calendar.map(|calendar| ("calendar", calendar)));
                }
                2 => texts.push(("units", "degrees_north")),
                3 => texts.push(("units", "degrees_east")),
                4 | 5 => {
                    texts.push(("units", self.units));
                    if let Some(name) = self.eastward.filter(|_| number == 4) {
                        texts.push(("standard_name", name));
                    } else if self.standard {
                        texts.push((
                            "standard_name",
                            if number == 4 {
                                "eastward_sea_water_velocity"
                            } else {
                                "northward_sea_water_velocity"
                            },
                        ));
                    }
                }
                _ => {}
            }
            let mut numbers: Vec<(&str, &[f64])> = match (number, self.packed) {
                (4 | 5, true) => vec![("scale_factor", &[0.001][..]), ("_FillValue", &[9_999.0][..])],
                (4 | 5, false) => vec![("_FillValue", &[9_999.0][..])],
                _ => vec![],
            };
            numbers.retain(|(name, _)| self.fill || *name != "_FillValue");
            let more = self.more.iter().filter(|(of, _, _)| *of == number);
            numbers.extend(more.map(|(_, name, values)| (*name, *values)));
            word(&mut out, 0x0C);
            word(&mut out, texts.len() + numbers.len());
            for (attribute, text) in texts {
                name(&mut out, attribute);
                word(&mut out, 2);
                name(&mut out, text);
            }
            for (attribute, values) in numbers {
                name(&mut out, attribute);
                word(&mut out, 6);
                word(&mut out, values.len());
                for value in values {
                    out.extend(value.to_be_bytes());
                }
            }
            word(
                &mut out,
                if number < 4 {
                    6
                } else if self.packed {
                    3
                } else {
                    5
                },
            );
            word(&mut out, values.len());
            if self.wide {
                word(&mut out, 0);
            }
            word(&mut out, begins[number]);
        }
        out
    }
}

fn is_as_written(field: &CurrentField, written: &Classic) {
    assert_eq!((&field.lats_deg, &field.lons_deg), (&vec![63.0, 63.1], &vec![10.0, 10.1, 10.2]));
    assert!((field.times_s[1] - field.times_s[0] - 5_400.0).abs() < 1e-3);
    let begins_s = "2026-11-21T06:00:00Z".parse::<units::UtcTime>().unwrap().seconds();
    assert!((field.times_s[0] - begins_s).abs() < 1e-3);
    // The last of the depths is nearest to the surface.
    let levels = written.depths.max(1) as usize;
    for (at, (east, north)) in field.east_mps.iter().zip(&field.north_mps).enumerate() {
        let (step, row, column) = (at / 6, at / 3 % 2, at % 3);
        let row = if written.falling { 1 - row } else { row };
        let number = (step * levels + levels - 1) * 6 + row * 3 + column;
        if number == 1 {
            assert!(east.is_nan() && north.is_nan());
        } else {
            let expected = 0.01 * number as f32;
            assert!(
                (east - expected).abs() < 1e-5 && (north + expected).abs() < 1e-5,
                "{at}: {east} {north} {expected}"
            );
        }
    }
}

#[test]
fn netcdf_of_either_offset_with_and_without_records_depths_and_packing_gives_the_grid() {
    for bits in 0..64_u8 {
        let bit = |n: u8| bits >> n & 1 == 1;
        let file = Classic {
            wide: bit(0),
            records: bit(1),
            depths: if bit(2) { 3 } else { 0 },
            falling: bit(3),
            packed: bit(4),
            standard: bit(5),
            names: if bit(5) { ["x_sea", "y_sea"] } else { ["u", "v"] },
            ..PLAIN
        };
        is_as_written(&read(&file.bytes()).unwrap(), &file);
    }
}

#[test]
fn netcdf_that_cannot_be_read_says_why_and_what_to_do() {
    let of = |file: Classic| read(&file.bytes()).unwrap_err().to_string();
    assert!(of(Classic { names: ["p", "q"], ..PLAIN }).contains("there is no eastward current"));
    assert!(of(Classic { units: "knots", ..PLAIN }).contains("u is in knots; give m s-1"));
    assert!(read(b"\x89HDF\r\n\x1a\n").unwrap_err().to_string().contains("nccopy -k classic"));
    assert!(read(b"CDF\x05\0\0\0\0").unwrap_err().to_string().contains("nccopy -k classic"));
    // A file with a heading of records, and no record.
    let mut empty = Classic { records: true, falling: true, ..PLAIN }.bytes();
    empty[4..8].fill(0);
    assert!(read(&empty).unwrap_err().to_string().contains("it has no values"));
    let whole = Classic { records: true, ..PLAIN }.bytes();
    for cut in 0..whole.len() {
        assert!(read(&whole[..cut]).is_err(), "cut at {cut}");
    }
}

#[test]
fn netcdf_of_wind_or_another_calendar_is_refused_by_name() {
    let of = |file: Classic| read(&file.bytes()).unwrap_err().to_string();
    let wind = of(Classic { eastward: Some("eastward_wind"), ..PLAIN });
    assert!(wind.contains("there is no eastward current"), "{wind}");
    let days = of(Classic { calendar: Some("360_day"), ..PLAIN });
    assert!(days.contains("time counts in the calendar 360_day; give times in the standard"), "{days}");
    is_as_written(&read(&Classic { calendar: Some("gregorian"), ..PLAIN }.bytes()).unwrap(), &PLAIN);
}

#[test]
fn netcdf_coordinates_are_unpacked_and_values_out_of_their_valid_range_are_missing() {
    let packed: &[(usize, &str, &[f64])] = &[(3, "scale_factor", &[2.0]), (3, "add_offset", &[-10.0])];
    let field = read(&Classic { more: packed, ..PLAIN }.bytes()).unwrap();
    for (found, stored) in field.lons_deg.iter().zip([10.0, 10.1, 10.2]) {
        assert!((found - (2.0 * stored - 10.0)).abs() < 1e-9, "{found}");
    }
    // East is 0.01 × place in the file: values 0, 2 and 3 are within, the second one is filled.
    let range: &[(usize, &str, &[f64])] = &[(4, "valid_range", &[-1.0, 0.035])];
    let most: &[(usize, &str, &[f64])] = &[(4, "valid_min", &[-1.0]), (4, "valid_max", &[0.035])];
    for more in [range, most] {
        let east = read(&Classic { more, ..PLAIN }.bytes()).unwrap().east_mps;
        let known: Vec<bool> = east[..6].iter().map(|mps| !mps.is_nan()).collect();
        assert_eq!(known, [true, false, true, true, false, false]);
    }
}

#[test]
fn netcdf_shorts_that_were_never_written_are_missing() {
    let file = Classic { packed: true, fill: false, ..PLAIN };
    let mut bytes = file.bytes();
    // The second value of both components, 9999 in the file: as the library of the format leaves it.
    let filled = 9_999_i16.to_be_bytes();
    let found: Vec<usize> = (0..bytes.len() - 1).filter(|at| bytes[*at..at + 2] == filled).collect();
    assert_eq!(found.len(), 2);
    for at in found {
        bytes[at..at + 2].copy_from_slice(&(-32_767_i16).to_be_bytes());
    }
    is_as_written(&read(&bytes).unwrap(), &file);
}

proptest! {
    #[test]
    fn a_damaged_file_is_read_or_refused_in_words(at in 0..700_usize, byte: u8, records: bool) {
        let mut bytes = Classic { records, ..PLAIN }.bytes();
        let at = at % bytes.len();
        bytes[at] = byte;
        match read(&bytes) {
            Ok(field) => {
                let crossings = field.times_s.len() * field.lats_deg.len() * field.lons_deg.len();
                prop_assert_eq!(field.east_mps.len(), crossings);
            }
            Err(error) => prop_assert!(!error.to_string().is_empty()),
        }
    }
}

#[test]
fn the_seed_of_the_fuzz_target_is_such_a_file() {
    let seeds = testkit::repository().join("fuzz/seeds/geofile");
    let file = Classic { records: true, packed: true, standard: true, ..PLAIN };
    if std::env::var_os("LUTRA_WRITE_SEEDS").is_some() {
        std::fs::write(seeds.join("currents.nc"), file.bytes()).unwrap();
        std::fs::write(seeds.join("currents.csv"), CSV).unwrap();
    }
    is_as_written(&read(&std::fs::read(seeds.join("currents.nc")).unwrap()).unwrap(), &file);
    assert_eq!(read(&std::fs::read(seeds.join("currents.csv")).unwrap()).unwrap().lons_deg, [10.0, 10.2]);
}
